"""Tools that close on less than the sheet's thickness."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...errors import InputError
from ...process.motions.paths import PathMotion
from ...ranges import ACCEPTING
from ..watch.remembered import geometry_key, remembered
from ..watch.tool_distance import ToolDistances
from .guard import Doubt, Guard, Level, Start

if TYPE_CHECKING:
    from ...engine.setup import World
    from ...tools.shapes import Triangles
    from ...tools.tool import Tool
    from ..staging.rehearsal import Phase

# Share of the thickness that may be missing between two tools; measured thicknesses are no better.
LARGEST_LACK = 0.05
# Places along the way of two tools at which their gap is taken.
PLACE_COUNT = 17
# Points on each tool, at most.
LARGEST_POINT_COUNT = 20_000
# Points along the longest edge of a triangle, at most.
LARGEST_DIVISION = 60


class Closest(NamedTuple):
    """Where two tools are nearest to each other.

    Attributes:
        gap: between them, negative inside [m]; infinite where they act together in no stage.
        time: when [s].
        point: where, in space (3,) [m].
    """

    gap: float
    time: float
    point: tuple[float, float, float] = (math.nan, math.nan, math.nan)

    @property
    def text(self) -> str:
        """Place and time for messages."""
        x, y, z = (round(1e3 * value, 3) + 0.0 for value in self.point)
        return f"at ({x:.4g}, {y:.4g}, {z:.4g}) mm at {self.time:.4g} s"


class ClosingGap(Guard):
    """Two tools on either side of the sheets that leave less room for them than their thickness.

    Tools that a force moves stop at the sheet: they are left out. So do strokes with a largest force: it is only noted.
    Others are refused; where unusual values are accepted, those that leave some room only warn.
    """

    name = "closing_gap"
    watches = "the room for the sheet between two tools, on all of their way"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Pairs that close too far.

        Raises:
            InputError: they run into each other, or leave too little room and nobody has accepted that.
        """
        first = 0
        for number, world in enumerate(start.model.setup.worlds):
            pairs = combinations(range(len(world.tools)), 2)
            thickness = stack_thickness(world)
            for pair in pairs:
                # each stage by its own strokes and their largest forces
                for phase, tools in _closing(start, number, pair):
                    if found := _gap_around(start, phase, number, first, pair):
                        yield from self._judged(start, tools, found, thickness)
                        yield from self._not_judged(tools)
            first += len(world.tools)

    def _not_judged(self, tools: tuple[Tool, Tool]) -> Iterator[Doubt]:
        """What the gap of tools that are carried does not say."""
        if any(tool.motion.is_carried for tool in tools):
            yield self.doubt(
                Level.NOTE,
                f"{tools[0].name} and {tools[1].name} follow paths or turn: their gap is judged over the flat blank, "
                "and not where the sheet is carried beyond it",
                "look at the film for places where they squeeze the sheet",
            )

    def _judged(self, start: Start, tools: tuple[Tool, Tool], found: Closest, thickness: float) -> Iterator[Doubt]:
        error, gap, time = tool_error(start, tools), found.gap, found.time
        if not gap < (1.0 - LARGEST_LACK) * thickness - error:
            return
        names = f"{tools[0].name} and {tools[1].name}"
        if limited := [tool for tool in tools if tool.motion.limiting_force]:
            yield self.doubt(
                Level.NOTE,
                f"{names} would leave {1e3 * gap:.3g} mm between them {found.text}, for {1e3 * thickness:.3g} mm of "
                f"fabric: {limited[0].name} stops before, where its largest force of "
                f"{limited[0].motion.limiting_force:.4g} N is reached",
                "for a closed gap make the stroke shorter, or the gap at least the thickness",
                time=time,
                value=gap,
                limit=thickness,
            )
            return
        advice = "make the stroke shorter, the gap at least the thickness, or give the stroke a largest_force"
        if gap + error <= 0.0:
            raise InputError(
                f"{names} run into each other by {-1e3 * gap:.3g} mm {found.text}; the sheet between them is "
                f"{1e3 * thickness:.3g} mm thick: {advice}"
            )
        text = f"{names} leave {1e3 * gap:.3g} mm between them {found.text}, for a sheet of {1e3 * thickness:.3g} mm"
        if not start.accepts_unusual:
            raise InputError(f"{text}: they close too far, and forces there would mean nothing: {advice}. {ACCEPTING}")
        yield self.doubt(
            Level.WARNING,
            text,
            f"they close too far, and forces there mean nothing: {advice}",
            time=time,
            value=gap,
            limit=thickness,
        )


