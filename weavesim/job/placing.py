"""Where plies and tools are at the start, and how the tools move from there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..process.strokes import Fixed, ForceDriven, Motion, Stroke
from ..tools.shapes import Shape
from .schema import ToolTable
from .segments.tables import gap_motion

# A ramp is this share of the time of its stroke, and that of a force takes this long [s].
RAMP_SHARE = 0.05
FORCE_RAMP = 2.0e-3
UP = (0.0, 0.0, 1.0)
DOWN = (0.0, 0.0, -1.0)


class Box(NamedTuple):
    """A box in plan, (2,) each [m]."""

    lower: np.ndarray
    upper: np.ndarray


def reach(shape: Shape, box: Box, facing: str) -> float | None:
    """Height of the highest point of a shape that faces up, or the lowest of one that faces down, over a box [m].

    None if no part of it is over the box.
    """
    vertices, faces = shape.display_triangles()
    corners = np.asarray(vertices, dtype=np.float64)[faces]
    plan = corners[:, :, :2]
    over = (plan.min(axis=1) <= box.upper).all(axis=1) & (plan.max(axis=1) >= box.lower).all(axis=1)
    within = ((plan >= box.lower) & (plan <= box.upper)).all(axis=(1, 2))
    sign = 1.0 if facing == "up" else -1.0
    heights = list(sign * corners[within][:, :, 2].ravel())
    best = max(heights, default=-np.inf)
    rest = corners[over & ~within]
    # the highest first: most need not be cut
    for triangle in rest[np.argsort(-(sign * rest[:, :, 2]).max(axis=1), kind="stable")]:
        if (sign * triangle[:, 2]).max() <= best:
            break
        cut = _cut(triangle, box)
        if len(cut):
            best = max(best, float((sign * cut[:, 2]).max()))
    return sign * float(best) if np.isfinite(best) else None


def _cut(polygon: np.ndarray, box: Box) -> np.ndarray:
    """The part of a polygon (k, 3) over a box (Sutherland and Hodgman)."""
    for axis in range(2):
        for bound, sign in ((box.lower[axis], 1.0), (box.upper[axis], -1.0)):
            depth = sign * (polygon[:, axis] - bound)
            found = []
            for k in range(len(polygon)):
                a, b = polygon[k - 1], polygon[k]
                da, db = depth[k - 1], depth[k]
                if (da >= 0.0) != (db >= 0.0):
                    found.append(a + da / (da - db) * (b - a))
                if db >= 0.0:
                    found.append(b)
            polygon = np.array(found).reshape(-1, 3)
    return polygon


def axis_of(tool: ToolTable, facing: str | None) -> tuple[float, float, float]:
    """Direction of a tool's motion.

    Raises:
        InputError: it is not given, and not known.
    """
    if tool.axis is not None:
        return tool.axis
    if facing is None:
        if (
            tool.stroke is None
            and tool.force is None
            and tool.forces is None
            and tool.gaps is None
            and tool.segments is None
        ):
            return UP
        raise InputError('faces: is required, or an axis: "up" for a tool below the sheet, "down" for one above it')
    return UP if facing == "up" else DOWN


def start_shift(tool: ToolTable, facing: str | None, reached: float | None, face: float) -> float:
    """How far along its axis a tool is from where it is drawn, at the start [m].

    Args:
        tool: as given.
        facing: "up" or "down", towards the sheet.
        reached: height of the point of the tool that meets the sheet first, where it is drawn [m].
        face: height of the face of the sheet that it meets [m].

    Raises:
        InputError: a tool that cannot meet the sheet along its axis.
    """
    if tool.start == "drawn":
        return -tool.clearance
    axis = np.array(axis_of(tool, facing), dtype=np.float64)
    if facing is None or abs(axis[2]) < 1e-6 * np.linalg.norm(axis) or np.linalg.norm(axis[:2]) > 1e-9:
        raise InputError('start = "touching": needs faces, and a vertical axis; give start = "drawn" and a clearance')
    if reached is None:
        raise InputError('start = "touching": no part of the tool is over the ply; check its place and its unit')
    return (face - reached) * float(np.sign(axis[2])) - tool.clearance


def motion_of(tool: ToolTable, shift: float, share: float) -> Motion:
    """How a tool moves: along its axis, and along a path and about an axis.

    Args:
        tool: as given.
        shift: see ``start_shift``.
        share: of the whole that is computed, by symmetry.

    Raises:
        InputError: a stroke that is none.
    """
    return tool.carried(_along_axis(tool, shift, share))


def _along_axis(tool: ToolTable, shift: float, share: float) -> Motion:
    if tool.force is not None:
        ramp = FORCE_RAMP if tool.ramp is None else tool.ramp
        return ForceDriven.constant(tool.force * share, tool.mass * share, ramp, stop=tool.stop)
    if tool.forces is not None and tool.times is not None:
        forces = tuple(force * share for force in tool.forces)
        return ForceDriven(tool.times, forces, tool.mass * share, stop=tool.stop)
    if tool.gaps is not None and tool.times is not None:
        return gap_motion(tool.times, tool.gaps)[0]
    if tool.stroke is None:
        return Fixed()
    travel = -shift if isinstance(tool.stroke, str) else tool.stroke
    if isinstance(tool.stroke, str) and not travel > 0.0:
        raise InputError(
            f'stroke = "close": the tool starts {abs(1e3 * travel):.4g} mm beyond where it is drawn; start it '
            '"touching" with a clearance, or give the travel'
        )
    assert tool.speed is not None
    ramp = RAMP_SHARE * abs(travel) / tool.speed if tool.ramp is None else tool.ramp
    limit = None if tool.largest_force is None else tool.largest_force * share
    return Stroke.smooth(travel, tool.speed, ramp, start_time=tool.delay, largest_force=limit)
