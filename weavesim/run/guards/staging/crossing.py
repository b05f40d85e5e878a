"""Tools on both sides of the sheets that run into each other while a run is going on."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from ...watch.remembered import geometry_key, remembered
from ...watch.tool_distance import ToolDistances
from ..closing import on_both_sides, surface_of, tool_error
from ..guard import Doubt, Guard, Level, Start

if TYPE_CHECKING:
    from ....process.motions.paths import Place
    from ....tools.tool import Tool
    from ...frame import Frame
    from ...ledger import Ledger
    from ...verdict import Judged

logger = logging.getLogger(__name__)

# Everywhere: points of a tool that is carried may come over the sheets from beside them.
EVERYWHERE = np.array([[-1.0e6, -1.0e6, 0.0], [1.0e6, 1.0e6, 0.0]])
LARGEST_POINT_COUNT = 4000
# Overlap that is noted, over the thickness of the thinnest sheet.
LEAST_OVERLAP = 0.05


@dataclass
class _Pair:
    """Two tools whose way to each other is not known before the run.

    Attributes:
        tools: they.
        indices: among those of the run.
        points: on their surfaces, as drawn, (n, 3) each [m].
        error: of the distances from both [m].
        sheets: names of those between them.
        gap: at the last look that measured it [m].
        places: corners of the boxes of both at that look, (8, 3) each [m].
    """

    tools: tuple[Tool, Tool]
    indices: tuple[int, int]
    points: tuple[np.ndarray, np.ndarray]
    error: float
    sheets: frozenset[str]
    gap: float = -np.inf
    places: tuple[np.ndarray, np.ndarray] | None = None

    @property
    def name(self) -> str:
        return f"{self.tools[0].name} and {self.tools[1].name}"

    @cached_property
    def _boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Around the points of both, (8, 3) each."""
        return _box(self.points[0]), _box(self.points[1])

    def corners(self, at: list[Place]) -> tuple[np.ndarray, np.ndarray]:
        """Of the boxes around both tools, where these are."""
        one, other = (tool.moved(box, place) for tool, box, place in zip(self.tools, self._boxes, at, strict=True))
        return one, other

    def least_gap(self, now: tuple[np.ndarray, np.ndarray]) -> float:
        """What the gap is at least: that of the last look less the ways of both since then [m]."""
        if self.places is None:
            return -np.inf
        ways = (np.linalg.norm(a - b, axis=1).max() for a, b in zip(now, self.places, strict=True))
        return self.gap - float(sum(ways))


