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
from ..sheet.symmetry import AXES
from ..sheet.topology import length_tolerance
from .placing import RAMP_SHARE
from .read import JobFile
from .schema import GripperTable, PressureTable, SpringTable

# Nodes of an edge lie within this share of an element of the furthest one.
EDGE = 0.1
# A corner is where an outline turns by more than this [degrees].
CORNER = 15.0


class Place(NamedTuple):
    """Where a spring pulls.

    Attributes:
        nodes: that it pulls at, (k,).
        outwards: direction out of the ply, (3,).
        cut_by: planes of symmetry that cut it, each of which leaves half of its stiffness and forces.
    """

    nodes: np.ndarray
    outwards: np.ndarray
    cut_by: tuple[str, ...] = ()

    @property
    def share(self) -> float:
        """Of the whole place that is computed."""
        return 0.5 ** len(self.cut_by)


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
                    found += _grippers(table, blank, outline, self._file.job.process.symmetry)
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


def _grippers(table: SpringTable, blank: Blank, outline: np.ndarray, planes: Sequence[str]) -> Iterator[Gripper]:
    """Of a table, whose stiffness and forces are those of the whole place."""
    places = list(_places(table, blank, outline, planes))
    for number, place in enumerate(places, start=1):
        direction = place.outwards if table.direction is None else np.array(table.direction)
        for plane in place.cut_by:
            if abs(direction[AXES[plane]]) > 1e-6 * np.linalg.norm(direction):
                raise InputError(
                    f"direction = {tuple(table.direction or ())}: the plane of symmetry {plane} = 0 cuts this place, "
                    f"whose mirror image would be pulled the other way; give a direction with {plane} = 0, or leave "
                    f"{plane!r} out of symmetry"
                )
        limit = table.largest_force
        yield Gripper(
            table.name if len(places) == 1 else f"{table.name}_{number}",
            place.nodes,
            tuple(direction.tolist()),
            table.stiffness * place.share,
            length=table.length,
            pretension=table.pretension * place.share,
            ramp_time=table.ramp if table.pretension else 0.0,
            largest_force=None if limit is None else limit * place.share,
            motion=table.on_path(_motion(table)) if isinstance(table, GripperTable) else Fixed(),
            release_time=table.release,
        )


def _motion(table: GripperTable) -> Motion:
    if table.stroke == 0.0 or table.speed is None:
        return Fixed()
    return Stroke.smooth(table.stroke, table.speed, RAMP_SHARE * abs(table.stroke) / table.speed)


def _places(table: SpringTable, blank: Blank, outline: np.ndarray, planes: Sequence[str]) -> Iterator[Place]:
    plan = blank.node_position[:, :2]
    size = float(np.sqrt(np.ptp(plan, axis=0).prod() / blank.element_count))
    near = length_tolerance(blank)
    if table.edge is not None:
        yield _edge(table.edge, plan, size, [(plane, np.abs(plan[:, AXES[plane]]) <= near) for plane in planes])
        return
    middle = plan.mean(axis=0)
    middle[[AXES[plane] for plane in planes]] = 0.0  # that of the whole ply
    points = corners_of(outline, planes, near) if table.corners else np.array(table.points)
    for point in points:
        distance = np.linalg.norm(plan - point, axis=1)
        nodes = np.flatnonzero(distance <= table.radius) if table.radius else np.array([int(np.argmin(distance))])
        x, y = 1e3 * point
        if not len(nodes) or distance[nodes].min() > max(table.radius, size):
            raise InputError(f"the ply has no node at ({x:.4g}, {y:.4g}) mm; give a point on it, or a larger radius")
        cut_by = tuple(plane for plane in planes if (np.abs(plan[nodes, AXES[plane]]) <= near).any())
        for plane in cut_by:
            if table.radius and abs(point[AXES[plane]]) > near:
                raise InputError(
                    f"radius: the patch around ({x:.4g}, {y:.4g}) mm reaches the plane of symmetry {plane} = 0, and so "
                    "into its own mirror image; put its middle on the plane, or take a smaller radius"
                )
        away = np.append(point - middle, 0.0)
        away[[AXES[plane] for plane in cut_by]] = 0.0
        if np.linalg.norm(away) < 1e-6 * size:
            if table.direction is None:
                raise InputError("direction: is required at the middle of the ply, where nothing is outwards")
            away[2] = 1.0
        yield Place(nodes, away / np.linalg.norm(away), cut_by)


def _edge(edge: str, plan: np.ndarray, size: float, held: Sequence[tuple[str, np.ndarray]]) -> Place:
    """All nodes of an edge; ``held`` are the planes of symmetry with the nodes (n,) on them."""
    axis, sign = "xyz".index(edge[1]), 1.0 if edge[0] == "+" else -1.0
    reach = sign * plan[:, axis]
    nodes = np.flatnonzero(reach >= reach.max() - EDGE * size)
    cut_by = []
    for plane, on_plane in held:
        if AXES[plane] == axis and on_plane[nodes].any():
            raise InputError(
                f"edge = {edge!r}: there the plane of symmetry {plane} = 0 cuts the ply, which has no edge; the other "
                f"side, {'-' if sign > 0 else '+'}{edge[1]}, stands for both"
            )
        if on_plane[nodes].any():
            cut_by.append(plane)
    outwards = np.zeros(3)
    outwards[axis] = sign
    return Place(nodes, outwards, tuple(cut_by))


def corners_of(outline: np.ndarray, planes: Sequence[str] = (), near: float = 0.0) -> np.ndarray:
    """Points at which an outline turns clearly, (k, 2); of one that planes of symmetry cut, those of the whole outline.

    Args:
        outline: corners in order, (n, 2) [m].
        planes: at which it is cut.
        near: distance at which a corner lies on a plane [m].

    Raises:
        InputError: it has none.
    """
    a, b = outline - np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0) - outline
    turn = np.abs(np.degrees(np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))))
    for plane in planes:
        axis = AXES[plane]
        on_plane = np.abs(outline[:, axis]) <= near
        along_a, along_b = on_plane & np.roll(on_plane, 1), on_plane & np.roll(on_plane, -1)
        # a side in the plane is none of the whole outline, which turns by twice what the other side is off the normal
        for along, other in ((along_a, b), (along_b, a)):
            lean = np.degrees(np.arctan2(np.abs(other[:, 1 - axis]), np.abs(other[:, axis])))
            turn = np.where(along, np.minimum(turn, 2.0 * lean), turn)
        turn = np.where(along_a & along_b, 0.0, turn)
    inner = np.all([np.abs(outline[:, AXES[plane]]) <= near for plane in planes], axis=0)
    if len(planes) == len(AXES):
        turn = np.where(inner, 0.0, turn)
    found = outline[turn > CORNER]
    if not len(found):
        raise InputError("corners: the outline has none; give points")
    return found
