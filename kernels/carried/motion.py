"""Motion of tools that are carried: along their axes, and along a path and about an axis by curves."""

from functools import cache

import warp as wp

from ..contact.carried_pose import store_vector, vector_entries
from ..rows import ClockEntry, ToolPoseRow, ToolWorkRow
from ..stepping.supports import piecewise_cubic
from ..stepping.tools import (
    ToolBooks,
    ToolDrives,
    book,
    move_tool_function,
    total_force,
    wait_for_block,
    watch_tool,
)

# Curves of a tool: x, y and z of its path, and its angle.
CURVE_COUNT = wp.constant(4)


@wp.struct
class Carrier:
    """What carries one tool: its pose without path and rotation, and about what it turns."""

    rotation: wp.mat33d
    shift: wp.vec3d  # at zero displacement [m]
    point: wp.vec3d  # of the axis, at zero displacement and at the begin of the path [m]
    axis: wp.vec3d  # unit direction of the rotation


@wp.struct
class Carriers:
    """What carries all tools; a tool without curves has pieces of zeros."""

    carrier: wp.array(dtype=Carrier)
    first_piece: wp.array(dtype=wp.int32)  # of each curve, and the number of all pieces
    start: wp.array(dtype=wp.float64)  # of each piece [s]
    piece: wp.array(dtype=wp.vec4d)  # c0 + c1 x + c2 x^2 + c3 x^3 [m] or [rad], x the time since its start


@wp.struct
class CarriedMotion:
    """Where all tools are; all of it is written."""

    displacement: wp.array(dtype=wp.float64)  # along each tool's axis [m]
    velocity: wp.array(dtype=wp.float64)  # [m/s]
    pose: wp.array2d(dtype=wp.float64)  # [tool, entry], entries: see ToolPoseRow
    moment: wp.array(dtype=wp.vec3d)  # of the sheets on each tool, about its pivot [N m]


@wp.func
def curve_at(carriers: Carriers, curve: wp.int32, time: wp.float64):
    """Value of one curve."""
    first = carriers.first_piece[curve]
    return piecewise_cubic(carriers.start, carriers.piece, first, carriers.first_piece[curve + 1] - 1, time)


@wp.func
def turned(axis: wp.vec3d, angle: wp.float64):
    """Matrix of a rotation (Rodrigues)."""
    s = wp.sin(angle)
    c = wp.float64(1.0) - wp.cos(angle)
    k = wp.skew(axis)
    return wp.identity(n=3, dtype=wp.float64) + s * k + c * (k * k)


@wp.func
def place_tool(carrier: Carrier, k: wp.int32, angle: wp.float64, way: wp.vec3d, poses: wp.array2d(dtype=wp.float64)):
    """Write rotation, shift and pivot of tool ``k``, turned by ``angle`` and moved by ``way`` in all."""
    turn = turned(carrier.axis, angle)
    rotation = turn * carrier.rotation
    pivot = carrier.point + way
    for i in range(3):
        for j in range(3):
            poses[k, ToolPoseRow.rotation + 3 * i + j] = rotation[i, j]
    store_vector(poses, k, ToolPoseRow.shift, turn * (carrier.shift - carrier.point) + pivot)
    store_vector(poses, k, ToolPoseRow.pivot, pivot)


@wp.func
def carry_tool(
    # In
    k: wp.int32,
    carriers: Carriers,
    along: wp.vec3d,  # displacement along the axis at the end of the step [m]
    time: wp.float64,  # at the end of the step
    step: wp.float64,
    # Out
    poses: wp.array2d(dtype=wp.float64),  # [tool, entry], entries: see ToolPoseRow
):
    """Carry tool ``k`` to where its curves are at the end of a step; returns the velocities of path and rotation."""
    carrier = carriers.carrier[k]
    curve = k * CURVE_COUNT
    x = curve_at(carriers, curve, time)
    y = curve_at(carriers, curve + 1, time)
    offset = wp.vec3d(x, y, curve_at(carriers, curve + 2, time))
    angle = curve_at(carriers, curve + 3, time)
    velocity = (offset - vector_entries(poses, k, ToolPoseRow.offset)) / step
    spin = (angle - poses[k, ToolPoseRow.angle]) / step * carrier.axis
    place_tool(carrier, k, angle, offset + along, poses)
    store_vector(poses, k, ToolPoseRow.velocity, velocity)
    store_vector(poses, k, ToolPoseRow.spin, spin)
    store_vector(poses, k, ToolPoseRow.offset, offset)
    poses[k, ToolPoseRow.angle] = angle
    return velocity, spin


@cache
def carried_motion_kernel(real: type):
    """Kernel as ``tool_motion_kernel``, for runs with carried tools.

    Of ``reactions`` the first half of the rows are forces, the others their moments about the pivots.
    """
    vec3, move_tool = wp.types.vector(3, real), move_tool_function(True)

    @wp.kernel(module="unique", enable_backward=False)
    def carried_motion(
        # In
        drives: ToolDrives,
        carriers: Carriers,
        reactions: wp.array2d(dtype=vec3),
        # Out
        clock: wp.array(dtype=wp.float64),
        motion: CarriedMotion,
        total_reaction: wp.array(dtype=wp.vec3d),
        kept: wp.array2d(dtype=wp.float64),  # rows: see ToolDriveRow
        books: ToolBooks,
    ):
        step = clock[ClockEntry.step]
        next_time = clock[ClockEntry.time] + step
        half = wp.float64(0.5) * clock[ClockEntry.mean_step]
        thread = wp.tid()
        count = drives.drive.shape[0]
        for k in range(thread, count, drives.thread_count):
            total = total_force(reactions, k)
            moment = total_force(reactions, count + k)
            total_reaction[k] = total
            motion.moment[k] = moment
            velocity = vector_entries(motion.pose, k, ToolPoseRow.velocity)
            spin = vector_entries(motion.pose, k, ToolPoseRow.spin)
            along = wp.dot(total, drives.axis[k])
            wanted = move_tool(k, along, drives, clock, motion.displacement, motion.velocity, kept, books)
            watch_tool(books.watch, k, step, wanted, total, along)
            way = motion.displacement[k] * drives.axis[k]
            new_velocity, new_spin = carry_tool(k, carriers, way, next_time, step, motion.pose)
            # as in ``move_tool``: the travel at the instant of the forces is the mean of two half steps
            work = half * (wp.dot(total, velocity + new_velocity) + wp.dot(moment, spin + new_spin))
            book(books.work, ToolWorkRow.carrying, k, -work)
        wait_for_block()
        if thread == 0:
            clock[ClockEntry.time] = next_time
            clock[ClockEntry.mean_step] = step

    return carried_motion
