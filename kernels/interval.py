"""Whether a GPU goes on with the blocks of an output interval; it asks no host between them."""

import warp as wp

from .node import CLOCK_STEP, CLOCK_TIME


@wp.kernel(module="unique", enable_backward=False)
def look_at_clock(
    # In
    done: wp.int32,  # blocks since the last look
    largest_block_count: wp.int32,
    target: wp.array(dtype=wp.float64),  # time at which the interval ends [s]
    clock: wp.array(dtype=wp.float64),
    # Out
    block_count: wp.array(dtype=wp.int32),
    running: wp.array(dtype=wp.int32),
):
    """A single thread; the first end of a block at or beyond the target ends the interval, and so does a lost state."""
    block_count[0] = block_count[0] + done
    step = clock[CLOCK_STEP]
    # comparisons with NaN are false
    alive = step > wp.float64(0.0) and wp.isfinite(step)
    running[0] = wp.where(alive and clock[CLOCK_TIME] < target[0] and block_count[0] < largest_block_count, 1, 0)
