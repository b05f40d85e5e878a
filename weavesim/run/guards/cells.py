"""Unit cells: what they say about their values, and those whose iteration failed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .guard import Doubt, Guard, Level, Start
from .limit import LimitGuard

if TYPE_CHECKING:
    from ..frame import Frame
    from ..ledger import Ledger
    from ..verdict import Judged


class UnitCell(Guard):
    """Values of a unit cell that make it slow or ill-conditioned."""

    name = "unit_cell"
    watches = "the values of the unit cells"

    def before(self, start: Start) -> Iterable[Doubt]:
        """What each cell says about itself."""
        for sheet in start.model.setup.sheets:
            for text in sheet.fabric.unit_cell.warnings():
                yield self.doubt(Level.WARNING, text)


class First(NamedTuple):
    """The first state with failed cells that was seen: sheet and place of the worst of them, and time."""

    sheet: str
    x: float
    y: float
    time: float


class UnitCellFailures(LimitGuard):
    """Cells whose equilibrium was not found in some step."""

    name = "unit_cell_failures"
    watches = "unit cells that failed"
    lasting = True
    key = "unit_cell_failures"
    text = "the number of failed unit cells"
    largest = 0.0
    advice = "look where unit_cell_failed is 1, and at the strains and the numbers of the fabric there"

    def __init__(self) -> None:
        self._first: First | None = None
        self._count = 0

    def watch(self, frame: Frame, ledger: Ledger) -> None:
        """Note the first that fail, with the place of the worst."""
        failed = [sheet.fields["unit_cell_failed"] > 0.0 for sheet in frame.sheets]
        self._count = sum(int(own.sum()) for own in failed)
        if self._first is None and self._count:
            residuals = [
                np.where(own, np.nan_to_num(sheet.fields["unit_cell_residual"], nan=np.inf), -1.0)
                for own, sheet in zip(failed, frame.sheets, strict=True)
            ]
            number = int(np.argmax([float(own.max()) for own in residuals]))
            x, y = ledger.sheets[number].place_of(int(np.argmax(residuals[number]))).tolist()
            self._first = First(frame.sheets[number].name, x, y, frame.time)

    def memory(self) -> Mapping[str, Any]:
        """What was seen so far."""
        return {"first": None if self._first is None else list(self._first), "count": self._count}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Take it back."""
        self._first = None if memory["first"] is None else First(*memory["first"])
        self._count = memory["count"]

    def where(self, run: Judged) -> Mapping[str, Any]:
        """Of the first that failed."""
        if self._first is None:
            return {}
        return {"sheet": self._first.sheet, "place": (self._first.x, self._first.y), "time": self._first.time}

    def so_far(self, run: Judged) -> Iterable[Doubt]:
        """Those of the last state that was seen, which need not be that of a frame."""
        return self.of(run, self._count)
