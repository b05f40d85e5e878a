"""Tools in the form that the kernels read."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import warp as wp

from ..errors import InputError
from ..kernels.contact.friction import tool_friction_struct
from ..kernels.contact.tool_distance import tool_struct
from ..kernels.contact.tool_shapes import part_struct, shape_kind, shape_number
from ..kernels.stepping.tools import FORCE, STROKE, ToolDrive, ToolDrives
from ..process.friction import law_of
from ..process.friction_device import argument_kind, viscous_rates
from .carried.device import build_carriers, poses
from .sampling import SampledDistance, Samples
from .shapes import Shape

if TYPE_CHECKING:
    from .tool import Tool


@dataclass(frozen=True)
class DeviceTools:
    """Constants of all tools of a run, in the form that the kernels read; arrays on one device.

    Attributes:
        tool: ``kernels.contact.tool_distance.tool_struct(real)``, (tool_count,).
        part: ``kernels.contact.tool_shapes.part_struct(real)``, (part_count,), all parts of all tools.
        drives: ``kernels.stepping.tools.ToolDrives``: how all of them move.
        waits: whether any stroke has a largest force.
        carriers: ``kernels.carried.motion.Carriers``: what carries and turns them; None where no tool is carried.
        initial_pose: at time zero, (tool_count, entries of ToolPoseRow); (0, entries) where no tool is carried.
        initial_displacement, initial_velocity: along each axis at time zero, (tool_count,) [m], [m/s].
        samples: keeps alive the sampled volumes that ``part`` refers to.
        law: ``kernels.contact.friction.tool_friction_struct(real)``, (tool_count,): friction laws.
        argument, coefficient: their tables, one after the other.
    """

    tool: wp.array
    part: wp.array
    drives: Any
    waits: bool
    carriers: Any
    initial_pose: np.ndarray
    initial_displacement: np.ndarray
    initial_velocity: np.ndarray
    samples: tuple[SampledDistance, ...]
    law: wp.array
    argument: wp.array
    coefficient: wp.array

    @property
    def count(self) -> int:
        """Tools of the run."""
        return self.tool.shape[0]


# A GPU moves as many tools at a time.
GPU_THREAD_COUNT = 32


def build_device_tools(
    tools: Sequence[Tool],
    real: type,
    device: str,
    samples: Samples = MappingProxyType({}),
    stiffness: Sequence[float] = (),
    carried: Sequence[float] = (),
) -> DeviceTools:
    """Arrays for ``node_motion_kernel`` and ``tool_motion_kernel``.

    Args:
        tools: in the order of every array; may be empty.
        real: wp.float32 or wp.float64, of distances and frames.
        device: name in Warp.
        samples: of all meshes among the tools' parts, on the same device; see ``sample_meshes``.
        stiffness: largest stiffness of each tool's contact [N/m]; none for tools on their own, which get no damper.
        carried: rate of a viscous film on each tool that the time step carries [Pa s/m]; none for tools on their own.

    Raises:
        InputError: a part is of an unknown kind, or lacks one of its dimensions.
    """
    parts = [part for tool in tools for part in tool.shape.parts()]
    curves = [tool.motion.curve() for tool in tools]
    tables = [law_of(tool.friction).table() for tool in tools]

    start = np.array([_at_start(tool, *curve) for tool, curve in zip(tools, curves, strict=True)]).reshape(-1, 2)

    def array(data: list | np.ndarray, dtype: type) -> wp.array:
        return wp.array(data, dtype=dtype, device=device) if len(data) else wp.empty(0, dtype=dtype, device=device)

    drives = ToolDrives()
    drives.thread_count = GPU_THREAD_COUNT if wp.get_device(device).is_cuda else 1
    drives.drive = array(_drives(tools, curves, stiffness or [0.0] * len(tools)), ToolDrive)
    drives.axis = array([tool.axis for tool in tools], wp.vec3d)
    drives.curve_time = array(np.concatenate([np.empty(0), *(times for times, _ in curves)]), wp.float64)
    drives.curve_value = array(np.concatenate([np.empty(0), *(values for _, values in curves)]), wp.float64)
    carriers = build_carriers(tools, device)
    return DeviceTools(
        tool=array(_tool_data(tools, real), tool_struct(real)),
        part=array([_part_data(part, real, samples) for part in parts], part_struct(real)),
        drives=drives,
        waits=strokes_wait(tools),
        carriers=carriers,
        initial_pose=poses(tools if carriers is not None else (), 0.0, start[:, 0]),
        initial_displacement=start[:, 0],
        initial_velocity=start[:, 1],
        samples=tuple(samples.values()),
        law=array(_laws(tools, real, carried or [math.inf] * len(tools)), tool_friction_struct(real)),
        argument=array(np.concatenate([np.empty(0), *(arguments for arguments, _ in tables)]), real),
        coefficient=array(np.concatenate([np.empty(0), *(values for _, values in tables)]), real),
    )


def strokes_wait(tools: Iterable[Tool]) -> bool:
    """Whether any of the tools makes a stroke that waits at a largest force."""
    return any(tool.motion.limiting_force > 0.0 for tool in tools)


def _tool_data(tools: Sequence[Tool], real: type) -> list[Any]:
    result: list[Any] = []
    first_part = 0
    for tool in tools:
        parts = tool.shape.parts()
        data = tool_struct(real)()
        data.first_part = first_part
        data.part_count = len(parts)
        data.axis = tool.axis
        # of one coefficient; laws are read from their tables
        data.friction = law_of(tool.friction).table()[1][0]
        first_part += len(parts)
        result.append(data)
    return result


def _laws(tools: Sequence[Tool], real: type, carried: Sequence[float]) -> list[Any]:
    """Friction of every tool as a Warp ``ToolFriction``."""
    result: list[Any] = []
    first = 0
    for tool, rate in zip(tools, carried, strict=True):
        friction, data = law_of(tool.friction), tool_friction_struct(real)()
        data.argument_kind = argument_kind(friction)
        data.first, data.last = first, first + len(friction.table()[1])
        data.viscosity, data.film = viscous_rates(friction, rate)
        first = data.last
        result.append(data)
    return result


def _part_data(part: Shape, real: type, samples: Samples) -> Any:
    """Kind, frame and dimensions of a part as a Warp ``ToolPart``."""
    try:
        known = shape_kind(part.distance_function)
    except ValueError as error:
        raise InputError(f"{type(part).__name__}.distance_function: {error}") from error
    dimensions = part.dimensions() if part.surface is None else samples[part.surface].dimensions()
    if set(dimensions) != set(known.dimensions):
        raise InputError(
            f"{type(part).__name__} has the dimensions {', '.join(dimensions) or 'none'}, but the distance "
            f"function {part.distance_function!r} takes {', '.join(known.dimensions) or 'none'}: state these in its "
            "dimensions()"
        )
    data = part_struct(real)()
    data.kind = shape_number(part.distance_function)
    data.origin = part.origin
    if part.surface is not None:  # samples lie about their own centre
        data.origin = np.array(part.origin) + np.array(part.rotation) @ samples[part.surface].centre
    data.rotation = [list(row) for row in part.rotation]
    for name, value in dimensions.items():
        if name in known.places:
            field, index = known.places[name]
            getattr(data, field)[index] = value
        else:
            setattr(data, name, value)
    return data


def _drives(
    tools: Sequence[Tool], curves: Sequence[tuple[np.ndarray, np.ndarray]], stiffness: Sequence[float]
) -> list[Any]:
    result: list[Any] = []
    first_knot = 0
    for tool, (times, _), of_contact in zip(tools, curves, stiffness, strict=True):
        drive = ToolDrive()
        drive.kind = int(FORCE if tool.motion.by_force else STROKE)
        drive.first_knot = first_knot
        drive.knot_count = len(times)
        drive.mass = tool.motion.driven_mass
        drive.damping, drive.fading = tool.motion.damper(of_contact)
        drive.largest_force = tool.motion.limiting_force
        drive.stiffness = of_contact
        drive.stop, drive.stop_way = tool.motion.spacers
        first_knot += len(times)
        result.append(drive)
    return result


def _at_start(tool: Tool, times: np.ndarray, displacements: np.ndarray) -> tuple[float, float]:
    """Displacement [m] and velocity [m/s] at time zero."""
    if tool.motion.by_force:
        return 0.0, 0.0
    return float(np.interp(0.0, times, displacements)), _initial_velocity(times, displacements)


def _initial_velocity(times: np.ndarray, displacements: np.ndarray) -> float:
    """Slope of the stroke just after time zero [m/s]."""
    k = int(np.searchsorted(times, 0.0, side="right"))
    if k == 0 or k == len(times):
        return 0.0
    return float((displacements[k] - displacements[k - 1]) / (times[k] - times[k - 1]))
