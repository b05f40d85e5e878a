"""Tools that are not their own mirror images at the planes at which the sheets are cut."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np

from ....errors import InputError
from ....ranges import ACCEPTING
from ....sheet.symmetry import AXES
from ...watch.tool_distance import ToolDistances
from ..closing import is_below, surface_of, tool_error
from ..guard import Doubt, Guard, Level, Start

# How far a tool may be off its mirror image, over the thickness of the thinnest sheet.
LARGEST_OFF = 0.25
# Times at which a tool that moves is looked at, in each stage.
TIME_COUNT = 5
# Points whose normal has less than this along z do not face the sheet.
LEAST_FACING = 0.3


class Off(NamedTuple):
    """Where a tool is furthest off its mirror image: by how much [m], where (3,) [m], when [s], at which plane."""

    off: float
    point: tuple[float, float, float]
    time: float
    plane: str


class ToolSymmetry(Guard):
    """Tools across a plane of symmetry, what lies beyond which is not what the mirror image of the rest would be.

    A run forms the side on which the sheet lies, and its results show the mirror image of that.
    """

    name = "tool_symmetry"
    watches = "whether tools across a plane of symmetry are their own mirror images"

    def before(self, start: Start) -> Iterable[Doubt]:
        """Tools that are not.

        Raises:
            InputError: a tool is not symmetric, and nobody has accepted that.
        """
        first = 0
        for number, world in enumerate(start.model.setup.worlds):
            thickness = min(sheet.fabric.thickness for sheet in world.sheets)
            for k, tool in enumerate(world.tools if world.symmetry.planes else ()):
                limit = LARGEST_OFF * thickness + tool_error(start, (tool, tool))
                found = max(_looks(start, number, first, k), key=lambda each: each.off, default=None)
                if found is None or found.off <= limit:
                    continue
                x, y, z = (1e3 * value for value in found.point)
                text = (
                    f"{tool.name}: at ({x:.4g}, {y:.4g}, {z:.4g}) mm it is {1e3 * found.off:.3g} mm off its mirror "
                    f"image at the plane of symmetry {found.plane} = 0, at {found.time:.4g} s"
                )
                advice = (
                    "the run would form the side of the sheet and show its mirror image: draw a part that is not "
                    f"symmetric whole, without {found.plane!r} in symmetry, or move the tool"
                )
                if not start.accepts_unusual:
                    raise InputError(f"{text}: {advice}. {ACCEPTING}")
                yield self.doubt(Level.WARNING, text, advice, value=found.off, limit=limit)
            first += len(world.tools)


def _looks(start: Start, number: int, first: int, k: int) -> Iterator[Off]:
    """How far the tool ``k`` of a world is off its mirror images, at several times of every stage in which it acts."""
    distances = ToolDistances(start.model)
    whole = start.model.setup.worlds[number]
    nodes = np.concatenate([sheet.blank.node_position for sheet in whole.sheets])
    size = min(float(np.sqrt(sheet.geometry.area.min())) for sheet in start.model.sheets)
    up = 1.0 if is_below(start, whole, first + k) else -1.0
    points = surface_of(distances, first + k, whole.tools[k], whole.symmetry.mirrored(nodes), size)
    for phase in start.phases:
        tool = phase.setup.worlds[number].tools[k]
        if tool.name not in phase.tools or not len(points):
            continue
        moves = not tool.motion.by_force and len(set(tool.motion.curve()[1])) > 1
        for time in np.linspace(phase.begin, phase.end, TIME_COUNT if moves or tool.motion.is_carried else 1).tolist():
            place = tool.place_at(time)
            moved = tool.moved(points, place)
            for plane in whole.symmetry.planes:
                yield from _look(partial(distances, first + k, place), moved, nodes, plane, up, time)


def _look(
    distance_of: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]],
    points: np.ndarray,
    nodes: np.ndarray,
    plane: str,
    up: float,
    time: float,
) -> Iterator[Off]:
    """At one time: points beyond a plane whose normal is along ``up``, towards the sheet, mirrored onto its side."""
    axis = AXES[plane]
    side = 1.0 if nodes[:, axis].mean() > 0.0 else -1.0
    beyond = points[side * points[:, axis] < 0.0]
    if not len(beyond):
        return
    distance, normal = distance_of(beyond)
    facing = up * normal[:, 2] > LEAST_FACING
    beyond = beyond[facing]
    if not len(beyond):
        return
    mirrored = beyond.copy()
    mirrored[:, axis] *= -1.0
    # a point of one part may lie deep in another, where both distances are alike
    off = np.abs(distance_of(mirrored)[0] - distance[facing])
    worst = int(np.argmax(off))
    x, y, z = beyond[worst].tolist()
    yield Off(float(off[worst]), (x, y, z), time, plane)
