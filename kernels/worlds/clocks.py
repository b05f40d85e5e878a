"""Tools, drives and clocks of many worlds: one thread for each world that still runs."""

from functools import cache

import warp as wp

from ..rows import ClockEntry
from ..stepping.step import MAXIMUM_GROUP, choose_step, goes_on, not_lost
from ..stepping.supports import support_motion_function
from ..stepping.tools import move_tool_function, total_force, watch_tool
from .arguments import ToolArguments, drive_arguments


@cache
def world_tools_kernel(real: type):
    """Kernel, launched once per step: move the tools, and advance the clocks; see ``tool_motion_kernel``.

    ``real`` is that of ``reactions``, whose rows are the tools of all worlds.
    """
    vec3, move_tool = wp.types.vector(3, real), move_tool_function(True)

    @wp.kernel(module="unique", enable_backward=False)
    def world_tools(
        running: wp.array(dtype=wp.int32),
        reactions: wp.array2d(dtype=vec3),
        worlds: wp.array(dtype=ToolArguments),
    ):
        world = wp.tid()
        if running[world] != 0:
            a = worlds[world]
            step = a.clock[ClockEntry.step]
            next_time = a.clock[ClockEntry.time] + step
            count = a.drives.drive.shape[0]
            for k in range(count):
                total = total_force(reactions, world * count + k)
                a.force[k] = total
                along = wp.dot(total, a.drives.axis[k])
                wanted = move_tool(k, along, a.drives, a.clock, a.displacement, a.velocity, a.kept, a.books)
                watch_tool(a.books.watch, k, step, wanted, total, along)
            a.clock[ClockEntry.time] = next_time
            a.clock[ClockEntry.mean_step] = step

    return world_tools


@cache
def world_drives_kernel(real: type):
    """Kernel, launched once per step: increments of the drives; see ``support_motion_kernel``."""
    Arguments, move_drives = drive_arguments(real), support_motion_function(real)

    @wp.kernel(module="unique", enable_backward=False)
    def world_drives(running: wp.array(dtype=wp.int32), worlds: wp.array(dtype=Arguments)):
        world = wp.tid()
        if running[world] != 0:
            a = worlds[world]
            move_drives(a.first_piece, a.start, a.piece, a.clock, a.displacement, a.increment)

    return world_drives


@cache
def world_tile_maxima_kernel(real: type):
    """Largest of ``MAXIMUM_GROUP`` neighbouring entries of each row; launched in tiles, (row, group)."""

    @wp.kernel(module="unique", enable_backward=False)
    def world_tile_maxima(values: wp.array2d(dtype=real), maxima: wp.array2d(dtype=real)):
        row, group = wp.tid()
        # entries beyond the last read as zero
        part = wp.tile_load(values, shape=(1, MAXIMUM_GROUP), offset=(row, group * MAXIMUM_GROUP))
        maxima[row, group] = wp.tile_extract(wp.tile_max(wp.tile_map(not_lost, part)), 0)

    return world_tile_maxima


@cache
def world_maxima_kernel(real: type):
    """The same with one thread per group, for a CPU; see ``group_maximum_kernel``."""

    @wp.kernel(module="unique", enable_backward=False)
    def world_maxima(values: wp.array2d(dtype=real), maxima: wp.array2d(dtype=real)):
        row, group = wp.tid()
        first = group * MAXIMUM_GROUP
        largest = real(0.0)
        for i in range(first, wp.min(first + MAXIMUM_GROUP, values.shape[1])):
            largest = wp.max(largest, not_lost(values[row, i]))
        maxima[row, group] = largest

    return world_maxima


@cache
def world_steps_kernel(real: type):
    """Kernel, launched once per block of steps: the next step of each world; see ``set_step_kernel``."""

    @wp.kernel(module="unique", enable_backward=False)
    def world_steps(
        running: wp.array(dtype=wp.int32),
        maxima: wp.array2d(dtype=real),
        safety: wp.array(dtype=wp.float64),
        largest_step: wp.array(dtype=wp.float64),
        clocks: wp.array2d(dtype=wp.float64),
    ):
        world = wp.tid()
        if running[world] != 0:
            largest = real(0.0)
            for i in range(maxima.shape[1]):
                largest = wp.where(maxima[world, i] <= largest, largest, maxima[world, i])
            choose_step(largest, safety[world], largest_step[world], clocks[world])

    return world_steps


@wp.kernel(module="unique", enable_backward=False)
def check_worlds(
    # In
    done: wp.int32,  # blocks since the last call
    largest_block_count: wp.int32,
    target: wp.array(dtype=wp.float64),  # time at which the interval of each world ends [s]
    clocks: wp.array2d(dtype=wp.float64),
    # Out
    block_count: wp.array(dtype=wp.int32),  # of each world
    running: wp.array(dtype=wp.int32),
    running_count: wp.array(dtype=wp.int32),  # zero before
):
    """See ``check_clock``: a world that has reached its target waits for the others."""
    world = wp.tid()
    if done == 0 or running[world] != 0:
        block_count[world] = block_count[world] + done
        on = wp.where(goes_on(clocks[world], target[world]) and block_count[world] < largest_block_count, 1, 0)
        running[world] = on
        wp.atomic_add(running_count, 0, on)
