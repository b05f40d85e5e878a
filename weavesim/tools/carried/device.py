"""What carries the tools of a run, in the form that the kernels read, and their poses in a state."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp

from ...kernels.carried.motion import CURVE_COUNT, CarriedMotion, Carrier, Carriers
from ...kernels.rows import ToolPoseRow
from ...process.motions.paths import PathMotion, Pose

if TYPE_CHECKING:
    from ..tool import Tool


def build_carriers(tools: Sequence[Tool], device: str) -> Any:
    """Curves and poses of all tools, as ``carried_motion_kernel`` reads them; None where no tool is carried."""
    if not any(tool.motion.is_carried for tool in tools):
        return None
    curves: list[tuple[np.ndarray, np.ndarray]] = []
    carriers: list[Any] = []
    for tool in tools:
        path = PathMotion.of(tool.motion)
        placed, carrier = Pose.from_numbers(path.placed), Carrier()
        carrier.rotation, carrier.shift = placed.matrix.tolist(), placed.shift
        carrier.point, carrier.axis = path.point, path.axis
        carriers.append(carrier)
        curves += path.curves()
    assert len(curves) == int(CURVE_COUNT) * len(tools)
    result = Carriers()
    first = np.cumsum([0, *(len(start) for start, _ in curves)])
    result.carrier = wp.array(carriers, dtype=Carrier, device=device)
    result.first_piece = wp.array(first, dtype=wp.int32, device=device)
    result.start = wp.array(np.concatenate([start for start, _ in curves]), dtype=wp.float64, device=device)
    result.piece = wp.array(np.concatenate([piece for _, piece in curves]), dtype=wp.vec4d, device=device)
    return result


def carried_motion(state: Any) -> Any:
    """The arrays of a ``State`` that ``carried_motion_kernel`` writes, as its ``CarriedMotion``."""
    result = CarriedMotion()
    result.displacement, result.velocity = state.tool_displacement, state.tool_velocity
    result.pose, result.moment = state.tool_pose, state.tool_moment
    return result


def poses(tools: Sequence[Tool], time: float, displacement: np.ndarray) -> np.ndarray:
    """Entries of the poses of all tools at a time, with the rates just after it, (tool_count, entries).

    Args:
        tools: of a run.
        time: [s].
        displacement: along each axis, (tool_count,) [m].

    Returns:
        Entries as in ``ToolPoseRow``.
    """
    result = np.zeros((len(tools), ToolPoseRow.row_count()))
    for k, tool in enumerate(tools):
        path, along = PathMotion.of(tool.motion), displacement[k] * np.array(tool.axis)
        pose, (way, angle) = path.pose_at(time, along), path.state_at(time)
        result[k, ToolPoseRow.rotation.span], result[k, ToolPoseRow.shift.span] = pose.rotation, pose.shift
        result[k, ToolPoseRow.pivot.span] = np.array(path.point) + way + along
        result[k, ToolPoseRow.offset.span], result[k, int(ToolPoseRow.angle)] = way, angle
        result[k, ToolPoseRow.velocity.span], result[k, ToolPoseRow.spin.span] = path.rates_at(time)
    return result


def pose_of(entries: np.ndarray) -> Pose:
    """The pose in the entries of one tool."""
    return Pose.of(entries[ToolPoseRow.rotation.span], entries[ToolPoseRow.shift.span])
