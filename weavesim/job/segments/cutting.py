"""A tool of a job as segments: sectors of its surface, each with its share of the force or a load of its own."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...errors import InputError
from ...process.strokes import Fixed, ForceDriven, Motion
from ...tools.mesh_features import face_normals
from ...tools.mesh_tool import MeshShape
from ...tools.segments.cutting import sector_of
from ...tools.shapes import Shape
from ...tools.surfaces.rim import facing_up
from ..placing import FORCE_RAMP
from ..schema import ToolTable
from .tables import gap_motion

# Sectors of a smaller share of the area are slivers that carry nothing.
LEAST_SHARE = 1.0e-4


class Segment(NamedTuple):
    """One sector of a tool.

    Attributes:
        name: of the segment.
        shape: its surface, where the whole tool starts.
        share: of the area of the tool in plan.
        number: counter-clockwise from 1 on.
    """

    name: str
    shape: Shape
    share: float
    number: int


def segments_of(table: ToolTable, shape: Shape, facing: str | None) -> list[Segment]:
    """The sectors of a tool's side that faces the sheet, around the middle of its plan.

    Raises:
        InputError: a tool that is no mesh, or a sector of which nothing is left.
    """
    assert table.segments is not None
    if not isinstance(shape, MeshShape) or facing is None:
        raise InputError("segments: a tool from a file, or a ring, is cut; a built-in shape is not")
    flip = np.array([1.0, 1.0, 1.0] if facing == "up" else [1.0, -1.0, -1.0])
    vertices, faces = shape.display_triangles()
    part = facing_up(np.asarray(vertices) * flip, np.asarray(faces))
    points = part.vertices * flip
    middle = 0.5 * (points[:, :2].min(axis=0) + points[:, :2].max(axis=0))
    centre = (float(middle[0]), float(middle[1]))
    step, begin = 2.0 * math.pi / table.segments, math.radians(table.segments_from)
    parts = [
        sector_of((points, part.faces), centre, begin + k * step, begin + (k + 1) * step) for k in range(table.segments)
    ]
    areas = np.array([_plan_area(*each) for each in parts])
    for k in np.flatnonzero(areas < LEAST_SHARE * areas.sum()):
        raise InputError(f"segments = {table.segments}: nothing of the tool lies in segment {k + 1}; take fewer")
    side = (0.0, 0.0, 1.0 if facing == "up" else -1.0)
    names = [f"{table.name}_{k + 1}" for k in range(table.segments)]
    return [
        Segment(name, MeshShape.from_triangles(*each, name=f"tool {name}", side=side), float(area / areas.sum()), k + 1)
        for k, (name, each, area) in enumerate(zip(names, parts, areas, strict=True))
    ]


def _plan_area(vertices: np.ndarray, faces: np.ndarray) -> float:
    if not len(faces):
        return 0.0
    normal, area = face_normals(vertices, faces)
    return float(np.abs(normal[:, 2]) @ area)


def load_of(table: ToolTable, segment: Segment, whole: Motion) -> tuple[Motion, float]:
    """How a segment moves, and how far back from where the whole tool starts [m].

    Raises:
        InputError: a stroke, which would move all segments alike.
    """
    if table.stroke is not None or table.is_carried:
        raise InputError(
            "segments: they move by forces or stand at gaps; strokes, paths and rotations move whole tools"
        )
    own = next((each for each in table.segment if each.number == segment.number), None)
    mass = table.mass * segment.share
    if own is not None and own.gap is not None:
        return Fixed(), own.gap
    if own is not None and own.gaps is not None:
        assert own.times is not None
        return gap_motion(own.times, own.gaps)
    if own is not None and own.forces is not None:
        assert own.times is not None
        return ForceDriven(own.times, own.forces, mass, stop=table.stop), 0.0
    if table.gaps is not None and own is None:
        assert table.times is not None
        return gap_motion(table.times, table.gaps)
    largest = max(whole.forces) if isinstance(whole, ForceDriven) else 0.0
    if own is not None and own.force is not None and largest <= 0.0:
        ramp = FORCE_RAMP if table.ramp is None else table.ramp
        return ForceDriven.constant(own.force, mass, ramp, stop=table.stop), 0.0
    if not isinstance(whole, ForceDriven):
        raise InputError(f"segment {segment.number}: it has no load; give the tool a force, or the segment its own")
    share = segment.share if own is None or own.force is None else own.force / largest
    forces = tuple(force * share for force in whole.forces)
    return whole.model_copy(update={"forces": forces, "mass": mass}), 0.0
