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
def stroke_rate(drives: ToolDrives, drive: ToolDrive, time: wp.float64, step: wp.float64, along: wp.float64):
    """Share of its speed at which a stroke goes on against ``along`` [N], from 1 to -1: it waits at its largest force.

    Near that force the rate falls with it. The gain is such that a step changes the force by at most half of what is
    left, even if all nodes touch.
    """
    one = wp.float64(1.0)
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


@wp.func
def stroke_time(
    drives: ToolDrives,
    drive: ToolDrive,
    last: wp.float64,
    next_time: wp.float64,
    step: wp.float64,
    along: wp.float64,
):
    """Time on the curve of a stroke at the end of the step: that of the clock, or its own with a largest force."""
    result = next_time
    if drive.largest_force > wp.float64(0.0):
        end = drives.curve_time[drive.first_knot + drive.knot_count - 1]
        result = wp.min(last + step * stroke_rate(drives, drive, last, step, along), end)
    return result


@wp.func
def damper_share(drive: ToolDrive, carrying: wp.float64):
    """Share of its damper that acts on a tool: whole where it lands, none in the air, fading while sheets carry it."""
    return wp.where(carrying > wp.float64(0.0), wp.exp(-carrying * drive.fading), wp.float64(0.0))


@wp.func
def damped(drive: ToolDrive, velocity: wp.float64, gained: wp.float64, share: wp.float64, step: wp.float64):
    """New velocity, and the energy lost, of a mass on a damper of ``share`` (Crank-Nicolson).

    ``gained`` is the velocity that all other forces give the mass in the step.
    """
    half = wp.float64(0.5)
    decay = step * share * drive.damping / drive.mass
    mean = (velocity + half * gained) / (wp.float64(1.0) + half * decay)
    return velocity + gained - decay * mean, decay * drive.mass * mean * mean


@wp.func
def stopped(
    drive: ToolDrive, at: wp.float64, before: wp.float64, gained: wp.float64, share: wp.float64, steps: wp.vec2d
):
    """New velocity of a mass at ``at``, on a damper, and the energy that this and its spacers take from it.

    ``steps`` are the step to come and the mean step. A mass beyond its spacers already is held where it is.
    """
    velocity, lost = damped(drive, before, gained, share, steps[1])
    room = wp.max(drive.stop_way * (drive.stop - at), wp.float64(0.0))
    held = drive.stop_way * steps[0] * velocity > room
    if held:
        velocity = drive.stop_way * room / steps[0]
        lost = drive.mass * (gained - (velocity - before)) * wp.float64(0.5) * (before + velocity)
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
def add(rows: wp.array2d(dtype=wp.float64), row: int, k: int, value: wp.float64):
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
        add(watch, ToolWatchRow.waited, k, step - since)
        add(watch, ToolWatchRow.wanted, k, since)
        add(watch, ToolWatchRow.idle, k, wp.where(carried < wp.float64(0.5) * force, since, none))
        add(watch, ToolWatchRow.wanted_impulse, k, since * force)
        add(watch, ToolWatchRow.carried_impulse, k, since * carried)


@wp.func_native("""
#if defined(__CUDA_ARCH__)
    __syncthreads();
#endif
""")
def wait_for_block():
    """On a GPU, wait for the other threads of the block."""


@wp.func
def move_tool(
    # In
    k: wp.int32,
    total: wp.vec3d,  # force of the sheets on it [N]
    drives: ToolDrives,
    clock: wp.array(dtype=wp.float64),
    # Out
    displacement: wp.array(dtype=wp.float64),
    velocity: wp.array(dtype=wp.float64),
    kept: wp.array2d(dtype=wp.float64),  # rows: see ToolDriveRow
    books: ToolBooks,
):
    """Move tool ``k`` by one step, and book works; the clock is advanced later."""
    step = clock[ClockEntry.step]
    next_time = clock[ClockEntry.time] + step
    drive = drives.drive[k]
    along = wp.dot(total, drives.axis[k])
    old = displacement[k]
    old_velocity = velocity[k]
    drive_force = wp.float64(0.0)
    wanted = wp.float64(0.0)
    new = old
    if drive.kind == FORCE:
        drive_force = curve_value(drives.curve_time, drives.curve_value, drive, clock[ClockEntry.time])
        mean_step = clock[ClockEntry.mean_step]
        gained = mean_step * (drive_force + along) / drive.mass
        carries = along * drive_force < wp.float64(0.0)
        carrying = wp.where(carries, kept[ToolDriveRow.carrying, k] + mean_step, wp.float64(0.0))
        kept[ToolDriveRow.carrying, k] = carrying
        share = damper_share(drive, carrying)
        new_velocity, lost, held = stopped(drive, old, old_velocity, gained, share, wp.vec2d(step, mean_step))
        # what spacers hold back is not wanted of the sheets
        wanted = wp.where(held, wp.float64(0.0), drive_force)
        velocity[k] = new_velocity
        add(books.work, ToolWorkRow.damping, k, lost)
        new = old + step * velocity[k]
    else:
        at = stroke_time(drives, drive, kept[ToolDriveRow.stroke_time, k], next_time, step, along)
        kept[ToolDriveRow.stroke_time, k] = at
        new = curve_value(drives.curve_time, drives.curve_value, drive, at)
        velocity[k] = (new - old) / step
    displacement[k] = new
    # forces are at the current instant, between two half steps: as for a node, the travel is the mean of both
    travel = wp.float64(0.5) * clock[ClockEntry.mean_step] * (old_velocity + velocity[k])
    add(books.work, ToolWorkRow.on_sheet, k, -along * travel)
    add(books.work, ToolWorkRow.driving, k, drive_force * travel)
    watch_tool(books.watch, k, step, wanted, total, along)


@cache
def tool_motion_kernel(real: type):
    """Kernel of one block of threads per step, between the node kernel and the next step; of one thread on a CPU."""
    vec3 = wp.types.vector(3, real)

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
            move_tool(k, total, drives, clock, displacement, velocity, kept, books)
        wait_for_block()
        if thread == 0:
            clock[ClockEntry.time] = next_time
            clock[ClockEntry.mean_step] = step

    return tool_motion
