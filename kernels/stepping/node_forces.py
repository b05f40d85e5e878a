"""Forces of the elements and the prescribed loads on one block of nodes."""

from functools import cache

import warp as wp

from ..contact.penalty import touch_struct
from ..lane_types import GPU_LANE_COUNT, lane_types
from ..lanes import cross, lane_maximum, load, where_positive
from ..machine import following
from ..operators import add, div, mul, sub  # noqa: F401
from ..records import SCALAR, gather4, vector_of
from ..rows import ClockEntry, CornerRow, LoadRow, ThicknessRow
from .node_data import node_laws_struct, node_struct, present_struct

# Elements around a node of a regular mesh; the table of corners has at least as many slots.
USUAL_CORNER_COUNT = 4


@wp.func
def load_share(knot_time: wp.array(dtype=wp.float64), knot_share: wp.array(dtype=wp.float64), time: wp.float64):
    """Load factor, piecewise linear in time and constant beyond its ends."""
    result = knot_share[0]
    k = wp.int32(1)
    while k < knot_time.shape[0]:
        if time > knot_time[k - 1]:
            part = wp.min((time - knot_time[k - 1]) / (knot_time[k] - knot_time[k - 1]), wp.float64(1.0))
            result = knot_share[k - 1] + part * (knot_share[k] - knot_share[k - 1])
        k = following(k)
    return result


@cache
def gather_corners_function(real: type, lane_count: int):
    """wp.func -> (force, couple, sum of adjacent shear angles, and of thicknesses, of use if contact uses them)."""
    lanes4, Nodes = lane_types(real, lane_count).lanes4, node_struct(real, lane_count)

    # with one lane these corners are written out, so that a GPU reads all of them at once
    written_out = USUAL_CORNER_COUNT if lane_count == GPU_LANE_COUNT else 0

    @wp.func
    def add_corner(
        nodes: Nodes, slot: wp.int32, block: wp.int32, corners: wp.array(dtype=real), force: lanes4, couple: lanes4
    ):
        offset = nodes.corner_offset[slot, block]
        stride = nodes.corner_stride
        force = force + gather4(corners, offset, CornerRow.force * stride, stride)
        couple = couple + gather4(corners, offset, CornerRow.couple * stride, stride)
        return force, couple

    @wp.func
    def gather_corners(block: wp.int32, nodes: Nodes, corners: wp.array(dtype=real)):
        force = lanes4()
        couple = lanes4()
        for slot in range(wp.static(written_out)):
            force, couple = add_corner(nodes, slot, block, corners, force, couple)
        for slot in range(wp.static(written_out), nodes.corner_offset.shape[0]):
            force, couple = add_corner(nodes, slot, block, corners, force, couple)
        return vector_of(force), vector_of(couple), couple[SCALAR], force[SCALAR]

    return gather_corners


@cache
def follow_angle_function(real: type, lane_count: int):
    """wp.func -> (new mean shear angle, energy that its change removes from the motion [J])."""
    lanes = lane_types(real, lane_count).lanes
    Nodes, NodeLaws, Present = node_struct(real, lane_count), node_laws_struct(real), present_struct(real, lane_count)

    @wp.func
    def follow_angle(present: Present, nodes: Nodes, laws: NodeLaws, angle: lanes):
        # the elements used the mean from one step before: that resists its change, which is booked as damping
        weight = nodes.angle_weight[present.block]
        mean_angle = weight * angle
        late = mean_angle - present.mean_angle
        return mean_angle, where_positive(weight, laws.in_plane_bending_stiffness * late * late / weight, lanes())

    return follow_angle


@cache
def follow_thickness_function(real: type, lane_count: int):
    """wp.func -> ``present`` with the sheet's current thickness, from the sum over its elements; both are written."""
    lanes = lane_types(real, lane_count).lanes
    Nodes, Present = node_struct(real, lane_count), present_struct(real, lane_count)
    Touch = touch_struct(real, lane_count)

    @wp.func
    def follow_thickness(present: Present, nodes: Nodes, thickness: lanes, touch: Touch):
        block = present.block
        present.half_thickness = (real(0.5) * nodes.thickness_weight[block]) * thickness
        # work of the current springs from half a step ago to half a step ahead; the latter half is extrapolated
        last = present.half_thickness - touch.thickness[ThicknessRow.half, block]
        present.growth = real(1.5) * last - real(0.5) * touch.thickness[ThicknessRow.growth, block]
        present.thickened = wp.max(lane_maximum(last), real(0.0))
        touch.thickness[ThicknessRow.half, block] = present.half_thickness
        touch.thickness[ThicknessRow.growth, block] = last
        return present

    return follow_thickness


@cache
def apply_loads_function(real: type, lane_count: int):
    """wp.func -> (couple with the prescribed one, prescribed force, prescribed couple) at this time."""
    lanes3 = lane_types(real, lane_count).lanes3
    Nodes, Present = node_struct(real, lane_count), present_struct(real, lane_count)

    @wp.func
    def apply_loads(present: Present, nodes: Nodes, clock: wp.array(dtype=wp.float64), couple: lanes3):
        first = present.block * lane_count
        share = real(load_share(nodes.load_time, nodes.load_share, clock[ClockEntry.time]))
        applied_force = share * load(nodes.load[LoadRow.force], first, lanes3())
        applied_couple = share * load(nodes.load[LoadRow.couple], first, lanes3())
        # a moment M acts on the director as the conjugate M x d, without its component along d
        return couple + cross(applied_couple, present.director), applied_force, applied_couple

    return apply_loads
