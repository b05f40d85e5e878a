"""The verdict on a case."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ..shared.report import table
from .cases import CASES
from .differences import Difference, differences
from .reading import other_files, read_results


@dataclass
class Verdict:
    """Result of the comparison of a case."""

    case: str
    entry_count: int = 0
    seconds: float = math.nan
    found: list[Difference] = field(default_factory=list)
    changed_files: list[str] = field(default_factory=list)
    file_count: int = 0
    failure: str | None = None

    @property
    def same(self) -> bool:
        return not self.found and self.failure is None

    @property
    def wrong(self) -> bool:
        """Whether something differs that was not changed deliberately."""
        return self.failure is not None or bool(self.found and not self.changed)

    @property
    def changed(self) -> str:
        """What was changed deliberately; empty for a case that is not in ``CASES``."""
        return CASES[self.case].changed if self.case in CASES else ""

    def row(self) -> list[str]:
        if self.failure is not None:
            result = f"FAILED: {self.failure}"
        else:
            result = "same" if self.same else f"DIFFERENT ({len(self.found)} entries)"
            if self.changed and not self.same:
                result = f"changed on purpose ({len(self.found)} entries): {self.changed}"
        files = f"{len(self.changed_files)} of {self.file_count} differ: {self.changed_files[0]}" if (
            self.changed_files
        ) else "same"  # fmt: skip
        first = str(self.found[0]) if self.found else ""
        return [self.case, str(self.entry_count), f"{self.seconds:.0f}", result, first, files]


def compare(case: str, reference: Path, here: Path) -> Verdict:
    """Compare the results in two folders."""
    before, after = read_results(reference), read_results(here)
    files, files_after = other_files(reference), other_files(here)
    changed = [name for name in files | files_after if files.get(name) != files_after.get(name)]
    return Verdict(
        case, len(before), found=differences(before, after), changed_files=changed, file_count=len(files | files_after)
    )


def verdict_table(verdicts: Sequence[Verdict]) -> str:
    """A Markdown table of all cases."""
    head = ["case", "entries", "seconds", "results", "first difference", "film, series, pictures"]
    return table(head, [verdict.row() for verdict in verdicts])
