"""Contact of the tools with the sheet's surface between its nodes (docs/theory.md, section 6).

Launched after the element forces and before the nodes move: forces are added to what the elements wrote at their
corners.
"""

from functools import cache

import warp as wp

from ..carried.contact import meeting_function
from ..carried.pose import away_function, read_pose_function, surface_speed_functions
from ..contact.tool_distance import tool_set_struct
from ..lanes import dot, lane_maximum, lane_types, rows3, step_options, store_rows3
from ..operators import div, mul  # noqa: F401
from ..records import SCALAR, record4
from ..rows import (
    CORNER_ROW_COUNT,
    ClockEntry,
    CornerRow,
    MotionRow,
    MovedRow,
    NodeWorkRow,
    SampleRow,
    ThicknessRow,
)
from .node_data import NodeTraits, node_laws_struct, present_struct, surroundings_struct
from .sample_data import load_struct, patch_struct, point_struct, sampled_struct, samples_struct
from .surface_point import corner_function, load_functions, patch_function, point_function, weight_function

# Largest distance of a sample from the first corner of its element, over the initial size of the largest one.
FURTHEST_SAMPLE = wp.constant(2.0)
# A little more than one, against the rounding of sums.
_LESS = wp.constant(0.999999)


@cache
def watch_function(real: type, lane_count: int, carried: bool = False):
    """wp.func that reduces the gaps of a block's samples by what everything moved -> whether a contact is possible."""
    Samples, Sampled = samples_struct(real, lane_count), sampled_struct(real, lane_count)
    NodeLaws, Surroundings = node_laws_struct(real), surroundings_struct(real, lane_count)
    Tools, read_pose, away = tool_set_struct(real), read_pose_function(real), away_function(real, lane_count)
    _, _, largest_speed = surface_speed_functions(real, lane_count)
    corner = corner_function(real, lane_count)

    @wp.func
    def tool_speed(samples: Samples, block: wp.int32, tools: Tools, k: wp.int32, motion: wp.array(dtype=real)):
        """Largest speed of a tool at the samples, which are near the first corners of their elements."""
        speed = wp.abs(real(tools.velocity[k]))
        if wp.static(carried):
            pose = read_pose(tools, k)
            position = corner(samples, block, 0, motion, MotionRow.position)
            remainder = corner(samples, block, 0, motion, MotionRow.remainder)
            beside = real(FURTHEST_SAMPLE) * samples.lever * wp.length(pose.spin)
            speed = largest_speed(pose, away(pose.pivot, position, remainder)) + beside
        return speed

    @wp.func
    def way_of_samples(samples: Samples, block: wp.int32, moved: wp.array2d(dtype=real)):
        """Furthest way of a sample: its patch moves as its corners, its sagitta as they move and turn."""
        travel = real(0.0)
        turn = real(0.0)
        for slot in range(samples.node_block.shape[0]):
            of_nodes = samples.node_block[slot, block]
            travel = wp.max(travel, moved[MovedRow.travel, of_nodes])
            turn = wp.max(turn, moved[MovedRow.turn, of_nodes])
        return real(2.0) * travel + samples.lever * turn

    @wp.func
    def reduce_gaps(
        samples: Samples,
        block: wp.int32,
        laws: NodeLaws,
        around: Surroundings,
        moved: wp.array2d(dtype=real),
        motion: wp.array(dtype=real),
        thickened: real,
        sampled: Sampled,
    ):
        way = way_of_samples(samples, block, moved)
        tool_share = real(2.0) * real(around.clock[ClockEntry.mean_step])
        near = wp.int32(0)
        for k in range(laws.tool_count):
            tool_way = tool_share * tool_speed(samples, block, around.tools, k, motion)
            for j in range(samples.place.shape[0]):
                number = j * samples.block_count + block
                gap = real(_LESS) * sampled.touch.gap[k, number] - way
                if not gap - tool_way - thickened > real(0.0):
                    near = wp.int32(1)
                sampled.touch.gap[k, number] = gap
        if near == 0:
            # else done where the tools are met
            for k in range(laws.tool_count):
                tool_way = tool_share * tool_speed(samples, block, around.tools, k, motion)
                for j in range(samples.place.shape[0]):
                    number = j * samples.block_count + block
                    sampled.touch.gap[k, number] = sampled.touch.gap[k, number] - tool_way - thickened
        return near

    return reduce_gaps


@cache
def book_function(real: type, lane_count: int):
    """wp.func that books the works of a sample up to the instant of the positions.

    The velocity lies between the last instant and this one, so the work from there to here is the mean of the last and
    the present impulse times the velocity: sums of these agree with the kinetic energy of the ledger.
    """
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    Present, Sampled = present_struct(real, lane_count), sampled_struct(real, lane_count)

    @wp.func
    def lost(
        present: Present,
        memory: wp.array2d(dtype=lanes),
        row: wp.int32,
        power_row: wp.int32,
        force: lanes3,
        power: lanes,
    ):
        block = present.block
        half = real(0.5)
        impulse = present.mean_step * force
        supplied = present.mean_step * power
        work = half * (supplied + memory[power_row, block])
        work = work - half * dot(impulse + rows3(memory, row, block), present.velocity)
        store_rows3(memory, row, block, impulse)
        memory[power_row, block] = supplied
        return work

    @wp.func
    def book(
        present: Present,
        friction: lanes3,
        friction_power: lanes,
        dashpots: lanes3,
        dashpot_power: lanes,
        sampled: Sampled,
    ):
        block = present.block
        memory = sampled.memory
        works = sampled.works
        rubbed = lost(present, memory, SampleRow.friction, SampleRow.friction_power, friction, friction_power)
        damped = lost(present, memory, SampleRow.dashpots, SampleRow.dashpot_power, dashpots, dashpot_power)
        works[NodeWorkRow.friction_work, block] = works[NodeWorkRow.friction_work, block] + rubbed
        works[NodeWorkRow.damping_loss, block] = works[NodeWorkRow.damping_loss, block] + damped

    return book


