"""Rigid tools: sum the reactions in a fixed order, move along a stroke curve or by a force, advance the clock."""

from functools import cache
from typing import Any

import warp as wp

from ..rows import ClockEntry, ToolDriveRow, ToolWatchRow, ToolWorkRow

STROKE = wp.constant(0)
FORCE = wp.constant(1)
# Neighbouring entries that one tile of ``partial_sum_kernel`` sums.
SUM_GROUP = wp.constant(1024)
# A stroke with a largest force goes at full speed up to this share of it.
UNHINDERED_SHARE = wp.constant(0.8)


@wp.struct
class ToolDrive:
    """Motion law of one tool; its curve is a range of knots in the common arrays."""

    kind: wp.int32
    first_knot: wp.int32
    knot_count: wp.int32
    mass: wp.float64  # [kg], of a force-driven tool
    damping: wp.float64  # of its damper where it lands [N s/m]
    fading: wp.float64  # rate at which the damper fades while the tool carries [1/s]
    largest_force: wp.float64  # at which a stroke waits [N]; 0 for none
    stiffness: wp.float64  # largest of the contact with all sheets [N/m]
    stop: wp.float64  # displacement at which spacers hold a tool that a force moves [m]
    stop_way: wp.float64  # towards them: 1 or -1 along the axis; 0 without spacers


@wp.struct
class ToolDrives:
    """How all tools move."""

    thread_count: wp.int32  # threads that move them, at most one block
    drive: wp.array(dtype=ToolDrive)
    axis: wp.array(dtype=wp.vec3d)  # unit direction of each tool's motion
    curve_time: wp.array(dtype=wp.float64)  # knots of all curves [s]
    curve_value: wp.array(dtype=wp.float64)  # [m] or [N]


@wp.struct
class ToolBooks:
    """What is booked of each tool; all of it is written."""

    work: wp.array2d(dtype=wp.float64)  # rows: see ToolWorkRow
    watch: wp.array2d(dtype=wp.float64)  # rows: see ToolWatchRow


@wp.func
def curve_value(
    curve_time: wp.array(dtype=wp.float64), curve_value: wp.array(dtype=wp.float64), drive: ToolDrive, time: wp.float64
):
    """Piecewise linear in time, constant beyond its ends."""
    low = drive.first_knot
    high = drive.first_knot + drive.knot_count - 1
    result = curve_value[high]
    if time <= curve_time[low]:
        result = curve_value[low]
    elif time < curve_time[high]:
        while high - low > 1:
            middle = (low + high) / 2
            if curve_time[middle] <= time:
                low = middle
            else:
                high = middle
        share = (time - curve_time[low]) / (curve_time[high] - curve_time[low])
        result = curve_value[low] + share * (curve_value[high] - curve_value[low])
    return result


@wp.func
def stroke_rate(drives: ToolDrives, k: wp.int32, time: wp.float64, step: wp.float64, along: wp.float64):
    """Share of its speed at which stroke ``k`` goes on against ``along`` [N], from 1 to -1: it waits at its largest
    force.

    Near that force the rate falls with it. The gain is such that a step changes the force by at most half of what is
    left, even if all nodes touch.
    """
    one = wp.float64(1.0)
    drive = drives.drive[k]
    here = curve_value(drives.curve_time, drives.curve_value, drive, time)
    ahead = curve_value(drives.curve_time, drives.curve_value, drive, time + step) - here
    behind = here - curve_value(drives.curve_time, drives.curve_value, drive, time - step)
    resisted = -along * wp.sign(wp.where(ahead != wp.float64(0.0), ahead, behind))
    rate = one
    if resisted > wp.float64(UNHINDERED_SHARE) * drive.largest_force:
        travel = wp.max(wp.abs(ahead), wp.abs(behind))
        width = wp.max(
            (one - wp.float64(UNHINDERED_SHARE)) * drive.largest_force, wp.float64(2.0) * drive.stiffness * travel
        )
        rate = wp.clamp((drive.largest_force - resisted) / width, -one, one)
    return rate


@cache
def stroke_time_function(waits: bool):
    """Function for the time on the curve of a stroke at the end of the step: that of the clock, or, where it ``waits``
    at a largest force, its own.
    """

    @wp.func
    def stroke_time(
        k: wp.int32,
        along: wp.float64,
        drives: ToolDrives,
        clock: wp.array(dtype=wp.float64),
        kept: wp.array2d(dtype=wp.float64),
    ):
        step = clock[ClockEntry.step]
        result = clock[ClockEntry.time] + step
        if wp.static(waits):
            if drives.drive[k].largest_force > wp.float64(0.0):
                last = kept[ToolDriveRow.stroke_time, k]
                end = drives.curve_time[drives.drive[k].first_knot + drives.drive[k].knot_count - 1]
                result = wp.min(last + step * stroke_rate(drives, k, last, step, along), end)
        kept[ToolDriveRow.stroke_time, k] = result
        return result

    return stroke_time


