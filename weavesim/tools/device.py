"""Tools as the kernels take them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp

from ..kernels.contact.tool_distance import tool_struct
from ..kernels.contact.tool_shapes import part_struct
from ..kernels.stepping.tools import FORCE, STROKE, ToolDrive
from ..process.strokes import ForceDriven
from .shapes import IDENTITY, Shape
from .tool import Tool

if TYPE_CHECKING:
    pass


@dataclass(frozen=True)
class DeviceTools:
    """Tools as the kernels take them; arrays on one device.

    Attributes:
        tool: ``kernels.distance.tool_struct(real)``, (tool_count,).
        part: ``kernels.distance.part_struct(real)``, (part_count,), all parts of all tools.
        drive: ``kernels.tool_motion.ToolDrive``, (tool_count,).
        axis: directions of motion, (tool_count,) of vec3d.
        curve_times, curve_values: knots of all motions [s], [m] or [N], (knot_count,) of float64.
        displacement: along each axis, (tool_count,) of float64 [m]; its value at time zero.
        velocity: likewise [m/s].
        total_reaction: force of the sheet on each tool, (tool_count,) of vec3d [N].
        work: rows: work of the tool on the sheet, work of the driving force; (2, tool_count) of float64 [J].
        shapes: keeps the sampled volumes alive that ``part`` refers to.
        shape_kinds: of all parts, ascending; see kernels/contact/tool_distance.py.
        rotated: True if some part is.
    """

    tool: wp.array
    part: wp.array
    drive: wp.array
    axis: wp.array
    curve_times: wp.array
    curve_values: wp.array
    displacement: wp.array
    velocity: wp.array
    total_reaction: wp.array
    work: wp.array
    shapes: tuple[Shape, ...]
    shape_kinds: tuple[int, ...]
    rotated: bool

    @property
    def count(self) -> int:
        return self.tool.shape[0]


def build_device_tools(tools: Sequence[Tool], real: type, device: str) -> DeviceTools:
    """Arrays for ``node_motion_kernel`` and ``tool_motion_kernel``.

    Args:
        tools: in the order of every array; may be empty.
        real: wp.float32 or wp.float64, of distances and frames.
        device: Warp's name of it.
    """
    ToolStruct, PartStruct = tool_struct(real), part_struct(real)
    tool_structs: list[Any] = []
    part_structs: list[Any] = []
    drives: list[Any] = []
    shapes: list[Shape] = []
    times, values = [np.empty(0)], [np.empty(0)]
    displacements: list[float] = []
    velocities: list[float] = []
    knot_count = 0
    for tool in tools:
        tool_data = ToolStruct()
        tool_data.first_part = len(part_structs)
        parts = tool.shape.parts()
        tool_data.part_count = len(parts)
        tool_data.axis = tool.axis
        tool_data.friction = tool.friction
        for part in parts:
            part_data = PartStruct()
            part.fill(part_data, device)
            part_structs.append(part_data)
            shapes.append(part)
            # samples are cut to their reach, and have a side of which the box's outside knows nothing
            tool_data.blind_distance = max(tool_data.blind_distance, part_data.reach)
        tool_structs.append(tool_data)

        curve_times, curve_values = tool.motion.curve()
        driven = isinstance(tool.motion, ForceDriven)
        drive = ToolDrive()
        drive.kind = int(FORCE if driven else STROKE)
        drive.first_knot = knot_count
        drive.knot_count = len(curve_times)
        drive.mass = tool.motion.mass if isinstance(tool.motion, ForceDriven) else 0.0
        drives.append(drive)
        times.append(curve_times)
        values.append(curve_values)
        knot_count += len(curve_times)
        displacements.append(0.0 if driven else float(np.interp(0.0, curve_times, curve_values)))
        velocities.append(0.0 if driven else _initial_velocity(curve_times, curve_values))

    def array(data: list | np.ndarray, dtype: type) -> wp.array:
        return wp.array(data, dtype=dtype, device=device) if len(data) else wp.empty(0, dtype=dtype, device=device)

    count = len(tool_structs)
    return DeviceTools(
        tool=array(tool_structs, ToolStruct),
        part=array(part_structs, PartStruct),
        drive=array(drives, ToolDrive),
        axis=array([tool.axis for tool in tools], wp.vec3d),
        curve_times=array(np.concatenate(times), wp.float64),
        curve_values=array(np.concatenate(values), wp.float64),
        displacement=array(displacements, wp.float64),
        velocity=array(velocities, wp.float64),
        total_reaction=wp.zeros(count, dtype=wp.vec3d, device=device),
        work=wp.zeros((2, count), dtype=wp.float64, device=device),
        shapes=tuple(shapes),
        shape_kinds=tuple(sorted({part.kind for part in part_structs})),
        rotated=any(part.rotation != IDENTITY for part in shapes),
    )


def _initial_velocity(times: np.ndarray, displacements: np.ndarray) -> float:
    """Slope of the stroke just after time zero [m/s]."""
    k = int(np.searchsorted(times, 0.0, side="right"))
    if k == 0 or k == len(times):
        return 0.0
    return float((displacements[k] - displacements[k - 1]) / (times[k] - times[k - 1]))
