"""Tools that are not their own mirror images at the planes at which the sheets are cut."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ....errors import InputError
from ....ranges import ACCEPTING
from ....sheet.symmetry import AXES
from ...watch.remembered import geometry_key, remembered
from ...watch.tool_distance import ToolDistances
from ..closing import is_below, is_over, surface_of, tool_error
from ..guard import Doubt, Guard, Level, Start

if TYPE_CHECKING:
    from ....process.strokes import Motion
    from ...staging.rehearsal import Phase

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
                found = _furthest(start, number, first, k)
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


def _furthest(start: Start, number: int, first: int, k: int) -> Off | None:
    """The largest of ``_looks``; variants of a set-up of one stage share it."""
    world = start.model.setup.worlds[number]
    key = geometry_key(start.model, world.tools) if len(start.phases) == 1 else None
    if key is not None:
        places = (start.frame.place(first + j) for j in range(len(world.tools)))
        key = ("symmetry", world.name, world.symmetry, k, *places, *key)
    return remembered(key, lambda: max(_looks(start, number, first, k), key=lambda each: each.off, default=None))


def _looks(start: Start, number: int, first: int, k: int) -> Iterator[Off]:
    """How far the tool ``k`` of a world is off its mirror images, at several times of every stage in which it acts."""
    distances = ToolDistances(start.model)
    whole = start.model.setup.worlds[number]
    nodes = np.concatenate([sheet.blank.node_position for sheet in whole.sheets])
    there = whole.symmetry.mirrored(nodes)
    size = min(float(np.sqrt(sheet.geometry.area.min())) for sheet in start.model.sheets)
    up = 1.0 if is_below(start, whole, first + k) else -1.0
    carried = any(phase.setup.worlds[number].tools[k].motion.is_carried for phase in start.phases)
    # one that is carried may come over the sheet from beside it
    where = np.asarray(whole.tools[k].display_triangles()[0]) if carried else there
    points = surface_of(distances, first + k, whole.tools[k], where, size)
    for phase in start.phases:
        tools = phase.setup.worlds[number].tools
        if tools[k].name not in phase.tools or not len(points):
            continue
        acting = [j for j, tool in enumerate(tools) if tool.name in phase.tools]
        for time, displaced in _moments(tools[k].motion, phase, size):
            place = tools[k].place(displaced, time)
            moved = tools[k].moved(points, place)
            moved = moved[is_over(moved, there)]
            for plane in whole.symmetry.planes:
                axis = AXES[plane]
                side = 1.0 if nodes[:, axis].mean() > 0.0 else -1.0
                # one that is all beyond the plane may have another tool as its mirror image
                others = [k] if (side * moved[:, axis] > 0.0).any() else acting
                images = [
                    partial(distances, first + j, place if j == k else tools[j].place_at(time)) for j in others
                ]  # fmt: skip
                beyond = moved[side * moved[:, axis] < 0.0]
                if (off := _look(partial(distances, first + k, place), images, beyond, axis, up)) is not None:
                    yield Off(*off, time, plane)


def _moments(motion: Motion, phase: Phase, size: float) -> Iterator[tuple[float, float]]:
    """Times of a stage [s] at which a tool is looked at, and how far it is displaced along its axis [m]."""
    moves = not motion.by_force and len(set(motion.curve()[1])) > 1
    for time in np.linspace(phase.begin, phase.end, TIME_COUNT if moves or motion.is_carried else 1).tolist():
        yield time, 0.0 if motion.by_force else motion.displacement_at(time)
    if motion.by_force:  # nobody knows how far, but on a leaning axis any way is one off the plane
        yield phase.begin, size


Distance = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def _look(
    distance_of: Distance, images: Sequence[Distance], beyond: np.ndarray, axis: int, up: float
) -> tuple[float, tuple[float, float, float]] | None:
    """How far points beyond a plane whose normal is along ``up``, towards the sheet, are off their mirror images.

    Args:
        distance_of: the tool of the points.
        images: tools that may be its mirror image, of which the nearest counts.
        beyond: points (n, 3) [m].
        axis: across the plane.
        up: sign of the normal's z.

    Returns:
        The largest distance [m], and where; None where no point faces the sheet.
    """
    distance, normal = distance_of(beyond) if len(beyond) else (np.empty(0), beyond)
    facing = up * normal[:, 2] > LEAST_FACING
    if not facing.any():
        return None
    mirrored = beyond[facing]
    mirrored[:, axis] *= -1.0
    # a point of one part may lie deep in another, where both distances are alike
    off = min((np.abs(image(mirrored)[0] - distance[facing]) for image in images), key=np.max)
    worst = int(np.argmax(off))
    x, y, z = beyond[facing][worst].tolist()
    return float(off[worst]), (x, y, z)
