"""Springs, grippers and pressures of a job, on the nodes and elements of its plies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..errors import InputError, did_you_mean
from ..process.grippers import Gripper
from ..process.pressure import Pressure
from ..process.strokes import Fixed, Motion, Stroke
from ..sheet.blank import Blank
from ..sheet.outline import Outline, checked_outline
from .placing import RAMP_SHARE
from .read import JobFile
from .schema import GripperTable, PressureTable, SpringTable

# Nodes of an edge lie within this share of an element of the furthest one.
EDGE = 0.1
# A corner is where an outline turns by more than this [degrees].
CORNER = 15.0


class Place(NamedTuple):
    """Nodes (k,) that a spring pulls at, and the direction outwards, (3,)."""

    nodes: np.ndarray
    outwards: np.ndarray


class Loads:
    """What pulls and presses at the plies of a job.

    Args:
        file: the job.
        names: of all plies.

    Raises:
        InputError: a ply that is not there, or is not named where there are several.
    """

    def __init__(self, file: JobFile, names: Sequence[str]) -> None:
        self._file, self._names = file, list(names)

    def pressures(self, ply: str, blank: Blank) -> tuple[Pressure, ...]:
        """On a ply with this mesh."""
        tables = self._file.job.pressure
        return tuple(
            self.pressure(["pressure", index], table, blank)
            for index, table in enumerate(tables)
            if self.ply(["pressure", index], table.ply) == ply
        )

    def pressure(self, keys: Sequence[object], table: PressureTable, blank: Blank, before: float = 0.0) -> Pressure:
        """Of a table under some ``keys``, on a ply with this mesh; it goes from ``before`` [Pa]."""
        times = (table.delay, table.delay + table.ramp)
        elements = None if table.patch is None else self._patch(keys, table.patch, blank)
        return Pressure(table.face, (before, table.pressure), times, elements)

    def _patch(self, keys: Sequence[object], corners: Sequence[tuple[float, float]], blank: Blank) -> np.ndarray:
        """Elements whose middles on the flat ply lie within a patch."""
        place = [*keys, "patch"]
        try:
            outline = Outline(checked_outline(np.array(corners)))
        except InputError as error:
            self._file.refuse(place, f"patch: {error}")
        middle = blank.material_coordinates[blank.quads].mean(axis=1)
        elements = np.flatnonzero(outline.nearest(middle)[0] >= 0.0)
        if not len(elements):
            self._file.refuse(place, "patch: no element of the ply has its middle in it; make it larger, or move it")
        return elements

    def grippers(self, ply: str, blank: Blank, outline: np.ndarray) -> tuple[Gripper, ...]:
        """At a ply with this mesh and these corners of its outline."""
        found: list[Gripper] = []
        for kind in ("spring", "gripper"):
            tables: Sequence[SpringTable] = getattr(self._file.job, kind)
            for index, table in enumerate(tables):
                if self.ply([kind, index], table.ply) != ply:
                    continue
                try:
                    found += _grippers(table, blank, outline)
                except InputError as error:
                    self._file.refuse([kind, index], str(error).removeprefix("Gripper: "))
        return tuple(found)

    def ply(self, keys: Sequence[object], name: str | None) -> str:
        """The ply that a table under some ``keys`` names.

        Raises:
            InputError: there is no such ply, or it is not named where there are several.
        """
        place = [*keys, "ply"]
        if name is None and len(self._names) == 1:
            return self._names[0]
        if name is None:
            self._file.refuse(place, f"ply: is required, one of {', '.join(self._names)}")
        if name not in self._names:
            hint = did_you_mean(name, self._names)
            self._file.refuse(place, f"ply = {name!r}: there is none; there are {', '.join(self._names)}{hint}")
        return name


def _grippers(table: SpringTable, blank: Blank, outline: np.ndarray) -> Iterator[Gripper]:
    places = list(_places(table, blank, outline))
    for number, place in enumerate(places, start=1):
        direction = place.outwards if table.direction is None else np.array(table.direction)
        yield Gripper(
            table.name if len(places) == 1 else f"{table.name}_{number}",
            place.nodes,
            tuple(direction.tolist()),
            table.stiffness,
            length=table.length,
            pretension=table.pretension,
            ramp_time=table.ramp if table.pretension else 0.0,
            largest_force=table.largest_force,
            motion=table.on_path(_motion(table)) if isinstance(table, GripperTable) else Fixed(),
            release_time=table.release,
        )


def _motion(table: GripperTable) -> Motion:
    if table.stroke == 0.0 or table.speed is None:
        return Fixed()
    return Stroke.smooth(table.stroke, table.speed, RAMP_SHARE * abs(table.stroke) / table.speed)


def _places(table: SpringTable, blank: Blank, outline: np.ndarray) -> Iterator[Place]:
    plan = blank.node_position[:, :2]
    middle = plan.mean(axis=0)
    if table.edge is not None:
        axis, sign = "xyz".index(table.edge[1]), 1.0 if table.edge[0] == "+" else -1.0
        reach = sign * plan[:, axis]
        size = float(np.sqrt(np.ptp(plan, axis=0).prod() / blank.element_count))
        outwards = np.zeros(3)
        outwards[axis] = sign
        yield Place(np.flatnonzero(reach >= reach.max() - EDGE * size), outwards)
        return
    points = corners_of(outline) if table.corners else np.array(table.points)
    for point in points:
        distance = np.linalg.norm(plan - point, axis=1)
        nodes = np.flatnonzero(distance <= table.radius) if table.radius else np.array([int(np.argmin(distance))])
        size = float(np.sqrt(np.ptp(plan, axis=0).prod() / blank.element_count))
        if not len(nodes) or distance[nodes].min() > max(table.radius, size):
            x, y = 1e3 * point
            raise InputError(f"the ply has no node at ({x:.4g}, {y:.4g}) mm; give a point on it, or a larger radius")
        away = np.append(point - middle, 0.0)
        if np.linalg.norm(away) < 1e-6 * size:
            raise InputError("direction: is required at the middle of the ply, where nothing is outwards")
        yield Place(nodes, away / np.linalg.norm(away))


def corners_of(outline: np.ndarray) -> np.ndarray:
    """Points at which an outline turns clearly, (k, 2).

    Raises:
        InputError: it has none.
    """
    a, b = outline - np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0) - outline
    turn = np.degrees(np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1)))
    found = outline[np.abs(turn) > CORNER]
    if not len(found):
        raise InputError("corners: the outline has none; give points")
    return found