@wp.func
def damper_share(
    k: wp.int32, carries: bool, mean_step: wp.float64, drives: ToolDrives, kept: wp.array2d(dtype=wp.float64)
):
    """Share of its damper that acts on a tool: whole where it lands, none in the air, fading while sheets carry it."""
    none = wp.float64(0.0)
    carrying = wp.where(carries, kept[ToolDriveRow.carrying, k] + mean_step, none)
    kept[ToolDriveRow.carrying, k] = carrying
    return wp.where(carrying > none, wp.exp(-carrying * drives.drive[k].fading), none)


@wp.func
def damped(drives: ToolDrives, k: wp.int32, velocity: wp.float64, gained: wp.float64, shared_step: wp.float64):
    """New velocity, and the energy lost, of a mass on a damper (Crank-Nicolson), of which a share acts for a step.

    ``gained`` is the velocity that all other forces give the mass in the step.
    """
    half = wp.float64(0.5)
    mass = drives.drive[k].mass
    decay = shared_step * drives.drive[k].damping / mass
    mean = (velocity + half * gained) / (wp.float64(1.0) + half * decay)
    return velocity + gained - decay * mean, decay * mass * mean * mean


@wp.func
def stopped(
    drives: ToolDrives, k: wp.int32, at: wp.float64, before: wp.float64, gained: wp.float64, shared_step: wp.float64,
    step: wp.float64,
):  # fmt: skip
    """New velocity of a mass at ``at``, on a damper, and the energy that this and its spacers take from it.

    ``step`` is the step to come. A mass beyond its spacers already is held where it is.
    """
    velocity, lost = damped(drives, k, before, gained, shared_step)
    way = drives.drive[k].stop_way
    room = wp.max(way * (drives.drive[k].stop - at), wp.float64(0.0))
    held = way * step * velocity > room
    if held:
        velocity = way * room / step
        lost = drives.drive[k].mass * (gained - (velocity - before)) * wp.float64(0.5) * (before + velocity)
    return velocity, lost, held


@cache
def partial_sum_kernel(real: type):
    """Sum ``SUM_GROUP`` neighbouring reactions in double precision, so that the final sum stays short with many nodes.

    Launched in tiles, (tool, group): on a GPU the threads of a block share a group, in an order that does not change.
    """
    vec3 = wp.types.vector(3, real)

    @wp.func
    def in_double(value: vec3):
        return wp.vec3d(wp.float64(value[0]), wp.float64(value[1]), wp.float64(value[2]))

    @wp.kernel(module="unique", enable_backward=False)
    def partial_sums(values: wp.array2d(dtype=vec3), sums: wp.array2d(dtype=wp.vec3d)):
        tool, group = wp.tid()
        # entries beyond the last read as zero
        part = wp.tile_load(values, shape=(1, SUM_GROUP), offset=(tool, group * SUM_GROUP))
        total = wp.tile_sum(wp.tile_map(in_double, part))
        sums[tool, group] = wp.tile_extract(total, 0)

    return partial_sums


@wp.func
def total_force(forces: Any, tool: int):
    """Sum of a tool's row, in double precision and in a fixed order."""
    total = wp.vec3d()
    for i in range(forces.shape[1]):
        value = forces[tool, i]
        total += wp.vec3d(wp.float64(value[0]), wp.float64(value[1]), wp.float64(value[2]))
    return total


@wp.func
def book(rows: wp.array2d(dtype=wp.float64), row: int, k: int, value: wp.float64):
    """Add what tool ``k`` gained in this step; not ``add``, by which Warp finds the sum of lanes (operators.py)."""
    rows[row, k] = rows[row, k] + value


