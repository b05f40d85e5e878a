"""Unit cells: what they say about their values, and those whose iteration failed."""

from __future__ import annotations

from collections.abc import Iterable

from .guard import Doubt, Guard, Level, Start
from .limit import LimitGuard


class UnitCell(Guard):
    """Values of a unit cell that make it slow or ill-conditioned."""

    name = "unit_cell"
    watches = "the values of the unit cells"

    def before(self, start: Start) -> Iterable[Doubt]:
        """What each cell says about itself."""
        for sheet in start.model.setup.sheets:
            for text in sheet.fabric.unit_cell.warnings():
                yield self.doubt(Level.WARNING, text)


class UnitCellFailures(LimitGuard):
    """Cells whose equilibrium was not found in some step."""

    name = "unit_cell_failures"
    watches = "unit cells that failed"
    key = "unit_cell_failures"
    text = "the number of failed unit cells"
    largest = 0.0
    advice = "look where unit_cell_failed is 1, and at the strains and the numbers of the fabric there"
