"""Prescribed motion of supports: the increment of each drive in the next step."""

from functools import cache

import warp as wp

from ..rows import ClockEntry


@wp.func
def piecewise_cubic(
    start: wp.array(dtype=wp.float64), piece: wp.array(dtype=wp.vec4d), first: int, last: int, time: wp.float64
):
    """Value at ``time`` of the curve made of the cubic pieces ``first`` to ``last``; constant before its start."""
    low = first
    high = last + 1
    while high - low > 1:
        middle = (low + high) / 2
        if start[middle] <= time:
            low = middle
        else:
            high = middle
    x = wp.max(time - start[low], wp.float64(0.0))
    c = piece[low]
    return c[0] + x * (c[1] + x * (c[2] + x * c[3]))


@cache
def support_motion_function(real: type):
    """Function for the increments of all drives in the next step.

    An increment is rounded to the precision of the run, and the drive's displacement is the sum of rounded increments:
    the next one corrects the rounding error, so that the sum does not drift from the curve.
    """

    @wp.func
    def move_drives(
        # In
        first_piece: wp.array(dtype=wp.int32),  # of each drive, and the number of all pieces
        start: wp.array(dtype=wp.float64),  # of each piece [s]
        piece: wp.array(dtype=wp.vec4d),  # c0 + c1 x + c2 x^2 + c3 x^3 [m], x the time since its start
        clock: wp.array(dtype=wp.float64),
        # Out
        displacement: wp.array(dtype=wp.float64),  # at the end of the step [m]
        increment: wp.array(dtype=real),  # of the step [m]
    ):
        next_time = clock[ClockEntry.time] + clock[ClockEntry.step]
        for k in range(displacement.shape[0]):
            goal = piecewise_cubic(start, piece, first_piece[k], first_piece[k + 1] - 1, next_time)
            change = real(goal - displacement[k])
            increment[k] = change
            displacement[k] = displacement[k] + wp.float64(change)

    return move_drives


@cache
def support_motion_kernel(real: type):
    """Kernel of a single thread per step, before the nodes move."""
    move_drives = support_motion_function(real)

    @wp.kernel(module="unique", enable_backward=False)
    def support_motion(
        # In
        first_piece: wp.array(dtype=wp.int32),
        start: wp.array(dtype=wp.float64),
        piece: wp.array(dtype=wp.vec4d),
        clock: wp.array(dtype=wp.float64),
        # Out
        displacement: wp.array(dtype=wp.float64),
        increment: wp.array(dtype=real),
    ):
        move_drives(first_piece, start, piece, clock, displacement, increment)

    return support_motion
