"""The results of a run, for its writers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..measures.angles import locate
from ..measures.findings import SHEET_FINDINGS, FormedSheet, found
from ..process.motions.paths import Place
from ..run.frame import Frame, Outcome, RunInfo, SheetFrame, SheetInfo
from ..run.staging.part import part_of
from ..tools.tool import Tool
from .curves import Curves, LastCurve
from .files import file_endings
from .history import History


@dataclass(frozen=True)
class Wanted:
    """What a scene wants to show in addition to the standard results.

    Attributes:
        points: material points at which the shear angle is of interest, (k, 2) [m]; None for none.
        measured_angles: measured point numbers and angles [degrees], drawn next to the computed ones.
        measured_outline: a measured outline in plan (k, 2) [m], drawn next to the computed one.
        curves: the scene's own numbers for every frame, written to a separate CSV and charts.
        last_curve: a curve of the last frame, written in the same way.
        draw_in: whether draw-in of the border is meaningful.

    Raises:
        InputError: angles were measured at a point that is not given.
    """

    points: np.ndarray | None = None
    measured_angles: tuple[np.ndarray, np.ndarray] | None = None
    measured_outline: np.ndarray | None = None
    curves: Curves | None = None
    last_curve: LastCurve | None = None
    draw_in: bool = True

    def __post_init__(self) -> None:
        if self.measured_angles is not None:
            point_count = 0 if self.points is None else len(self.points)
            if max(self.measured_angles[0], default=0) > point_count:
                raise InputError(
                    f"measured angles: point {max(self.measured_angles[0])} is given, but the run has {point_count} "
                    "points"
                )

    @property
    def all_curves(self) -> tuple[Curves, ...]:
        """Those that are recorded."""
        return tuple(curves for curves in (self.curves, self.last_curve) if curves is not None)

    def check(self, sheets: Iterable[SheetInfo]) -> None:
        """Check before a run that its sheets contain the points.

        Raises:
            InputError: a point outside a sheet.
        """
        if self.points is not None:
            for sheet in sheets:
                locate(sheet.blank, self.points)


@dataclass(frozen=True)
class SheetResult:
    """One sheet at the last frame.

    Attributes:
        info: known before the run, without what was trimmed since.
        formed: the formed sheet and its measures.
        ending: suffix of its file names; "" for the only sheet.
        tools: name, tool and place of each tool that it may touch and that acts.
        elements: places of its elements among those of the whole sheet, of which a stage may have trimmed some, (k,).
        whole_count: elements of that.
    """

    info: SheetInfo
    formed: FormedSheet
    ending: str
    tools: tuple[tuple[str, Tool, Place], ...]
    elements: np.ndarray
    whole_count: int

    def in_whole(self, values: np.ndarray) -> np.ndarray:
        """Values of its elements as those of the whole sheet, not a number where it has been trimmed."""
        whole = np.full(self.whole_count, np.nan)
        whole[self.elements] = values
        return whole

    def file(self, name: str) -> str:
        """File name for this sheet: "draw_in.csv" becomes "draw_in_upper.csv" if there are several."""
        path = Path(name)
        return f"{path.stem}{self.ending}{path.suffix}"

    def findings(self, failed: Callable[[str, Exception], object] | None = None) -> dict[str, Any]:
        """Numbers of the sheet, by key; ``failed`` is told those that fail."""
        return found(SHEET_FINDINGS, self.formed, failed)


@dataclass
class Results:
    """Results of a run that has ended, or up to the current frame.

    Attributes:
        info: about the run.
        wanted: what the scene wants to show.
        history: scalars of all frames.
        sheets: at the last frame.
        summary: all numbers, without the warnings of the writers.
        setup: the options given by the user, by name, for the report.
        failures: messages about what could not be written; writers add to it.
        missing: names of what could not be written.
        pictures: files that were drawn, with captions; writers add to it.
    """

    info: RunInfo
    wanted: Wanted
    history: History
    sheets: tuple[SheetResult, ...]
    summary: dict[str, Any]
    setup: Mapping[str, Any]
    failures: list[str]
    missing: list[str] = field(default_factory=list)
    pictures: list[tuple[Path, str]] = field(default_factory=list)

    @property
    def warnings(self) -> list[str]:
        """Warnings of the run, and failures to write so far."""
        return [*map(str, self.summary.get("warnings") or ()), *self.failures]

    @property
    def whole_summary(self) -> dict[str, Any]:
        """``summary`` with all warnings, and what is missing."""
        return {**self.summary, "missing": list(dict.fromkeys(self.missing)), "warnings": self.warnings}


def sheet_results(info: RunInfo, wanted: Wanted, frame: Frame) -> tuple[SheetResult, ...]:
    """Results of every sheet of ``frame``."""
    parts = zip(info.sheets, frame.sheets, file_endings(info), strict=True)
    return tuple(_sheet_result(info, wanted, frame, *part) for part in parts)


def _sheet_result(
    info: RunInfo, wanted: Wanted, frame: Frame, sheet: SheetInfo, state: SheetFrame, ending: str
) -> SheetResult:
    whole_count = sheet.blank.element_count
    elements = np.flatnonzero(state.kept) if len(state.kept) else np.arange(whole_count)
    sheet, state = part_of(sheet, state)
    formed = FormedSheet(
        sheet.blank, state.position, state.fields, sheet.fabric.thickness, sheet.symmetry, wanted.points,
        wanted.draw_in, sheet.follows_thickness,
    )  # fmt: skip
    acting = (k for k in sheet.tools if frame.acts(k))
    tools = tuple((info.tool_names[k], info.tools[k], frame.place(k)) for k in acting)
    return SheetResult(sheet, formed, ending, tools, elements, whole_count)


def run_summary(
    sheets: tuple[SheetResult, ...],
    outcome: Outcome | None,
    frame_count: int,
    given: Mapping[str, Any],
    failed: Callable[[str, Exception], object] | None = None,
) -> dict[str, Any]:
    """Findings of the sheet and ``given`` numbers of the run; several sheets are in a list ``sheets``.

    ``failed`` is told the findings that fail.
    """
    own: dict[str, Any] = {"outcome": outcome.value if outcome else "running", "frame_count": frame_count}
    if len(sheets) == 1:
        return {**own, **sheets[0].findings(failed), **given}
    return {**own, **given, "sheets": [{"name": sheet.info.name, **sheet.findings(failed)} for sheet in sheets]}