@cache
def present_sample_function(real: type, lane_count: int, follows_thickness: bool):
    """Functions for ``Present`` of a block of elements, and of one of its samples."""
    types = lane_types(real, lane_count)
    lanes = types.lanes
    Samples, NodeLaws = samples_struct(real, lane_count), node_laws_struct(real)
    Present, Sampled = present_struct(real, lane_count), sampled_struct(real, lane_count)
    Patch, Point = patch_struct(real, lane_count), point_struct(real, lane_count)

    @wp.func
    def present_elements(
        block: wp.int32,
        samples: Samples,
        laws: NodeLaws,
        clock: wp.array(dtype=wp.float64),
        corner_force: wp.array2d(dtype=lanes),
        sampled: Sampled,
    ):
        present = Present()
        present.mean_step = real(clock[ClockEntry.mean_step])
        present.mass = samples.mass[block]
        present.half_thickness = lanes(laws.half_thickness)
        if wp.static(follows_thickness):
            # as at nodes: the work of the springs from half a step ago to half a step ahead
            thickness = sampled.touch.thickness
            half = real(0.5) * record4(corner_force, CORNER_ROW_COUNT, CornerRow.force, block)[SCALAR]
            last = half - thickness[ThicknessRow.half, block]
            present.half_thickness = half
            present.growth = real(1.5) * last - real(0.5) * thickness[ThicknessRow.growth, block]
            present.thickened = wp.max(lane_maximum(last), real(0.0))
            thickness[ThicknessRow.half, block] = half
            thickness[ThicknessRow.growth, block] = last
        return present

    @wp.func
    def present_sample(present: Present, number: wp.int32, patch: Patch, point: Point):
        present.block = number
        present.position = patch.origin
        present.remainder = patch.remainder + point.way
        present.velocity = point.velocity
        return present

    return present_elements, present_sample


@cache
def surface_contact_kernel(real: type, lane_count: int, traits: NodeTraits):
    """Kernel, launched once per step after ``element_forces``: contact at the samples between nodes."""
    types = lane_types(real, lane_count)
    lanes, lanes3, layout = types.lanes, types.lanes3, (real, lane_count)
    Samples, Sampled = samples_struct(*layout), sampled_struct(*layout)
    NodeLaws, Surroundings = node_laws_struct(real), surroundings_struct(*layout)
    read_patch, weight_at = patch_function(*layout), weight_function(real)
    surface_point, reduce_gaps = point_function(*layout), watch_function(*layout, traits.carried)
    present_elements, present_sample = present_sample_function(*layout, traits.follows_thickness)
    meet_tools, book = meeting_function(*layout, traits), book_function(*layout)
    Load, (add_load, store_load) = load_struct(*layout), load_functions(*layout)

    @wp.func
    def push_tools(samples: Samples, block: wp.int32, tool_count: wp.int32, sampled: Sampled):
        for k in range(tool_count):
            total = sampled.touch.reaction[k, block]
            for j in range(1, samples.place.shape[0]):
                total = total + sampled.touch.reaction[k, j * samples.block_count + block]
            sampled.reaction[k, block] = total
            if wp.static(traits.carried):
                moment = sampled.touch.moment[k, block]
                for j in range(1, samples.place.shape[0]):
                    moment = moment + sampled.touch.moment[k, j * samples.block_count + block]
                sampled.moment[k, block] = moment

    @wp.kernel(module="unique", enable_backward=False, module_options=step_options(real, inlined=True))
    def surface_contact(
        # In
        first_block: wp.int32,
        samples: Samples,
        laws: NodeLaws,
        around: Surroundings,
        moved: wp.array2d(dtype=real),  # of blocks of nodes, rows: see MovedRow
        motion: wp.array(dtype=real),
        # Out
        corner_force: wp.array2d(dtype=lanes),  # rows: see CornerRow
        sampled: Sampled,
    ):
        block = first_block + wp.tid()
        present = present_elements(block, samples, laws, around.clock, corner_force, sampled)
        if reduce_gaps(samples, block, laws, around, moved, motion, present.thickened, sampled) != 0:
            patch = read_patch(samples, block, motion)
            load = Load()
            for j in range(samples.place.shape[0]):
                weight = weight_at(samples.place[j])
                point = surface_point(patch, weight)
                sample = present_sample(present, j * samples.block_count + block, patch, point)
                force, friction, friction_power, dashpots, dashpot_power = meet_tools(
                    sample, laws, around.tools, lanes3(), sampled.touch, sampled.works
                )
                book(sample, friction, friction_power, dashpots, dashpot_power, sampled)
                if not lane_maximum(dot(force, force)) <= real(0.0):
                    load = add_load(load, point, weight, force, force - friction - dashpots)
            store_load(block, load, corner_force)
            push_tools(samples, block, laws.tool_count, sampled)

    return surface_contact
