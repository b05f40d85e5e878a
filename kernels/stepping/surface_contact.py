"""Contact of the tools with the sheet's surface between its nodes (docs/theory.md, section 6).

Launched after the element forces and before the nodes move: forces are added to what the elements wrote at their
corners.
"""

from functools import cache

import warp as wp

from ..contact.carried_pose import read_pose_function, surface_speed_functions
from ..contact.tool_distance import away_function, tool_set_struct
from ..lane_types import lane_types, step_options
from ..lanes import dot, lane_maximum, rows3, store_rows3
from ..operators import add, div, mul, sub  # noqa: F401
from ..records import SCALAR, gather4
from ..rows import (
    ClockEntry,
    CornerRow,
    MotionRow,
    MovedRow,
    NodeWorkRow,
    SampleRow,
    ThicknessRow,
)
from .carried_contact import meeting_function
from .node_data import NodeTraits, node_laws_struct, present_struct, surroundings_struct
from .sample_data import layer_struct, load_struct, patch_struct, point_struct, sampled_struct, samples_struct
from .surface_point import corner_function, load_functions, patch_function, point_function

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
    def is_near(
        samples: Samples,
        block: wp.int32,
        laws: NodeLaws,
        around: Surroundings,
        moved: wp.array2d(dtype=real),
        motion: wp.array(dtype=real),
        thickened: real,
        sampled: Sampled,
    ):
        """Whether a sample of the block may touch a tool; its smallest gap to each is reduced by what all moved."""
        way = way_of_samples(samples, block, moved) + thickened
        tool_share = real(2.0) * real(around.clock[ClockEntry.mean_step])
        smallest = samples.place.shape[0] * samples.block_count + block
        near = wp.int32(0)
        for k in range(laws.tool_count):
            tool_way = tool_share * tool_speed(samples, block, around.tools, k, motion)
            left = real(_LESS) * sampled.touch.gap[k, smallest] - (way + tool_way)
            if not left > real(0.0):
                near = wp.int32(1)
            sampled.touch.gap[k, smallest] = left
        return near

    @wp.func
    def wake(
        samples: Samples,
        block: wp.int32,
        laws: NodeLaws,
        around: Surroundings,
        motion: wp.array(dtype=real),
        thickened: real,
        sampled: Sampled,
    ):
        """Bits of the samples that may touch a tool; all gaps are reduced by what everything moved since the last."""
        tool_share = real(2.0) * real(around.clock[ClockEntry.mean_step])
        count = samples.place.shape[0]
        awake = wp.int32(0)
        for k in range(laws.tool_count):
            first = sampled.touch.gap[k, block]
            for j in range(1, count):
                first = wp.min(first, sampled.touch.gap[k, j * samples.block_count + block])
            moved = first - sampled.touch.gap[k, count * samples.block_count + block]
            if not first < wp.inf:
                moved = real(0.0)  # a tool that does not act
            for j in range(count):
                number = j * samples.block_count + block
                gap = real(_LESS) * sampled.touch.gap[k, number] - moved
                if not gap > real(0.0):
                    awake = awake | (1 << j)
                sampled.touch.gap[k, number] = gap
        for k in range(laws.tool_count):
            last_way = tool_share * tool_speed(samples, block, around.tools, k, motion) + thickened
            for j in range(count):
                if (awake >> j) & 1 != 0:
                    # subtracted where the tools are met
                    number = j * samples.block_count + block
                    sampled.touch.gap[k, number] = sampled.touch.gap[k, number] + last_way
        return awake

    @wp.func
    def touches(samples: Samples, number: wp.int32, laws: NodeLaws, sampled: Sampled):
        """Whether a sample was in a tool when it was looked at last."""
        result = wp.int32(0)
        for k in range(laws.tool_count):
            if not sampled.touch.gap[k, number] > -laws.spare_distance:
                result = wp.int32(1)
        return result

    @wp.func
    def note_smallest(samples: Samples, block: wp.int32, tool_count: wp.int32, sampled: Sampled):
        count = samples.place.shape[0]
        for k in range(tool_count):
            smallest = sampled.touch.gap[k, block]
            for j in range(1, count):
                smallest = wp.min(smallest, sampled.touch.gap[k, j * samples.block_count + block])
            sampled.touch.gap[k, count * samples.block_count + block] = smallest

    return is_near, wake, touches, note_smallest


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
    """Functions for the ``Layer`` of a block of elements, and for ``Present`` of one of its samples."""
    types = lane_types(real, lane_count)
    lanes = types.lanes
    Samples, NodeLaws = samples_struct(real, lane_count), node_laws_struct(real)
    Present, Sampled = present_struct(real, lane_count), sampled_struct(real, lane_count)
    Patch, Point = patch_struct(real, lane_count), point_struct(real, lane_count)
    Layer = layer_struct(real, lane_count)

    @wp.func
    def follow_thickness(
        block: wp.int32, samples: Samples, laws: NodeLaws, corner_force: wp.array(dtype=real), sampled: Sampled
    ):
        layer = Layer()
        half = lanes(laws.half_thickness)
        if wp.static(follows_thickness):
            # as at nodes: the work of the springs from half a step ago to half a step ahead
            thickness = sampled.touch.thickness
            stride = samples.corner_stride
            piece = gather4(corner_force, samples.element[block], CornerRow.force * stride, stride)
            half = real(0.5) * piece[SCALAR]
            last = half - thickness[ThicknessRow.half, block]
            layer.growth = real(1.5) * last - real(0.5) * thickness[ThicknessRow.growth, block]
            layer.thickened = wp.max(lane_maximum(last), real(0.0))
            thickness[ThicknessRow.half, block] = half
            thickness[ThicknessRow.growth, block] = last
        layer.half_thickness = half - lanes(samples.allowance)
        return layer

    @wp.func
    def present_sample(number: wp.int32, mean_step: real, mass: lanes, layer: Layer, patch: Patch, point: Point):
        present = Present()
        present.block = number
        present.mean_step = mean_step
        present.mass = mass
        present.half_thickness = layer.half_thickness
        present.growth = layer.growth
        present.thickened = layer.thickened
        present.position = patch.origin
        present.remainder = patch.remainder + point.way
        present.velocity = point.velocity
        return present

    return follow_thickness, present_sample


