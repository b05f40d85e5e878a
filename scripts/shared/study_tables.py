"""Tables of a study file, and of the measures of a run, for docs/studies.md."""

from __future__ import annotations

from scripts.shared.job_tables import sections
from weavesim.study.measures import STUDY_FINDINGS
from weavesim.study.schema import MeasureTable, NoiseTable, StudyTable, VaryTable

SECTIONS = (
    ("Top of the file", StudyTable), ("[[vary]]", VaryTable), ("[[measure]]", MeasureTable), ("[noise]", NoiseTable),
)  # fmt: skip


def tables() -> str:
    """The keys, and the measures that only studies have."""
    rows = [f"| `{finding.name}` | {finding.unit.symbol} | {finding.description} |" for finding in STUDY_FINDINGS]
    head = "### Measures\n\nBesides all numbers of a summary ([results.md](results.md)):\n\n"
    return (
        sections(SECTIONS, frozenset({"scatter", "limits"}))
        + "\n"
        + head
        + "| measure | unit | what it is |\n|---|---|---|\n"
        + "\n".join(rows)
        + "\n"
    )