def _closing(start: Start, world: int, pair: tuple[int, int]) -> Iterator[tuple[Phase, tuple[Tool, Tool]]]:
    """Every stage in which two tools of a world act and move relative to each other, with them as they are in it."""
    for phase in start.phases:
        a, b = (phase.setup.worlds[world].tools[k] for k in pair)
        if a.name in phase.tools and b.name in phase.tools and _closes(a, b):
            yield phase, (a, b)


def stack_thickness(world: World) -> float:
    """Of the sheets that lie on each other [m]: of the thickest stack; of the thinnest sheet where none do."""
    thickness = {sheet.name: sheet.fabric.thickness for sheet in world.sheets}
    stack = {name: {name} for name in thickness}
    for interface in world.interfaces:
        both = stack[interface.lower] | stack[interface.upper]
        stack.update(dict.fromkeys(both, both))
    if not world.interfaces:
        return min(thickness.values())
    return max(sum(thickness[name] for name in names) for names in stack.values())


def _closes(a: Tool, b: Tool) -> bool:
    """Whether two tools move relative to each other, by prescribed strokes."""
    if any(tool.motion.by_force for tool in (a, b)):
        return False
    return any(len(set(tool.motion.curve()[1])) > 1 or tool.motion.is_carried for tool in (a, b))


def _gap_around(start: Start, phase: Phase, number: int, first: int, pair: tuple[int, int]) -> Closest | None:
    """``smallest_gap`` of two tools of a world in one stage, if the sheets are between them."""
    world = start.model.setup.worlds[number]
    tools = world.tools[pair[0]], world.tools[pair[1]]
    # stages may move them otherwise
    key = geometry_key(start.model, tools) if len(start.phases) == 1 else None
    if key is not None:
        places = (start.frame.place(first + k) for k in pair)
        key = ("gap", world.name, *places, *key)

    def find() -> Closest | None:
        between = on_both_sides(start, world, first, *pair)
        return smallest_gap(start, number, first, pair, [phase]) if between else None

    return remembered(key, find)


def on_both_sides(start: Start, world: World, first: int, a: int, b: int) -> bool:
    """Whether the sheets are between two tools, seen from their nearest nodes."""
    return is_below(start, world, first + a) != is_below(start, world, first + b)


def is_below(start: Start, world: World, tool: int) -> bool:
    """Whether a tool, by its index among those of the run, starts on the lower side of the sheets' nearest node."""
    distances, at = ToolDistances(start.model), start.frame.place(tool)
    names = [sheet.name for sheet in world.sheets]
    nodes = np.concatenate([frame.position for frame in start.frame.sheets if frame.name in names])
    up = np.concatenate([frame.director for frame in start.frame.sheets if frame.name in names])
    step = 0.5 * min(sheet.fabric.thickness for sheet in world.sheets) * up
    nearest = int(np.argmin(distances(tool, at, nodes)[0]))
    # far from a sampled tool the distance has a slope, but no normal
    beside = np.stack([nodes[nearest] + step[nearest], nodes[nearest] - step[nearest]])
    above, below = distances(tool, at, beside)[0]
    return bool(above > below)


def smallest_gap(
    start: Start,
    world: int,
    first: int,
    pair: tuple[int, int],
    phases: Sequence[Phase] | None = None,
) -> Closest:
    """Smallest distance between two tools over the flat blank, on all of their way, and when.

    A tool that a force moves is taken where it starts. Where they act together in no stage, the distance is infinite.

    Args:
        start: of the run.
        world: index of that of the tools.
        first: index of its first tool among those of the run.
        pair: indices of the tools among those of the world.
        phases: stages to look at; None for all.

    Returns:
        The distance [m], when, and where; an infinite one without a place if they act together in no stage.
    """
    distances, own = ToolDistances(start.model), start.model.setup.worlds[world]
    size = min(float(np.sqrt(sheet.geometry.area.min())) for sheet in start.model.sheets)
    nodes = np.concatenate([sheet.blank.node_position for sheet in own.sheets])
    points = [surface_of(distances, first + k, own.tools[k], nodes, size) for k in pair]
    best = Closest(np.inf, 0.0)
    for phase in start.phases if phases is None else phases:
        tools = [phase.setup.worlds[world].tools[k] for k in pair]
        if not phase.tools >= {tool.name for tool in tools}:
            continue
        times = np.unique(np.concatenate([np.linspace(phase.begin, phase.end, PLACE_COUNT), *map(_turns, tools)]))
        for time in times[(times >= phase.begin) & (times <= phase.end)]:
            at = [tool.place_at(float(time)) for tool in tools]
            for one, other in ((0, 1), (1, 0)):
                moved = tools[one].moved(points[one], at[one])
                within = is_over(moved, nodes)
                if within.any():
                    found = distances(first + pair[other], at[other], moved[within])[0]
                    x, y, z = moved[within][int(np.argmin(found))].tolist()
                    best = min(best, Closest(float(found.min()), float(time), (x, y, z)), key=lambda each: each[:2])
    return best


