"""Nodes: gather the forces of the elements, meet the tools, advance in time (docs/theory.md, 6 and 7)."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

from ..contact.penalty import friction_spring, normal_force, touch_struct
from ..contact.tool_distance import tool_distance_function, tool_set_struct
from ..lanes import (
    cross,
    dot,
    fill,
    gather,
    lane_maximum,
    lane_sum,
    lane_types,
    load,
    pick,
    rows3,
    scale,
    store,
    store_rows3,
    where_positive,
)
from ..operators import div, mul  # noqa: F401
from ..rows import ClockEntry, CornerRow, LoadRow, MotionRow, NodeReportRow


@dataclass(frozen=True)
class NodeTraits:
    """What acts on the nodes of a run: their kernel is made for it, as those of the sheet are for ``SheetTraits``.

    Attributes:
        follows_thickness: tools meet the current thickness.
        loaded: forces or couples are prescribed.
        supported: nodes are held by supports.
        shape_kinds: of the parts of all tools, see kernels/contact/tool_shapes.py; none without tools.
        rotated: some part is.
    """

    follows_thickness: bool = False
    loaded: bool = False
    supported: bool = False
    shape_kinds: tuple[str, ...] = ()
    rotated: bool = False


@cache
def node_struct(real: type, lane_count: int):
    """Constant node data; arrays are [block of lanes] or [row, block]."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Nodes:
        corner_offset: wp.array2d(
            dtype=types.indices
        )  # slot rows: first entry of an adjacent corner in the flat corner array
        corner_stride: wp.int32  # entries between two components
        mass: wp.array(dtype=types.lanes)  # [kg]; 0 for padding
        inverse_mass: wp.array(dtype=types.lanes)
        inverse_inertia: wp.array(dtype=types.lanes)  # scaled rotary inertia [1/(kg m^2)]
        angle_weight: wp.array(dtype=types.lanes)  # of each adjacent element in the node's mean shear angle
        thickness_weight: wp.array(dtype=types.lanes)  # of each in its mean thickness, if tools meet that
        load: wp.array2d(dtype=types.vec3)  # rows: see LoadRow
        load_time: wp.array(dtype=wp.float64)  # knots of the loads' share [s]
        load_share: wp.array(dtype=wp.float64)
        freedom: wp.array(dtype=types.indices)  # bits 0-2: x, y, z may move; bits 3-5: director may turn about x, y, z

    return Nodes


