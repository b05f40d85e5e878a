"""An observer that counts in every frame where sheets pass through themselves or each other."""

from __future__ import annotations

import numpy as np

from ...measures.crossings import Crossings
from ..frame import Frame, Outcome, RunInfo, SheetInfo
from ..staging.part import Part
from .condition import StackCondition

# Parts of a sheet that are closer on the flat blank than this, over the thickness, are neighbours.
NEIGHBOUR_DISTANCE = 2.0


class CrossingRecord:
    """Observer that counts pairs of triangles that meet, in every frame; the watch of a run sees fewer states.

    Every pair of triangles is tested, with nothing of the search for contact. Left out are, within a sheet, pairs with
    a common node, and those that are closer on the flat blank than twice the thickness; between sheets none.

    Args:
        neighbour_distance: the latter limit, over the thickness of the sheet.

    Attributes:
        within: pairs in each frame by the name of the sheet.
        between: pairs in each frame by the names of two sheets of one world.
    """

    def __init__(self, neighbour_distance: float = NEIGHBOUR_DISTANCE) -> None:
        self._neighbour_distance = neighbour_distance
        self.within: dict[str, list[int]] = {}
        self.between: dict[tuple[str, str], list[int]] = {}

    def start(self, info: RunInfo) -> None:
        self._info = info
        self._parts = [Part(sheet, np.zeros(0, dtype=bool)) for sheet in info.sheets]
        self._crossings = [_crossings(sheet) for sheet in info.sheets]
        self._stacks = [StackCondition(sheets) for sheets in info.worlds if len(sheets) > 1]
        self.within = {sheet.name: [] for sheet in info.sheets}
        self.between = {names: [] for stack in self._stacks for names in stack.crossings}

    def frame(self, frame: Frame) -> None:
        for place, (sheet, state) in enumerate(zip(self._info.sheets, frame.sheets, strict=True)):
            limit = self._neighbour_distance * sheet.fabric.thickness
            if not self._parts[place].holds(state):
                self._parts[place] = Part(sheet, state.kept)
                self._crossings[place] = _crossings(self._parts[place].info)
            sheet, state = self._parts[place].of(state)
            crossings = self._crossings[place]
            pairs = crossings.distant(crossings.pairs(state.position), sheet.blank.material_coordinates, limit)
            self.within[sheet.name].append(len(pairs))
        for stack in self._stacks:
            stack.look(frame.sheets, frame.time)
            for names, tally in stack.crossings.items():
                self.between[names].append(int(tally.last))

    def finish(self, outcome: Outcome) -> None:
        """Nothing to close."""

    @property
    def total(self) -> int:
        """Pairs of all frames."""
        return sum(map(sum, (*self.within.values(), *self.between.values())))


def _crossings(sheet: SheetInfo) -> Crossings:
    return Crossings(sheet.blank.quads, sheet.blank.node_count)
