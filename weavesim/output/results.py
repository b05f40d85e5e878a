"""What a run has come to, for the writers of its results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..measures.angles import locate
from ..measures.findings import SHEET_FINDINGS, FormedSheet, found
from ..run.frame import Frame, Outcome, RunInfo, SheetFrame, SheetInfo
from ..tools.tool import Tool
from .curves import Curves
from .files import file_endings
from .history import History


@dataclass(frozen=True)
class Wanted:
    """What a scene wants to be shown besides what every run shows.

    Attributes:
        points: material points at which the shear angle is of interest, (k, 2) [m]; None for none.
        measured_angles: measured point numbers and angles [degrees] to draw beside the computed ones.
        measured_outline: a measured outline in plan (k, 2) [m] to draw beside the computed one.
        curves: the scene's own numbers of every frame, for a CSV and charts of their own.
        draw_in: whether the movement of the border inwards means something.

    Raises:
        InputError: angles were measured at a point that is not given.
    """

    points: np.ndarray | None = None
    measured_angles: tuple[np.ndarray, np.ndarray] | None = None
    measured_outline: np.ndarray | None = None
    curves: Curves | None = None
    draw_in: bool = True

    def __post_init__(self) -> None:
        if self.measured_angles is not None:
            point_count = 0 if self.points is None else len(self.points)
            if max(self.measured_angles[0], default=0) > point_count:
                raise InputError(
                    f"measured angles: point {max(self.measured_angles[0])} is given, but the run has {point_count} "
                    "points"
                )

    def check(self, info: RunInfo) -> None:
        """See before a run that its sheets hold the points.

        Raises:
            InputError: a point outside a sheet.
        """
        if self.points is not None:
            for sheet in info.sheets:
                locate(sheet.blank, self.points)


@dataclass(frozen=True)
class SheetResult:
    """One sheet at the last frame.

    Attributes:
        info: what is known before the run.
        formed: what is read off it.
        ending: of the names of its files; "" for the only sheet.
        tools: name, tool and displacement [m] of each that it may touch.
    """

    info: SheetInfo
    formed: FormedSheet
    ending: str
    tools: tuple[tuple[str, Tool, float], ...]

    def file(self, name: str) -> str:
        """``name`` for this sheet: "draw_in.csv" to "draw_in_upper.csv" where there are several."""
        path = Path(name)
        return f"{path.stem}{self.ending}{path.suffix}"

    @property
    def findings(self) -> dict[str, Any]:
        """Numbers of the sheet, by their keys."""
        return found(SHEET_FINDINGS, self.formed)


@dataclass
class Results:
    """A run that has ended, or has come to a frame.

    Attributes:
        info: what is run.
        wanted: what the scene wants to be shown.
        history: scalars of all frames.
        sheets: at the last frame.
        summary: all numbers, but for the warnings of the writers.
        setup: what was asked for, by name, for the report.
        failures: what could not be written, in words; writers add to it.
        pictures: files that were drawn, with their captions; writers add to it.
    """

    info: RunInfo
    wanted: Wanted
    history: History
    sheets: tuple[SheetResult, ...]
    summary: dict[str, Any]
    setup: Mapping[str, Any]
    failures: list[str]
    pictures: list[tuple[Path, str]] = field(default_factory=list)

    @property
    def warnings(self) -> list[str]:
        """Of the run, and what could not be written so far."""
        return [*map(str, self.summary.get("warnings") or ()), *self.failures]

    @property
    def whole_summary(self) -> dict[str, Any]:
        """``summary`` with all warnings."""
        return {**self.summary, "warnings": self.warnings}


def sheet_results(info: RunInfo, wanted: Wanted, frame: Frame) -> tuple[SheetResult, ...]:
    """What is read off every sheet of ``frame``."""
    parts = zip(info.sheets, frame.sheets, file_endings(info), strict=True)
    return tuple(_sheet_result(info, wanted, frame, *part) for part in parts)


def _sheet_result(
    info: RunInfo, wanted: Wanted, frame: Frame, sheet: SheetInfo, state: SheetFrame, ending: str
) -> SheetResult:
    formed = FormedSheet(
        sheet.blank, state.position, state.fields, sheet.fabric.thickness, sheet.symmetry, wanted.points, wanted.draw_in
    )
    tools = tuple((info.tool_names[k], info.tools[k], float(frame.tool_displacement[k])) for k in sheet.tools)
    return SheetResult(sheet, formed, ending, tools)


def run_summary(
    sheets: tuple[SheetResult, ...], outcome: Outcome | None, frame_count: int, given: Mapping[str, Any]
) -> dict[str, Any]:
    """Findings of the sheets and ``given`` numbers of the run; of several sheets in a list by that name."""
    own: dict[str, Any] = {"outcome": outcome.value if outcome else "running", "frame_count": frame_count}
    if len(sheets) == 1:
        return {**own, **sheets[0].findings, **given}
    return {**own, **given, "sheets": [{"name": sheet.info.name, **sheet.findings} for sheet in sheets]}