@cache
def support_struct(real: type, lane_count: int):
    """Nodes that are held and perhaps driven; what does not change but ``increment`` and ``holding``."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Supports:
        held: wp.array(dtype=types.indices)  # bits 0-2: x, y, z of the node follow the drives
        direction: wp.array2d(dtype=types.vec3)  # [drive, node]: displacement of the node over that of the drive
        increment: wp.array(dtype=real)  # of each drive in this step [m]
        holding: wp.array(dtype=types.vec3)  # written: force of a support on its node [N]

    return Supports


@cache
def motion_struct(real: type):
    """Constants of the time integration and contact."""

    @wp.struct
    class MotionLaws:
        gravity: wp.types.vector(3, real)  # [m/s^2]
        damping: real  # mass-proportional [1/s]
        director_damping: real  # [1/s]
        half_thickness: real  # [m]
        contact_stiffness: real  # of a node over its mass [1/s^2]
        contact_damping_time: real  # normal dashpot = contact stiffness times this [s]
        tangential_ratio: real  # friction spring over normal spring
        in_plane_bending_stiffness: real  # of the sheet [N m]
        spare_way: real  # kept of the way before a contact, for the rounding of positions and distances [m]
        tool_count: wp.int32

    return MotionLaws


@wp.func
def gather_corners(corners: Any, offset: Any, stride: int, row: int, total: Any):
    """Add the three components of one adjacent corner to ``total``."""
    return total + gather(corners, offset, row * stride, stride)


@wp.func
def add_scalar(corners: Any, offset: Any, first_row: int, total: Any):
    """Add the scalar of one adjacent element to ``total``; ``first_row`` is the flat start of its row."""
    return total + pick(corners, offset, first_row)


@wp.func
def freedom_mask(freedom: Any, first_bit: int, like: Any):
    """1 for a free component, 0 for a fixed one."""
    result = type(like)()
    for i in range(len(freedom)):
        for c in range(3):
            result[c, i] = like.dtype((freedom[i] >> (first_bit + c)) & 1)
    return result


@wp.func
def load_share(knot_time: wp.array(dtype=wp.float64), knot_share: wp.array(dtype=wp.float64), time: wp.float64):
    """Share of the nodal loads, piecewise linear in time and constant beyond its ends."""
    result = knot_share[0]
    for k in range(1, knot_time.shape[0]):
        if time > knot_time[k - 1]:
            part = wp.min((time - knot_time[k - 1]) / (knot_time[k] - knot_time[k - 1]), wp.float64(1.0))
            result = knot_share[k - 1] + part * (knot_share[k] - knot_share[k - 1])
    return result


@cache
def node_motion_kernel(real: type, lane_count: int, traits: NodeTraits):
    """Kernel of one launch per step: forces, contact, new velocities, positions and directors."""
    types = lane_types(real, lane_count)
    lanes, lanes3, vec3 = types.lanes, types.lanes3, types.vec3
    Nodes, MotionLaws, Tools = node_struct(real, lane_count), motion_struct(real), tool_set_struct(real)
    Supports, Touch = support_struct(real, lane_count), touch_struct(real, lane_count)
    tool_distance = tool_distance_function(real, lane_count, traits.shape_kinds, traits.rotated)
    follows_thickness, loaded, supported = traits.follows_thickness, traits.loaded, traits.supported
    has_tools = len(traits.shape_kinds) > 0

    @wp.kernel(module="unique", enable_backward=False)
    def node_motion(
        # In
        first_block: wp.int32,
        nodes: Nodes,
        laws: MotionLaws,
        tools: Tools,
        supports: Supports,
        clock: wp.array(dtype=wp.float64),
        corners: wp.array(dtype=real),
        # Out
        motion: wp.array2d(dtype=lanes),  # rows: see MotionRow
        touch: Touch,
        report: wp.array2d(dtype=lanes),  # rows: see NodeReportRow
    ):
        block = first_block + wp.tid()
        first = block * lane_count
        step = real(clock[ClockEntry.step])
        mean_step = real(clock[ClockEntry.mean_step])
        x = rows3(motion, MotionRow.position, block)
        velocity = rows3(motion, MotionRow.velocity, block)

        force = lanes3()
        couple = lanes3()
        angle = lanes()
        thickness = lanes()
        for slot in range(nodes.corner_offset.shape[0]):
            offset = nodes.corner_offset[slot, block]
            force = gather_corners(corners, offset, nodes.corner_stride, CornerRow.force, force)
            couple = gather_corners(corners, offset, nodes.corner_stride, CornerRow.couple, couple)
            angle = add_scalar(corners, offset, CornerRow.angle * nodes.corner_stride, angle)
            if wp.static(follows_thickness):
                thickness = add_scalar(corners, offset, CornerRow.thickness * nodes.corner_stride, thickness)
        # the elements met the mean of one step before: that resists its change, which is booked as damping
        mean_angle = nodes.angle_weight[block] * angle
        late = mean_angle - motion[MotionRow.mean_angle, block]
        weight = nodes.angle_weight[block]
        damping_loss = where_positive(weight, laws.in_plane_bending_stiffness * late * late / weight, lanes())
        motion[MotionRow.mean_angle, block] = mean_angle

        half_thickness = lanes(laws.half_thickness)
        growth = lanes()
        thickened = real(0.0)
        if wp.static(follows_thickness):
            half_thickness = (real(0.5) * nodes.thickness_weight[block]) * thickness
            # work of the present springs from half a step ago to half a step ahead, whose part is extrapolated
            last = half_thickness - report[NodeReportRow.half_thickness, block]
            growth = real(1.5) * last - real(0.5) * report[NodeReportRow.half_thickness_growth, block]
            report[NodeReportRow.half_thickness, block] = half_thickness
            report[NodeReportRow.half_thickness_growth, block] = last
            thickened = wp.max(lane_maximum(last), real(0.0))

        # prescribed loads; a moment M turns the director as the conjugate M x d does, without its part along d
        director = rows3(motion, MotionRow.director, block)
        applied_force = lanes3()
        applied_couple = lanes3()
        if wp.static(loaded):
            share = real(load_share(nodes.load_time, nodes.load_share, clock[ClockEntry.time]))
            applied_force = share * load(nodes.load[LoadRow.force], first, lanes3())
            applied_couple = share * load(nodes.load[LoadRow.couple], first, lanes3())
            force = force + applied_force
            couple = couple + cross(applied_couple, director)

        # forces that do not come from an energy, and the power that the moving tools take from them
        friction_force = lanes3()
        friction_power = lanes()
        dashpot_force = lanes3()
        dashpot_power = lanes()
        stiffness = laws.contact_stiffness * nodes.mass[block]
        for k in range(laws.tool_count):
            tool = tools.tool[k]
            # the tool has moved for the last step, which is at most twice the mean one
            way_left = touch.gap[k, block] - real(2.0) * mean_step * wp.abs(real(tools.velocity[k])) - thickened
            if not way_left > real(0.0):
                distance, normal = tool_distance(tools.part, tool, real(tools.displacement[k]), x)
                penetration = half_thickness - distance
                deepest = lane_maximum(penetration)
                way_left = -deepest - laws.spare_way - tool.blind_distance
                held = lanes3()
                contact_force = lanes3()
                if not deepest <= real(0.0):
                    relative = velocity
                    tool_velocity = real(tools.velocity[k]) * tool.axis
                    for c in range(3):
                        relative[c] = relative[c] - lanes(tool_velocity[c])
                    leaving = dot(relative, normal)
                    spring, pressure = normal_force(penetration, -leaving, stiffness, laws.contact_damping_time)
                    if wp.static(follows_thickness):
                        report[NodeReportRow.thickness_work, block] = (
                            report[NodeReportRow.thickness_work, block] + spring * growth
                        )
                    dashpot = scale(pressure - spring, normal)
                    # friction: the spring follows the tangent plane and the sliding since the last step
                    stretched = rows3(touch.friction, 3 * k, block) + mean_step * relative
                    trial = stretched - scale(dot(stretched, normal), normal)
                    tangential = laws.tangential_ratio * stiffness
                    held = friction_spring(trial, tangential, tool.friction * pressure)
                    drag = -scale(tangential, held)
                    contact_force = scale(pressure, normal) + drag
                    force = force + contact_force
                    friction_force = friction_force + drag
                    dashpot_force = dashpot_force + dashpot
                    for c in range(3):
                        friction_power = friction_power + tool_velocity[c] * drag[c]
                        dashpot_power = dashpot_power + tool_velocity[c] * dashpot[c]
                store_rows3(touch.friction, 3 * k, block, held)
                touch.reaction[k, block] = vec3(
                    -lane_sum(contact_force[0]), -lane_sum(contact_force[1]), -lane_sum(contact_force[2])
                )
            touch.gap[k, block] = way_left

        # translation
        acceleration = scale(nodes.inverse_mass[block], force)
        for c in range(3):
            acceleration[c] = acceleration[c] + lanes(laws.gravity[c])
        freedom = nodes.freedom[block]
        free = freedom_mask(freedom, 0, lanes3())
        decay = real(0.5) * laws.damping * mean_step
        change = (real(1.0) / (real(1.0) + decay)) * (mean_step * acceleration - (real(2.0) * decay) * velocity)
        new_velocity = velocity + wp.cw_mul(free, change)
        way = step * new_velocity
        if wp.static(supported):
            follows = freedom_mask(supports.held[block], 0, lanes3())
            driven = lanes3()
            for k in range(supports.increment.shape[0]):
                driven = driven + supports.increment[k] * load(supports.direction[k], first, lanes3())
            # the way itself is prescribed, so that no rounding of a velocity adds up
            way = way + wp.cw_mul(follows, driven - way)
            new_velocity = new_velocity + wp.cw_mul(follows, driven / step - new_velocity)
        middle = real(0.5) * (velocity + new_velocity)
        friction_work = mean_step * (friction_power - dot(friction_force, middle))
        moving = wp.cw_mul(free, middle)
        # what holds a node takes up all the force on it, and accelerates its mass
        held = middle - moving
        support_work = -mean_step * nodes.mass[block] * dot(acceleration, held)
        if wp.static(supported):
            gained = new_velocity - velocity
            support_work = support_work + nodes.mass[block] * dot(gained, held)
            needed = scale(nodes.mass[block], gained / mean_step - acceleration)
            store(supports.holding, first, wp.cw_mul(freedom_mask(supports.held[block], 0, lanes3()), needed))
        report[NodeReportRow.support_work, block] = report[NodeReportRow.support_work, block] + support_work
        damping_loss = damping_loss + mean_step * (
            dashpot_power - dot(dashpot_force, middle) + laws.damping * nodes.mass[block] * dot(moving, moving)
        )
        if wp.static(has_tools):
            # a share for the rounding of this sum
            moved = wp.sqrt(lane_maximum(dot(way, way)))
            for k in range(laws.tool_count):
                touch.gap[k, block] = real(0.999999) * touch.gap[k, block] - moved
        store_rows3(motion, MotionRow.velocity, block, new_velocity)
        # compensated sum: nothing of a small step is lost beside a large coordinate
        way = way + rows3(motion, MotionRow.remainder, block)
        new_x = x + way
        store_rows3(motion, MotionRow.remainder, block, way - (new_x - x))
        store_rows3(motion, MotionRow.position, block, new_x)

        # rotation of the director: I domega/dt = d x (-dpsi/dd), then a Cayley rotation, which keeps its length
        spin = rows3(motion, MotionRow.spin, block)
        turning = wp.cw_mul(
            freedom_mask(freedom, 3, lanes3()), scale(nodes.inverse_inertia[block], cross(director, couple))
        )
        spin_decay = real(0.5) * laws.director_damping * mean_step
        new_spin = (real(1.0) / (real(1.0) + spin_decay)) * (mean_step * turning + (real(1.0) - spin_decay) * spin)
        spin_middle = spin + new_spin
        inverse_inertia = nodes.inverse_inertia[block]
        inertia = where_positive(inverse_inertia, fill(inverse_inertia, 1.0) / inverse_inertia, lanes())
        damping_loss = damping_loss + (real(0.5) * spin_decay) * inertia * dot(spin_middle, spin_middle)
        turn = step * new_spin
        quarter = real(0.25) * dot(turn, turn)
        one = fill(quarter, 1.0)
        new_director = scale(one / (one + quarter), scale(one - quarter, director) + cross(turn, director))
        store_rows3(motion, MotionRow.spin, block, new_spin)
        store_rows3(motion, MotionRow.director, block, new_director)

        report[NodeReportRow.friction_work, block] = report[NodeReportRow.friction_work, block] + friction_work
        if wp.static(loaded):
            report[NodeReportRow.load_work, block] = report[NodeReportRow.load_work, block] + mean_step * (
                dot(applied_force, middle) + real(0.5) * dot(applied_couple, spin_middle)
            )
        report[NodeReportRow.damping_loss, block] = report[NodeReportRow.damping_loss, block] + damping_loss

    return node_motion
