"""Advance one block of nodes by a step: translation, supports, directors (docs/theory.md, section 7)."""

from functools import cache
from typing import Any

import warp as wp

from ..contact.penalty import touch_struct
from ..lane_types import lane_types
from ..lanes import cross, dot, fill, in_every_lane, lane_maximum, load, scale, store, store_rows3, where_positive
from ..machine import following
from ..operators import add, div, mul, sub  # noqa: F401
from ..records import store_record4
from ..rows import MOTION_RECORD_LENGTH, MotionRow, MovedRow
from .node_data import node_laws_struct, present_struct, support_struct


@wp.func
def freedom_mask(freedom: Any, first_bit: int, like: Any):
    """1 for a free component, 0 for a fixed one."""
    result = type(like)()
    for i in range(len(freedom)):
        for c in range(3):
            result[c, i] = like.dtype((freedom[i] >> (first_bit + c)) & 1)
    return result


@wp.func
def exact_sum(a: Any, b: Any):
    """The rounded sum, and what rounding cut off it (Knuth), for values of any size."""
    total = a + b
    part = total - a
    return total, (a - (total - part)) + (b - part)


@cache
def translate_function(real: type, lane_count: int, loaded: bool):
    """wp.func -> (acceleration, mask of free components, new velocity and its remainder), without supports."""
    lanes3 = lane_types(real, lane_count).lanes3
    Present, NodeLaws = present_struct(real, lane_count), node_laws_struct(real)

    @wp.func
    def translate(
        present: Present,
        laws: NodeLaws,
        force: lanes3,
        applied_force: lanes3,
    ):
        pushed = scale(present.inverse_mass, force)
        steady = in_every_lane(force, laws.gravity)
        if wp.static(loaded):
            steady = steady + scale(present.inverse_mass, applied_force)
        free = freedom_mask(present.freedom, 0, lanes3())
        decay = real(0.5) * laws.damping * present.mean_step
        share = real(1.0) / (real(1.0) + decay)
        # compensated, as the positions: an increment is often less than the spacing of numbers beside the velocity.
        # Weight, loads and damping in turn are often less than that beside the forces of a vibrating sheet
        small = (share * present.mean_step) * steady - (real(2.0) * decay * share) * present.velocity
        large = mul(free, (share * present.mean_step) * pushed)
        whole, cut = exact_sum(mul(free, small) + present.velocity_remainder, large)
        velocity = present.velocity + whole
        return pushed + steady, free, velocity, (whole - (velocity - present.velocity)) + cut

    return translate


@cache
def follow_supports_function(real: type, lane_count: int):
    """wp.func -> (travel in the step, new velocity), where supports prescribe them."""
    lanes3 = lane_types(real, lane_count).lanes3
    Present, Supports = present_struct(real, lane_count), support_struct(real, lane_count)

    @wp.func
    def follow_supports(present: Present, supports: Supports, travel: lanes3, velocity: lanes3):
        follows = freedom_mask(supports.held[present.block], 0, lanes3())
        driven = lanes3()
        k = wp.int32(0)
        while k < supports.increment.shape[0]:
            driven = driven + supports.increment[k] * load(supports.direction[k], present.block * lane_count, lanes3())
            k = following(k)
        # the travel itself is prescribed, so that rounding of velocities does not accumulate
        return (
            travel + mul(follows, driven - travel),
            velocity + mul(follows, driven / present.step - velocity),
        )

    return follow_supports


@cache
def support_work_function(real: type, lane_count: int, supported: bool):
    """wp.func -> work of the constraints on the nodes [J]; writes the forces of the supports."""
    lanes3 = lane_types(real, lane_count).lanes3
    Present, Supports = present_struct(real, lane_count), support_struct(real, lane_count)

    @wp.func
    def support_work(present: Present, acceleration: lanes3, gained: lanes3, held: lanes3, supports: Supports):
        # a support balances the whole force on its node, and accelerates the nodal mass
        work = -present.mean_step * present.mass * dot(acceleration, held)
        if wp.static(supported):
            work = work + present.mass * dot(gained, held)
            needed = scale(present.mass, gained / present.mean_step - acceleration)
            follows = freedom_mask(supports.held[present.block], 0, lanes3())
            store(supports.holding, present.block * lane_count, mul(follows, needed))
        return work

    return support_work