@cache
def surface_contact_function(real: type, lane_count: int, traits: NodeTraits):
    """wp.func (block of elements, ...) -> contact at its samples; see ``surface_contact_kernel``."""
    lanes3, layout = lane_types(real, lane_count).lanes3, (real, lane_count)
    Samples, Sampled, Layer = samples_struct(*layout), sampled_struct(*layout), layer_struct(*layout)
    NodeLaws, Surroundings = node_laws_struct(real), surroundings_struct(*layout)
    read_patch, surface_point = patch_function(*layout), point_function(*layout)
    is_near, wake, touches, note_smallest = watch_function(*layout, traits.carried)
    follow_thickness, present_sample = present_sample_function(*layout, traits.follows_thickness)
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

    @wp.func
    def meet(
        block: wp.int32,
        layer: Layer,
        samples: Samples,
        laws: NodeLaws,
        around: Surroundings,
        motion: wp.array(dtype=real),
        corner_force: wp.array(dtype=real),
        sampled: Sampled,
    ):
        """Apart, so that variables are set to zero in blocks that come here only."""
        count = samples.place.shape[0]
        touched = wp.int32(0)
        for j in range(count):
            touched = touched | (touches(samples, j * samples.block_count + block, laws, sampled) << j)
        awake = wake(samples, block, laws, around, motion, layer.thickened, sampled)
        patch = read_patch(samples, block, motion)
        mean_step = real(around.clock[ClockEntry.mean_step])
        load = Load()
        loaded = wp.int32(0)
        for j in range(count):
            if (awake >> j) & 1 != 0:
                number = j * samples.block_count + block
                u, v = real(samples.place[j][0]), real(samples.place[j][1])
                point = surface_point(patch, u, v)
                sample = present_sample(number, mean_step, samples.mass[block], layer, patch, point)
                force, friction, friction_power, dashpots, dashpot_power = meet_tools(
                    sample, laws, around.tools, lanes3(), sampled.touch, sampled.works
                )
                pushes = touches(samples, number, laws, sampled)
                if pushes | ((touched >> j) & 1) != 0:
                    book(sample, friction, friction_power, dashpots, dashpot_power, sampled)
                if pushes != 0:
                    load = add_load(load, point, u, v, force, force - friction - dashpots)
                    loaded = wp.int32(1)
        if loaded != 0:
            store_load(samples, block, load, corner_force)
        if loaded | touched != 0:
            push_tools(samples, block, laws.tool_count, sampled)
        note_smallest(samples, block, laws.tool_count, sampled)

    @wp.func
    def contact_of_block(
        block: wp.int32,
        samples: Samples,
        laws: NodeLaws,
        around: Surroundings,
        moved: wp.array2d(dtype=real),
        motion: wp.array(dtype=real),
        corner_force: wp.array(dtype=real),
        sampled: Sampled,
    ):
        layer = follow_thickness(block, samples, laws, corner_force, sampled)
        if is_near(samples, block, laws, around, moved, motion, layer.thickened, sampled) != 0:
            meet(block, layer, samples, laws, around, motion, corner_force, sampled)

    return contact_of_block


@cache
def surface_contact_kernel(real: type, lane_count: int, traits: NodeTraits):
    """Kernel, launched once per step after ``element_forces``: contact at the samples between nodes."""
    Samples, Sampled = samples_struct(real, lane_count), sampled_struct(real, lane_count)
    NodeLaws, Surroundings = node_laws_struct(real), surroundings_struct(real, lane_count)
    contact_of_block = surface_contact_function(real, lane_count, traits)

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
        corner_force: wp.array(dtype=real),  # flat, rows: see CornerRow
        sampled: Sampled,
    ):
        contact_of_block(first_block + wp.tid(), samples, laws, around, moved, motion, corner_force, sampled)

    return surface_contact