def _box(points: np.ndarray) -> np.ndarray:
    """Its corners, (8, 3)."""
    ends = points.min(axis=0), points.max(axis=0)
    return np.array([[ends[i][0], ends[j][1], ends[k][2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])


class ToolsCross(Guard):
    """Tools on both sides of the sheets that follow paths, turn or are moved by a force, and run into each other.

    What strokes do to each other is known before the run (``closing_gap``).
    """

    name = "tools_cross"
    watches = "whether tools that are carried, or that a force moves, run into others through the sheets"
    lasting = True

    def __init__(self) -> None:
        self._pairs: list[_Pair] = []
        self._distances: ToolDistances | None = None
        self._found: dict[str, dict[str, Any]] = {}

    def before(self, start: Start) -> Iterable[Doubt]:
        """Nothing yet: notes which tools may meet."""
        self._pairs, first = [], 0
        self._distances = distances = ToolDistances(start.model)
        size = min(float(np.sqrt(sheet.geometry.area.min())) for sheet in start.model.sheets)
        surfaces: dict[int, np.ndarray] = {}
        for world in start.model.setup.worlds:
            names = frozenset(sheet.name for sheet in world.sheets)
            nodes = np.concatenate([sheet.blank.node_position for sheet in world.sheets])
            for a, b in combinations(range(len(world.tools)), 2):
                indices = (first + a, first + b)
                if not _is_open(start, indices) or not on_both_sides(start, world, first, a, b):
                    continue
                tools = (world.tools[a], world.tools[b])
                for k in indices:
                    if k not in surfaces:
                        where = EVERYWHERE if _is_carried(start, k) else nodes
                        surfaces[k] = _surface(start, distances, k, where, size)
                one, other = (surfaces[k] for k in indices)
                if len(one) and len(other):
                    self._pairs.append(_Pair(tools, indices, (one, other), tool_error(start, tools), names))
            first += len(world.tools)
        return ()

    def watch(self, frame: Frame, ledger: Ledger) -> None:
        """Measure pairs that may have met since they were measured, where the sheets are."""
        for pair in self._pairs:
            if not all(frame.acts(index) for index in pair.indices):
                pair.places = None
                continue
            at = [frame.place(index) for index in pair.indices]
            now = pair.corners(at)
            if pair.least_gap(now) > 0.0:
                continue
            pair.gap, pair.places = self._measure(pair, at, frame), now

    def _measure(self, pair: _Pair, at: list[Place], frame: Frame) -> float:
        """The gap of a pair everywhere [m]; notes the first overlap at the sheets."""
        gap, thickness, distances = np.inf, _thickness(frame, pair), self._distances
        assert distances is not None
        for one, other in ((0, 1), (1, 0)):
            moved = pair.tools[one].moved(pair.points[one], at[one])
            found = distances(pair.indices[other], at[other], moved)[0]
            gap = min(gap, float(found.min()))
            inside = np.flatnonzero(found < -pair.error - LEAST_OVERLAP * thickness)
            near = inside[_near_sheets(moved[inside], frame, pair.sheets)] if len(inside) else inside
            if len(near):
                deepest = near[int(np.argmin(found[near]))]
                self._note(pair.name, frame.time, moved[deepest], float(-found[deepest]), thickness)
        return gap

    def _note(self, name: str, time: float, point: np.ndarray, depth: float, thickness: float) -> None:
        if name not in self._found:
            x, y, z = (1e3 * point).tolist()
            self._found[name] = {"time": time, "x": x, "y": y, "z": z, "depth": 0.0, "thickness": thickness}
            logger.warning("at %.4g s %s run into each other at (%.4g, %.4g, %.4g) mm", time, name, x, y, z)
        self._found[name]["depth"] = max(self._found[name]["depth"], depth)

    def memory(self) -> Mapping[str, Any]:
        """What ran into what."""
        return {"found": {name: dict(each) for name, each in self._found.items()}}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Take it back."""
        self._found = {name: dict(each) for name, each in memory["found"].items()}

    def after(self, run: Judged) -> Iterable[Doubt]:
        """Tools that were inside each other where the sheets are."""
        yield from (self._told(name, found) for name, found in self._found.items())

    def _told(self, name: str, found: Mapping[str, Any]) -> Doubt:
        deep = found["depth"] > found["thickness"]
        return self.doubt(
            Level.DO_NOT_USE if deep else Level.WARNING,
            f"{name} ran into each other, first at ({found['x']:.4g}, {found['y']:.4g}, {found['z']:.4g}) mm, by "
            f"{1e3 * found['depth']:.3g} mm at most",
            "no press can do that: change their paths, or stop them by spacers or a stroke",
            time=float(found["time"]),
            value=float(found["depth"]),
        )


def _surface(start: Start, distances: ToolDistances, index: int, where: np.ndarray, size: float) -> np.ndarray:
    """Points on the surface of a tool, as drawn, within the plan of ``where`` (k, 3) [m], (n, 3) [m]."""
    tool = start.model.setup.tools[index]
    key = geometry_key(start.model, (tool,))

    def find() -> np.ndarray:
        points = surface_of(distances, index, tool, where, size)
        return points[:: max(1, -(-len(points) // LARGEST_POINT_COUNT))]

    return remembered(None if key is None else ("surface", where is EVERYWHERE, *key), find)


def _is_carried(start: Start, index: int) -> bool:
    """Whether a tool is carried in any stage, so that what is beside the blank may come over it."""
    return any(phase.setup.tools[index].motion.is_carried for phase in start.phases)


def _is_open(start: Start, indices: tuple[int, int]) -> bool:
    """Whether one of two tools is carried or moved by a force in a stage in which both act."""
    for phase in start.phases:
        tools = [phase.setup.tools[k] for k in indices]
        is_open = any(tool.motion.is_carried or tool.motion.by_force for tool in tools)
        if is_open and all(tool.name in phase.tools for tool in tools):
            return True
    return False


def _sheets(frame: Frame, names: frozenset[str]) -> Iterator[np.ndarray]:
    yield from (sheet.position for sheet in frame.sheets if sheet.name in names)


def _thickness(frame: Frame, pair: _Pair) -> float:
    return min(float(np.nanmin(sheet.fields["thickness"])) for sheet in frame.sheets if sheet.name in pair.sheets)


def _near_sheets(points: np.ndarray, frame: Frame, names: frozenset[str]) -> np.ndarray:
    """Whether each point has a node of the sheets about an element away from it, (n,) bool."""
    from scipy.spatial import cKDTree

    near = np.zeros(len(points), dtype=bool)
    for nodes in _sheets(frame, names):  # each by itself: plies are closer to each other than their nodes
        nodes = nodes[np.isfinite(nodes).all(axis=1)]
        tree = cKDTree(nodes)
        spacing = float(np.median(tree.query(nodes, k=2)[0][:, 1]))
        near |= tree.query(points)[0] <= 1.5 * spacing
    return near