@cache
def place_function(real: type, lane_count: int, has_tools: bool):
    """wp.func that moves the nodes by ``travel``, and reduces the gaps to all tools by the same distance.

    The remainder of the velocity lies behind the vectors: along x and z it is stored here, along y with the director.
    """
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    Present, Touch = present_struct(real, lane_count), touch_struct(real, lane_count)

    @wp.func
    def place(
        present: Present,
        tool_count: wp.int32,
        travel: lanes3,
        velocity: lanes3,
        velocity_remainder: lanes3,
        motion: wp.array2d(dtype=lanes),
        touch: Touch,
    ):
        block = present.block
        if wp.static(has_tools):
            # a margin for the rounding of this sum
            moved = wp.sqrt(lane_maximum(dot(travel, travel)))
            for k in range(tool_count):
                touch.gap[k, block] = real(0.999999) * touch.gap[k, block] - moved
        store_record4(motion, MOTION_RECORD_LENGTH, MotionRow.velocity, block, velocity, velocity_remainder[2])
        # compensated sum: small increments are not lost in large coordinates
        whole = travel + present.remainder
        position = present.position + whole
        cut = whole - (position - present.position)
        store_record4(motion, MOTION_RECORD_LENGTH, MotionRow.remainder, block, cut, velocity_remainder[0])
        store_record4(motion, MOTION_RECORD_LENGTH, MotionRow.position, block, position, present.mean_angle)

    return place


@cache
def note_motion_function(real: type, lane_count: int):
    """wp.func that notes how far the nodes of a block moved, for the samples between them."""
    lanes3, Touch = lane_types(real, lane_count).lanes3, touch_struct(real, lane_count)

    @wp.func
    def note_motion(block: wp.int32, travel: lanes3, turned: lanes3, touch: Touch):
        touch.moved[MovedRow.travel, block] = wp.sqrt(lane_maximum(dot(travel, travel)))
        touch.moved[MovedRow.turn, block] = wp.sqrt(lane_maximum(dot(turned, turned)))

    return note_motion


@cache
def turn_function(real: type, lane_count: int):
    """wp.func -> (sum of old and new spin, energy lost in the damping of spins [J])."""
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    Present, NodeLaws = present_struct(real, lane_count), node_laws_struct(real)

    @wp.func
    def turn(present: Present, laws: NodeLaws, couple: lanes3, beside: lanes, motion: wp.array2d(dtype=lanes)):
        """I domega/dt = d x (-dpsi/dd), then a Cayley rotation, which keeps the director's length.

        ``beside`` is stored behind the director.
        """
        block = present.block
        director = present.director
        spin = present.spin
        free = freedom_mask(present.freedom, 3, lanes3())
        inverse_inertia = present.inverse_inertia
        turning = mul(free, scale(inverse_inertia, cross(director, couple)))
        decay = real(0.5) * laws.director_damping * present.mean_step
        # increments, not factors near one, which would be lost beside that
        new_spin = spin + (real(1.0) / (real(1.0) + decay)) * (present.mean_step * turning - (real(2.0) * decay) * spin)
        spin_sum = spin + new_spin
        inertia = where_positive(inverse_inertia, fill(inverse_inertia, 1.0) / inverse_inertia, lanes())
        loss = (real(0.5) * decay) * inertia * dot(spin_sum, spin_sum)
        angle = present.step * new_spin
        half = real(0.5) * dot(angle, angle)
        one = fill(half, 1.0)
        change = scale(one / (one + real(0.5) * half), cross(angle, director) - scale(half, director))
        store_rows3(motion, MotionRow.spin, block, new_spin)
        store_record4(motion, MOTION_RECORD_LENGTH, MotionRow.director, block, director + change, beside)
        return spin_sum, loss

    return turn
