"""The next time step, and the end of an output interval on a GPU."""

from functools import cache
from typing import Any

import warp as wp

from ..lane_types import lane_types
from ..rows import ClockEntry

# A step that shrinks goes to this share of the limit, so that it need not shrink again at once.
STEP_MARGIN = wp.constant(0.98)
# A step grows by STEP_GROWTH per refresh once the limit exceeds it by STEP_SLACK.
STEP_GROWTH = wp.constant(1.02)
STEP_SLACK = wp.constant(1.05)
# Neighbouring entries of which one tile of ``partial_maximum_kernel`` takes the largest.
MAXIMUM_GROUP = wp.constant(1024)


@wp.func
def not_lost(value: Any):
    """A NaN becomes infinity, so that the step shrinks to zero and the run stops."""
    return wp.where(value == value, value, type(value)(wp.inf))


@cache
def partial_maximum_kernel(real: type):
    """Largest of ``MAXIMUM_GROUP`` neighbouring entries, which are not negative; launched in tiles, one per group."""

    @wp.kernel(module="unique", enable_backward=False)
    def partial_maximum(values: wp.array(dtype=real), maxima: wp.array(dtype=real)):
        group = wp.tid()
        # entries beyond the last read as zero
        part = wp.tile_load(values, shape=MAXIMUM_GROUP, offset=group * MAXIMUM_GROUP)
        maxima[group] = wp.tile_extract(wp.tile_max(wp.tile_map(not_lost, part)), 0)

    return partial_maximum


@cache
def group_maximum_kernel(real: type, group_size: int):
    """Kernel with one thread per ``group_size`` neighbouring entries, which are not negative: the largest of them.

    On a CPU it does what ``partial_maximum_kernel`` does: there, tiles of runs side by side would share their memory.
    """

    @wp.kernel(module="unique", enable_backward=False)
    def group_maximum(values: wp.array(dtype=real), maxima: wp.array(dtype=real)):
        group = wp.tid()
        first = group * group_size
        largest = real(0.0)
        for i in range(first, wp.min(first + group_size, values.shape[0])):
            largest = wp.max(largest, not_lost(values[i]))
        maxima[group] = largest

    return group_maximum


@cache
def fold_works_function(real: type, lane_count: int):
    """Function for one block of nodes: add the works of the last steps to the sums, and start again."""
    lanes = lane_types(real, lane_count).lanes

    @wp.func
    def fold_works_of_block(
        # In
        block: wp.int32,
        # Out
        works: wp.array2d(dtype=lanes),  # rows: see NodeWorkRow
        sums: wp.array2d(dtype=wp.float64),
    ):
        for row in range(works.shape[0]):
            recent = works[row, block]
            total = sums[row, block]
            for i in range(lane_count):
                total = total + wp.float64(recent[i])
            sums[row, block] = total
            works[row, block] = lanes()

    return fold_works_of_block


@cache
def fold_works_kernel(real: type, lane_count: int):
    """Kernel of one thread per block of nodes: all of that for every block."""
    lanes = lane_types(real, lane_count).lanes
    fold_works_of_block = fold_works_function(real, lane_count)

    @wp.kernel(module="unique", enable_backward=False)
    def fold_works(
        # In
        first_block: wp.int32,
        # Out
        works: wp.array2d(dtype=lanes),
        sums: wp.array2d(dtype=wp.float64),
    ):
        fold_works_of_block(first_block + wp.tid(), works, sums)

    return fold_works


@wp.func
def choose_step(largest: Any, safety: wp.float64, largest_step: wp.float64, clock: wp.array(dtype=wp.float64)):
    """The next time step, from the ``largest`` squared frequency [1/s^2]: see ``set_step_kernel``."""
    stable = safety * wp.float64(2.0) / wp.sqrt(wp.float64(largest))
    old = clock[ClockEntry.step]
    new = old
    if not wp.min(stable, largest_step) >= old:  # a NaN shrinks the step too, and so stops the run
        new = wp.min(wp.float64(STEP_MARGIN) * stable, largest_step)
    elif stable > wp.float64(STEP_SLACK) * old:
        new = wp.min(wp.float64(STEP_GROWTH) * old, largest_step)
    clock[ClockEntry.step] = new
    clock[ClockEntry.mean_step] = wp.float64(0.5) * (old + new)


@cache
def set_step_kernel(real: type):
    """The next time step: kept as long as it is stable and not far below the limit, since every change costs energy.

    Central differences with a constant step conserve an energy of their own; each change of the step violates that, and
    since the stable step follows the state, the errors accumulate.
    """

    @wp.kernel(module="unique", enable_backward=False)
    def set_step(
        maxima: wp.array(dtype=real),
        safety: wp.float64,
        largest_step: wp.float64,
        clock: wp.array(dtype=wp.float64),
    ):
        largest = real(0.0)
        for i in range(maxima.shape[0]):
            largest = wp.where(maxima[i] <= largest, largest, maxima[i])
        choose_step(largest, safety, largest_step, clock)

    return set_step


@wp.func
def goes_on(clock: wp.array(dtype=wp.float64), target: wp.float64):
    """Whether a state is finite and before ``target`` [s]."""
    step = clock[ClockEntry.step]
    # comparisons with NaN are false
    alive = step > wp.float64(0.0) and wp.isfinite(step)
    return alive and clock[ClockEntry.time] < target


@wp.kernel(module="unique", enable_backward=False)
def check_clock(
    # In
    done: wp.int32,  # blocks since the last call
    largest_block_count: wp.int32,
    target: wp.array(dtype=wp.float64),  # time at which the interval ends [s]
    clock: wp.array(dtype=wp.float64),
    # Out
    block_count: wp.array(dtype=wp.int32),
    running: wp.array(dtype=wp.int32),
):
    """Single thread; the interval ends with the first block that reaches the target, or if the state is not finite."""
    block_count[0] = block_count[0] + done
    running[0] = wp.where(goes_on(clock, target[0]) and block_count[0] < largest_block_count, 1, 0)
