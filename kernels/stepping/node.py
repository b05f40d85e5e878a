"""Nodes: gather the forces of the elements, contact with tools, time integration (docs/theory.md, 6 and 7)."""

from functools import cache
from typing import Any

import warp as wp

from ..contact.penalty import touch_struct
from ..fetching import expect_next
from ..lane_types import GPU_LANE_COUNT, lane_types, step_options
from ..lanes import dot, from_rows, rows3
from ..operators import add, div, mul, sub  # noqa: F401
from ..records import SCALAR, record4, vector_of
from ..rows import MOTION_RECORD_LENGTH, ClockEntry, MotionRow, NodeWorkRow
from .carried_contact import meeting_function
from .node_advance import (
    follow_supports_function,
    note_motion_function,
    place_function,
    support_work_function,
    translate_function,
    turn_function,
)
from .node_data import NodeTraits, node_laws_struct, node_struct, present_struct, surroundings_struct
from .node_forces import (
    USUAL_CORNER_COUNT,
    apply_loads_function,
    follow_angle_function,
    follow_thickness_function,
    gather_corners_function,
)


@wp.func
def expect_next_nodes(block: int, nodes: Any, motion: Any, works: Any):
    """Start to fetch what the next block reads beyond what elements have just read: that is in the cache.

    Counts are constants: loops over as many rows as there are made a step of 99,856 elements 6 % slower.
    """
    if nodes.looks_ahead == 1:
        expect_next(nodes.corner_offset, 0, wp.static(USUAL_CORNER_COUNT), block)
        expect_next(nodes.mass, block)
        expect_next(nodes.inverse_mass, block)
        expect_next(nodes.inverse_inertia, block)
        expect_next(nodes.angle_weight, block)
        expect_next(nodes.freedom, block)
        expect_next(motion, MOTION_RECORD_LENGTH, wp.static(MotionRow.row_count() - MOTION_RECORD_LENGTH), block)
        expect_next(works, 0, wp.static(int(NodeWorkRow.load_work)), block)