def _turns(tool: Tool) -> np.ndarray:
    """Times of the first and last knot of a stroke, and of the furthest in both directions; of knots of a path [s]."""
    times, displacements = (np.zeros(1), np.zeros(1)) if tool.motion.by_force else tool.motion.curve()
    extremes = times[[0, -1, int(np.argmin(displacements)), int(np.argmax(displacements))]]
    if not isinstance(tool.motion, PathMotion):
        return extremes
    # between knots a path never leaves their band
    knots = [curve[0] for curve in tool.motion.curves()]
    return np.concatenate([extremes, *(times[:: max(1, -(-len(times) // PLACE_COUNT))] for times in knots)])


def is_over(points: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Whether each point is over the plan of the flat blank, (n,) bool."""
    # by columns: reductions over two numbers take several times as long
    x, y = points[:, 0], points[:, 1]
    lower, upper = _plan(nodes)
    inside: np.ndarray = (x >= lower[0]) & (x <= upper[0]) & (y >= lower[1]) & (y <= upper[1])
    return inside


def _plan(nodes: np.ndarray) -> tuple[tuple[float, float], tuple[float, float]]:
    """Lower and upper corner of the flat blank's box in plan [m]."""
    x, y = nodes[:, 0], nodes[:, 1]
    return (float(x.min()), float(y.min())), (float(x.max()), float(y.max()))


def surface_of(distances: ToolDistances, index: int, tool: Tool, nodes: np.ndarray, size: float) -> np.ndarray:
    """Points on the surface of a tool over the blank, about ``size`` apart, at zero displacement, (n, 3) [m]."""
    points = _spread(tool.display_triangles(), nodes, size)
    if len(points):
        # what is drawn of a round shape are chords of it
        distance, normal = distances(index, 0.0, points)
        shift = distance[:, None] * normal
        points = np.where(np.abs(distance)[:, None] < 0.5 * size, points - shift, points)
    return points


def _spread(triangles: Triangles, nodes: np.ndarray, size: float) -> np.ndarray:
    """Points spread evenly over the triangles whose boxes overlap the blank's in plan."""
    vertices, faces = triangles
    corners = np.asarray(vertices, dtype=np.float64)[faces]
    lower, upper = nodes[:, :2].min(axis=0), nodes[:, :2].max(axis=0)
    near = ((corners[:, :, :2].min(axis=1) <= upper) & (corners[:, :, :2].max(axis=1) >= lower)).all(axis=1)
    corners = corners[near]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1, initial=0.0)
    division = np.clip(np.ceil(longest / size), 1, LARGEST_DIVISION).astype(int)
    found = [np.empty((0, 3))]
    for count in np.unique(division):
        i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
        inside = i + j <= count
        weight = np.column_stack([i[inside], j[inside], count - i[inside] - j[inside]]) / count
        found.append((weight @ corners[division == count]).reshape(-1, 3))
    points = np.concatenate(found)
    (over,) = np.nonzero(is_over(points, nodes))
    return points[over[:: max(1, -(-len(over) // LARGEST_POINT_COUNT))]]


def tool_error(start: Start, tools: tuple[Tool, Tool]) -> float:
    """Error of the distances from two tools at 99 % of all points, together [m]; 0 for formulas."""
    surfaces = [part.surface for tool in tools for part in tool.shape.parts()]
    return sum(start.model.samples[surface].usual_error for surface in set(surfaces) if surface is not None)