@wp.func
def watch_tool(
    watch: wp.array2d(dtype=wp.float64),
    k: int,
    step: wp.float64,
    wanted: wp.float64,
    total: wp.vec3d,
    along: wp.float64,
):
    """Book what the sheets did to tool ``k`` in this step; ``wanted`` [N] along its axis drives it, if by force."""
    none = wp.float64(0.0)
    peak = wp.max(watch[ToolWatchRow.peak, k], wp.length(total))
    watch[ToolWatchRow.peak, k] = peak
    if wanted != none:
        force = wp.abs(wanted)
        # what the sheets carry pushes back
        carried = wp.max(-along * wp.sign(wanted), none)
        watch[ToolWatchRow.most_wanted, k] = wp.max(watch[ToolWatchRow.most_wanted, k], force)
        since = wp.where(peak > none, step, none)
        book(watch, ToolWatchRow.waited, k, step - since)
        book(watch, ToolWatchRow.wanted, k, since)
        book(watch, ToolWatchRow.idle, k, wp.where(carried < wp.float64(0.5) * force, since, none))
        book(watch, ToolWatchRow.wanted_impulse, k, since * force)
        book(watch, ToolWatchRow.carried_impulse, k, since * carried)


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    __syncthreads();
#endif
""")
def wait_for_block():
    """On a GPU, wait for the other threads of the block."""


@cache
def move_tool_function(waits: bool):
    """Function that moves a tool by one step, and books works; the clock is advanced later.

    ``waits`` tells whether any stroke has a largest force. What a step needs is read late, and little lives at a time:
    a GPU has few registers.
    """
    stroke_time = stroke_time_function(waits)

    @wp.func
    def move_tool(
        # In
        k: wp.int32,
        along: wp.float64,  # force of the sheets on it, along its axis [N]
        drives: ToolDrives,
        clock: wp.array(dtype=wp.float64),
        # Out
        displacement: wp.array(dtype=wp.float64),
        velocity: wp.array(dtype=wp.float64),
        kept: wp.array2d(dtype=wp.float64),  # rows: see ToolDriveRow
        books: ToolBooks,
    ):
        """Returns the force that is wanted of the sheets [N], if one drives it."""
        by_force = drives.drive[k].kind == FORCE
        time = clock[ClockEntry.time]
        if not by_force:
            time = stroke_time(k, along, drives, clock, kept)
        value = curve_value(drives.curve_time, drives.curve_value, drives.drive[k], time)
        before = velocity[k]
        after = before
        new = value
        force = wp.float64(0.0)
        wanted = wp.float64(0.0)
        if by_force:
            force = value
            step = clock[ClockEntry.mean_step]
            share = damper_share(k, along * force < wp.float64(0.0), step, drives, kept)
            gained = step * (force + along) / drives.drive[k].mass
            after, lost, held = stopped(
                drives, k, displacement[k], before, gained, step * share, clock[ClockEntry.step]
            )
            book(books.work, ToolWorkRow.damping, k, lost)
            # what spacers hold back is not wanted of the sheets
            wanted = wp.where(held, wp.float64(0.0), force)
            new = displacement[k] + clock[ClockEntry.step] * after
        else:
            after = (value - displacement[k]) / clock[ClockEntry.step]
        displacement[k] = new
        velocity[k] = after
        # forces are at the current instant, between two half steps: as for a node, the travel is the mean of both
        travel = wp.float64(0.5) * clock[ClockEntry.mean_step] * (before + after)
        book(books.work, ToolWorkRow.on_sheet, k, -along * travel)
        book(books.work, ToolWorkRow.driving, k, force * travel)
        return wanted

    return move_tool


@cache
def tool_motion_kernel(real: type, waits: bool):
    """Kernel of one block of threads per step, between the node kernel and the next step; of one thread on a CPU.

    ``waits`` as in ``move_tool_function``.
    """
    vec3, move_tool = wp.types.vector(3, real), move_tool_function(waits)

    @wp.kernel(module="unique", enable_backward=False)
    def tool_motion(
        # In
        drives: ToolDrives,
        reactions: wp.array2d(dtype=vec3),
        # Out
        clock: wp.array(dtype=wp.float64),
        displacement: wp.array(dtype=wp.float64),
        velocity: wp.array(dtype=wp.float64),
        total_reaction: wp.array(dtype=wp.vec3d),
        kept: wp.array2d(dtype=wp.float64),  # rows: see ToolDriveRow
        books: ToolBooks,
    ):
        step = clock[ClockEntry.step]
        next_time = clock[ClockEntry.time] + step
        thread = wp.tid()
        for k in range(thread, drives.drive.shape[0], drives.thread_count):
            total = total_force(reactions, k)
            total_reaction[k] = total
            along = wp.dot(total, drives.axis[k])
            wanted = move_tool(k, along, drives, clock, displacement, velocity, kept, books)
            watch_tool(books.watch, k, step, wanted, total_reaction[k], along)
        wait_for_block()
        if thread == 0:
            clock[ClockEntry.time] = next_time
            clock[ClockEntry.mean_step] = step

    return tool_motion