@cache
def node_motion_function(real: type, lane_count: int, traits: NodeTraits):
    """Function for one block of nodes: forces, contact, new velocities, positions and directors."""
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    Nodes, NodeLaws = node_struct(real, lane_count), node_laws_struct(real)
    Surroundings, Touch = surroundings_struct(real, lane_count), touch_struct(real, lane_count)
    Present = present_struct(real, lane_count)
    has_tools = len(traits.shape_kinds) > 0
    gather_corners = gather_corners_function(real, lane_count)
    follow_angle, follow_thickness = (
        follow_angle_function(real, lane_count),
        follow_thickness_function(real, lane_count),
    )
    apply_loads, meet_tools = apply_loads_function(real, lane_count), meeting_function(real, lane_count, traits)
    translate, turn = translate_function(real, lane_count, traits.loaded), turn_function(real, lane_count)
    follow_supports = follow_supports_function(real, lane_count)
    support_work = support_work_function(real, lane_count, traits.supported)
    place, note_motion = place_function(real, lane_count, has_tools), note_motion_function(real, lane_count)

    @wp.func
    def present_block(
        block: wp.int32,
        nodes: Nodes,
        laws: NodeLaws,
        clock: wp.array(dtype=wp.float64),
        motion: wp.array2d(dtype=lanes),
        works: wp.array2d(dtype=lanes),
    ):
        if wp.static(lane_count > GPU_LANE_COUNT):
            expect_next_nodes(block, nodes, motion, works)
        present = Present()
        present.block = block
        present.step = real(clock[ClockEntry.step])
        present.mean_step = real(clock[ClockEntry.mean_step])
        place = record4(motion, MOTION_RECORD_LENGTH, MotionRow.position, block)
        present.position = vector_of(place)
        present.mean_angle = place[SCALAR]
        rest = record4(motion, MOTION_RECORD_LENGTH, MotionRow.remainder, block)
        director = record4(motion, MOTION_RECORD_LENGTH, MotionRow.director, block)
        velocity = record4(motion, MOTION_RECORD_LENGTH, MotionRow.velocity, block)
        present.remainder = vector_of(rest)
        present.velocity = vector_of(velocity)
        present.velocity_remainder = from_rows(rest[SCALAR], director[SCALAR], velocity[SCALAR])
        present.director = vector_of(director)
        present.spin = rows3(motion, MotionRow.spin, block)
        present.mass = nodes.mass[block]
        present.inverse_mass = nodes.inverse_mass[block]
        present.inverse_inertia = nodes.inverse_inertia[block]
        present.freedom = nodes.freedom[block]
        present.friction_work = works[NodeWorkRow.friction_work, block]
        present.damping_loss = works[NodeWorkRow.damping_loss, block]
        present.support_work = works[NodeWorkRow.support_work, block]
        present.half_thickness = lanes(laws.half_thickness)
        return present

    @wp.func
    def move_block(
        # In
        block: wp.int32,
        nodes: Nodes,
        laws: NodeLaws,
        around: Surroundings,
        corners: wp.array(dtype=real),
        # Out
        motion: wp.array2d(dtype=lanes),  # rows: see MotionRow
        touch: Touch,
        works: wp.array2d(dtype=lanes),  # rows: see NodeWorkRow
    ):
        present = present_block(block, nodes, laws, around.clock, motion, works)
        force, couple, angle, thickness = gather_corners(block, nodes, corners)
        if wp.static(traits.touched):
            force = force + rows3(around.ply_force, 0, block)
        mean_angle, lost = follow_angle(present, nodes, laws, angle)
        present.mean_angle = mean_angle
        if wp.static(traits.follows_thickness):
            present = follow_thickness(present, nodes, thickness, touch)
        applied_force = lanes3()
        applied_couple = lanes3()
        if wp.static(traits.loaded):
            couple, applied_force, applied_couple = apply_loads(present, nodes, around.clock, couple)
        friction = lanes3()
        friction_power = lanes()
        dashpots = lanes3()
        dashpot_power = lanes()
        if wp.static(has_tools):
            force, friction, friction_power, dashpots, dashpot_power = meet_tools(
                present, laws, around.tools, force, touch, works
            )
        acceleration, free, velocity, cut = translate(present, laws, force, applied_force)
        travel = present.step * velocity
        if wp.static(traits.supported):
            travel, velocity = follow_supports(present, around.supports, travel, velocity)
        place(present, laws.tool_count, travel, velocity, cut, motion, touch)
        spin_sum, spin_loss = turn(present, laws, couple, cut[1], motion)
        if wp.static(traits.sampled):
            note_motion(block, travel, present.step * (spin_sum - present.spin), touch)
        middle = real(0.5) * (present.velocity + velocity)
        moving = mul(free, middle)
        worked = support_work(present, acceleration, velocity - present.velocity, middle - moving, around.supports)
        damped = dashpot_power - dot(dashpots, middle) + laws.damping * present.mass * dot(moving, moving)
        rubbed = present.mean_step * (friction_power - dot(friction, middle))
        works[NodeWorkRow.friction_work, block] = present.friction_work + rubbed
        works[NodeWorkRow.damping_loss, block] = present.damping_loss + (lost + present.mean_step * damped + spin_loss)
        works[NodeWorkRow.support_work, block] = present.support_work + worked
        if wp.static(traits.loaded):
            power = dot(applied_force, middle) + real(0.5) * dot(applied_couple, spin_sum)
            works[NodeWorkRow.load_work, block] = works[NodeWorkRow.load_work, block] + present.mean_step * power

    return move_block


@cache
def node_motion_kernel(real: type, lane_count: int, traits: NodeTraits):
    """Kernel, launched once per step: all of that for every block."""
    layout, lanes = (real, lane_count), lane_types(real, lane_count).lanes
    Nodes, NodeLaws = node_struct(*layout), node_laws_struct(real)
    Surroundings, Touch = surroundings_struct(*layout), touch_struct(*layout)
    move_block = node_motion_function(real, lane_count, traits)

    @wp.kernel(module="unique", enable_backward=False, module_options=step_options(real, inlined=True))
    def node_motion(
        # In
        first_block: wp.int32,
        nodes: Nodes,
        laws: NodeLaws,
        around: Surroundings,
        corners: wp.array(dtype=real),
        # Out
        motion: wp.array2d(dtype=lanes),
        touch: Touch,
        works: wp.array2d(dtype=lanes),
    ):
        move_block(first_block + wp.tid(), nodes, laws, around, corners, motion, touch, works)

    return node_motion
