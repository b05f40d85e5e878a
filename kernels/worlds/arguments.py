"""Arguments of the kernels that step many worlds: what one world gives a kernel of its own, in one struct each."""

from functools import cache

import warp as wp

from ..cell.law import CellLaw
from ..contact.penalty import touch_struct
from ..lane_types import lane_types
from ..loads.grippers import Grips
from ..shell.frequency import step_bounds_struct
from ..shell.kinematics import element_struct
from ..shell.laws import SheetTraits, sheet_struct
from ..stepping.node_data import node_laws_struct, node_struct, surroundings_struct
from ..stepping.sample_data import sampled_struct, samples_struct
from ..stepping.tools import ToolBooks, ToolDrives


@cache
def force_arguments(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """What ``element_force_function`` takes."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class ForceArguments:
        sheet: sheet_struct(real, lane_count, cell, traits)
        motion: wp.array(dtype=real)
        clock: wp.array(dtype=wp.float64)
        cell_unknowns: wp.array2d(dtype=lanes)
        cell_report: wp.array2d(dtype=lanes)
        slip: wp.array2d(dtype=lanes)
        corner_force: wp.array2d(dtype=lanes)

    return ForceArguments


@cache
def node_arguments(real: type, lane_count: int):
    """What ``node_motion_function`` takes."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class NodeArguments:
        nodes: node_struct(real, lane_count)
        laws: node_laws_struct(real)
        around: surroundings_struct(real, lane_count)
        corners: wp.array(dtype=real)
        motion: wp.array2d(dtype=lanes)
        touch: touch_struct(real, lane_count)
        works: wp.array2d(dtype=lanes)

    return NodeArguments


@cache
def sample_arguments(real: type, lane_count: int):
    """What ``surface_contact_function`` takes."""

    @wp.struct
    class SampleArguments:
        samples: samples_struct(real, lane_count)
        laws: node_laws_struct(real)
        around: surroundings_struct(real, lane_count)
        moved: wp.array2d(dtype=real)
        motion: wp.array(dtype=real)
        corner_force: wp.array(dtype=real)
        sampled: sampled_struct(real, lane_count)

    return SampleArguments


@cache
def frequency_arguments(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """What ``element_frequency_function`` takes."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class FrequencyArguments:
        sheet: sheet_struct(real, lane_count, cell, traits)
        bounds: step_bounds_struct(real)
        motion: wp.array(dtype=real)
        cell_unknowns: wp.array2d(dtype=lanes)
        inertia: wp.array2d(dtype=lanes)
        clock: wp.array(dtype=wp.float64)
        squared_frequency: wp.array(dtype=lanes)

    return FrequencyArguments


@cache
def record_arguments(real: type, lane_count: int):
    """What ``element_extremes_function`` and ``fold_works_function`` take."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class RecordArguments:
        elements: element_struct(real, lane_count)
        motion: wp.array(dtype=real)
        extremes: wp.array2d(dtype=lanes)
        works: wp.array2d(dtype=lanes)
        sums: wp.array2d(dtype=wp.float64)

    return RecordArguments


@wp.struct
class ToolArguments:
    """What ``move_tool`` takes, and the force of the sheets on each tool."""

    drives: ToolDrives
    clock: wp.array(dtype=wp.float64)
    displacement: wp.array(dtype=wp.float64)
    velocity: wp.array(dtype=wp.float64)
    force: wp.array(dtype=wp.vec3d)
    kept: wp.array2d(dtype=wp.float64)
    books: ToolBooks


@cache
def grip_arguments(real: type):
    """What ``grip_function`` takes."""

    @wp.struct
    class GripArguments:
        grips: Grips
        motion: wp.array(dtype=real)
        clock: wp.array(dtype=wp.float64)
        corner_force: wp.array(dtype=real)
        kept: wp.array2d(dtype=wp.float64)

    return GripArguments


@cache
def drive_arguments(real: type):
    """What ``support_motion_function`` takes."""

    @wp.struct
    class DriveArguments:
        first_piece: wp.array(dtype=wp.int32)
        start: wp.array(dtype=wp.float64)
        piece: wp.array(dtype=wp.vec4d)
        clock: wp.array(dtype=wp.float64)
        displacement: wp.array(dtype=wp.float64)
        increment: wp.array(dtype=real)

    return DriveArguments
