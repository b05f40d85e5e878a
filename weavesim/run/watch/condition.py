"""Condition of sheets: where they pass through themselves or each other, are folded, turned over, or beyond a plane."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from ...measures.crossings import Crossings, CrossingsBetween
from ...measures.folding import beyond_symmetry, facing, folded_elements, folded_pairs, neighbours
from ..frame import SheetFrame, SheetInfo
from ..staging.part import Part

# What is tallied of a sheet.
TALLIES = ("crossings", "folded", "inverted", "beyond")


class Tally(NamedTuple):
    """Something that is counted or measured at several times.

    Attributes:
        last: at the last time.
        most: at the worst time.
        time: of the worst [s].
        place: of one of them then, (x, y) on the flat blank [m].
        share: elements concerned then, over all.
    """

    last: float = 0.0
    most: float = 0.0
    time: float = 0.0
    place: tuple[float, float] | None = None
    share: float = 0.0


class Condition:
    """Looks at one sheet.

    Args:
        info: of the sheet.

    Attributes:
        crossings: pairs of triangles that meet, see ``Crossings``.
        folded: elements folded by more than 90 degrees, and pairs of neighbours folded onto each other.
        inverted: elements turned over against their directors.
        beyond: deepest node beyond a symmetry plane [m].
    """

    def __init__(self, info: SheetInfo) -> None:
        self._whole = info
        self._see(Part(info, np.zeros(0, dtype=bool)))
        self.crossings = self.folded = self.inverted = self.beyond = Tally()

    def _see(self, part: Part) -> None:
        """Look at a part of the sheet from now on: what a stage has left of it."""
        self._part, blank = part, part.info.blank
        self._crossings = Crossings(blank.quads, blank.node_count)
        self._neighbours = neighbours(blank.quads)
        self._flat_facing = facing(blank.node_position, blank.initial_director, blank.quads)
        self._nodes = blank.material_coordinates
        self._centres = self._nodes[blank.quads].mean(axis=1)

    def look(self, frame: SheetFrame, time: float) -> None:
        """Look at the sheet at ``time`` [s]."""
        if not self._part.holds(frame):
            self._see(Part(self._whole, frame.kept))
        info, frame = self._part.of(frame)
        blank = info.blank
        pairs = self._crossings.pairs(frame.position)
        self.crossings = self._counted(self.crossings, len(pairs), np.unique(pairs // 2), time)
        element = folded_elements(frame.position, blank.quads)
        onto = self._neighbours[folded_pairs(frame.position, blank.quads, self._neighbours)]
        concerned = np.union1d(np.flatnonzero(element), onto)
        self.folded = self._counted(self.folded, int(element.sum()) + len(onto), concerned, time)
        # turned over against their directors
        now = facing(frame.position, frame.director, blank.quads)
        inverted = np.flatnonzero(now * self._flat_facing < 0.0)
        self.inverted = self._counted(self.inverted, len(inverted), inverted, time)
        beyond = beyond_symmetry(frame.position, blank, info.symmetry)
        node = int(beyond.argmax())
        self.beyond = _worse(self.beyond, float(beyond[node]), time, self._nodes[node], 0.0)

    def memory(self) -> dict[str, Any]:
        """All that was seen so far, for a checkpoint."""
        return {name: list(getattr(self, name)) for name in TALLIES}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Have seen what ``memory`` tells."""
        for name in TALLIES:
            setattr(self, name, _recalled(memory[name]))

    def _counted(self, last: Tally, count: int, elements: np.ndarray, time: float) -> Tally:
        place = self._centres[elements[0]] if len(elements) else None
        return _worse(last, float(count), time, place, len(elements) / len(self._centres))


class StackCondition:
    """Looks at the sheets of one world: where they pass through each other.

    Args:
        infos: of these sheets, at least two.

    Attributes:
        crossings: pairs of triangles that meet, see ``CrossingsBetween``, by the names of two sheets; the place is that
            on the flat blank of the first.
        total: sum of these over all times, by the same names.
        look_count: times so far.
    """

    def __init__(self, infos: Sequence[SheetInfo]) -> None:
        self._whole = tuple(infos)
        self._see([Part(info, np.zeros(0, dtype=bool)) for info in infos])
        names = [info.name for info in infos]
        self.crossings = {pair: Tally() for pair in combinations(names, 2)}
        self.total = dict.fromkeys(self.crossings, 0)
        self.look_count = 0

    def _see(self, parts: Sequence[Part]) -> None:
        """Look at parts of the sheets from now on."""
        self._parts = tuple(parts)
        self._infos = tuple(part.info for part in parts)
        self._crossings = CrossingsBetween([info.blank.quads for info in self._infos])

    def look(self, frames: Sequence[SheetFrame], time: float) -> None:
        """Look at the sheets at ``time`` [s]; ``frames`` may be those of the whole run."""
        by_name = {frame.name: frame for frame in frames}
        own = [by_name[info.name] for info in self._whole]
        if not all(part.holds(frame) for part, frame in zip(self._parts, own, strict=True)):
            self._see([Part(info, frame.kept) for info, frame in zip(self._whole, own, strict=True)])
        pairs = self._crossings.pairs(
            [part.of(frame)[1].position for part, frame in zip(self._parts, own, strict=True)]
        )
        self.look_count += 1
        for (a, first), (b, second) in combinations(enumerate(self._infos), 2):
            meeting = pairs[(pairs[:, 0] == a) & (pairs[:, 2] == b)]
            elements, others = np.unique(meeting[:, 1] // 2), np.unique(meeting[:, 3] // 2)
            share = (len(elements) + len(others)) / (first.blank.element_count + second.blank.element_count)
            place = None
            if len(elements):
                place = first.blank.material_coordinates[first.blank.quads[elements[0]]].mean(axis=0)
            names = first.name, second.name
            self.crossings[names] = _worse(self.crossings[names], float(len(meeting)), time, place, share)
            self.total[names] += len(meeting)

    def memory(self) -> dict[str, Any]:
        """All that was seen so far, for a checkpoint."""
        crossings = [list(tally) for tally in self.crossings.values()]
        return {"crossings": crossings, "total": list(self.total.values()), "look_count": self.look_count}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Have seen what ``memory`` tells."""
        self.crossings = dict(zip(self.crossings, map(_recalled, memory["crossings"]), strict=True))
        self.total = dict(zip(self.total, memory["total"], strict=True))
        self.look_count = memory["look_count"]


def _recalled(values: Sequence[Any]) -> Tally:
    last, most, time, place, share = values
    return Tally(last, most, time, None if place is None else (place[0], place[1]), share)


def _worse(last: Tally, value: float, time: float, place: np.ndarray | None, share: float) -> Tally:
    if not value > last.most or place is None:
        return last._replace(last=value)
    return Tally(value, value, time, (float(place[0]), float(place[1])), share)
