"""Equilibrium of an energy's unknowns in all lanes at once, by a safeguarded Newton method, in double precision.

The state x of the lanes is a matrix with a row for every strain, every unknown, its last change, and the shift of
Newton's matrix.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import warp as wp

from ..lanes import fill, lane_maximum, larger, magnitude, smaller, where_positive
from ..operators import div, mul  # noqa: F401
from .cell_formulas import STRAIN_COUNT
from .law import MAXIMUM_ITERATIONS

# Largest change of an unknown in one Newton step, and largest change that is accepted without a look at the energy.
STEP_LIMIT = wp.constant(wp.float64(0.25))
SMALL_STEP = wp.constant(wp.float64(1.0e-3))
FIRST_SHIFT = wp.constant(wp.float64(1.0e-3))
# Shares of a step that overshoots that are undone.
LEAST_UNDONE = wp.constant(wp.float64(0.0625))
MOST_UNDONE = wp.constant(wp.float64(0.9375))
SHIFT_COUNT = 60
# Rows of what the natively compiled formulas return: energy, derivatives by strains, then by unknowns.
SLOPE = 1
FORCE = SLOPE + STRAIN_COUNT


@wp.func
def next_shift(shift: Any):
    """Of a matrix that is not positive definite with ``shift``: 1e-3, 2e-3, 4e-3, ... after 0."""
    return larger(shift + shift, fill(shift, FIRST_SHIFT))


@cache
def equilibrium_function(unknown_count: int, first: wp.Function, newton: wp.Function) -> Callable[..., Any]:
    """Warp function (p, x) -> (x, rows of ``first`` there, relative residual, iterations).

    A first step is followed by the rows of ``first`` alone: mostly it is the last. Lanes that are done wait.
    """
    n = unknown_count
    row_count, stiffness_row = FORCE + n + 1, FORCE + 2 * n + 2
    relative_residual, definite_newton = residual_function(n), definite_function(n, newton)
    advance = advance_function(n)

    @wp.func
    def chosen(active: Any, new: Any, old: Any):
        """The rows of ``first``, new ones where a lane is active."""
        for k in range(row_count):
            old[k] = where_positive(active, new[k], old[k])
        return old

    @wp.func
    def empty_rows(like: Any):
        return wp.matrix(shape=(row_count, len(like)), dtype=wp.float64)

    @wp.func
    def equilibrium(p: Any, start: Any):
        x = start
        zero = fill(x[0], 0.0)
        active = fill(zero, 1.0)
        slope = zero
        before = zero
        iterations = zero
        residual = active
        answer = empty_rows(zero)
        for iteration in range(MAXIMUM_ITERATIONS + 1):
            y = definite_newton(p, x, active)
            residual = where_positive(active, relative_residual(p, y, y[stiffness_row]), residual)
            answer = chosen(active, y, answer)
            # a NaN is not above the tolerance and ends the iteration too
            active = where_positive(residual - fill(zero, p.tolerance), active, zero)
            if lane_maximum(active) <= zero[0] or iteration == MAXIMUM_ITERATIONS:
                break
            iterations = iterations + active
            x, slope, before = advance(p, x, y, active, slope, before)
            if iteration == 0:
                z = first(p, x)
                reached = relative_residual(p, z, y[stiffness_row])
                if lane_maximum(where_positive(reached - fill(zero, p.tolerance), active, zero)) <= zero[0]:
                    residual = where_positive(active, reached, residual)
                    answer = chosen(active, z, answer)
                    break
        return x, answer, residual, iterations

    return equilibrium


@cache
def residual_function(unknown_count: int) -> Callable[..., Any]:
    """Warp function (p, rows of ``first`` or ``newton``, stiffness of the stiffest unknown) -> relative residual."""
    n = unknown_count

    @wp.func
    def relative_residual(p: Any, y: Any, stiffest: Any):
        """Largest |dpsi/dq| over the size of the forces, a floor, and the rounding error of the stiffest unknown."""
        worst = magnitude(y[FORCE])
        total = y[FORCE]
        for k in range(1, n):
            worst = larger(worst, magnitude(y[FORCE + k]))
            total = total + y[FORCE + k]
        size = magnitude(y[SLOPE]) + magnitude(y[SLOPE + 1]) + magnitude(y[SLOPE + 2])
        size = size + fill(size, p.force_floor) + p.resolution * stiffest
        # comparisons drop a NaN, a sum does not
        return (worst + total.dtype(0.0) * total) / size

    return relative_residual


@cache
def definite_function(unknown_count: int, newton: wp.Function) -> Callable[..., Any]:
    """Warp function (p, x, active lanes) -> rows of ``newton`` with a matrix that is positive definite.

    The shift of the matrix is the first of 0, 1e-3, 2e-3, 4e-3, ... that makes it so.
    """
    shift_row, definite_row = STRAIN_COUNT + 2 * unknown_count, FORCE + 2 * unknown_count + 3

    @wp.func
    def definite_newton(p: Any, x: Any, active: Any):
        zero = fill(active, 0.0)
        x[shift_row] = zero
        y = newton(p, x)
        for _attempt in range(SHIFT_COUNT):
            indefinite = where_positive(y[definite_row], zero, active)
            if lane_maximum(indefinite) <= zero[0]:
                break
            x[shift_row] = where_positive(indefinite, next_shift(x[shift_row]), x[shift_row])
            y = newton(p, x)
        return y

    return definite_newton


@cache
def advance_function(unknown_count: int) -> Callable[..., Any]:
    """Warp function (p, x, rows of ``newton`` there, active lanes, slope and energy before the last step) -> new ones.

    The new state has the change by Newton's step, or part of the last one is undone: a step has overshot if the slope
    along it has changed its sign and kept more than half its size, or if it is not small and the energy has grown. It
    is then shortened by a Newton step along it, so that the point stays between two known slopes.
    """
    n = unknown_count
    last_row, step_row, bend_row = STRAIN_COUNT + n, FORCE + n + 1, FORCE + 2 * n + 1

    @wp.func
    def length(rows: Any, first_row: int):
        longest = magnitude(rows[first_row])
        for k in range(1, n):
            longest = larger(longest, magnitude(rows[first_row + k]))
        return longest

    @wp.func
    def along(y: Any, rows: Any, first_row: int):
        """Derivative of the energy along a step."""
        slope = y[FORCE] * rows[first_row]
        for k in range(1, n):
            slope = slope + y[FORCE + k] * rows[first_row + k]
        return slope

    @wp.func
    def newton_share(y: Any):
        """Share of Newton's step that is within the limit."""
        longest = length(y, step_row)
        share = fill(longest, 1.0)
        if lane_maximum(longest) > STEP_LIMIT:
            share = fill(longest, STEP_LIMIT) / larger(longest, fill(longest, STEP_LIMIT))
        return share

    @wp.func
    def undone_share(p: Any, x: Any, y: Any, slope: Any, before: Any):
        """Share of the last step that is undone, 0 if it has not overshot."""
        zero = fill(slope, 0.0)
        rise = along(y, x, last_row)
        back = rise / larger(y[bend_row], fill(rise, rise.dtype(1.0e-300)))
        back = smaller(larger(back, fill(rise, LEAST_UNDONE)), fill(rise, MOST_UNDONE))
        over = rise + rise.dtype(0.5) * slope
        noise = rise.dtype(1.0e-15) * (magnitude(before) + fill(rise, p.force_floor))
        grown = where_positive(length(x, last_row) - fill(rise, SMALL_STEP), y[0] - before - noise, zero)
        # without a step before there is nothing to undo
        return where_positive(-slope, where_positive(larger(over, grown), back, zero), zero)

    @wp.func
    def advance(p: Any, x: Any, y: Any, active: Any, slope: Any, before: Any):
        share = newton_share(y)
        back = undone_share(p, x, y, slope, before)
        kept = fill(back, 1.0) - back
        new_slope = where_positive(back, kept * slope, -share * along(y, y, step_row))
        new_before = where_positive(back, before, y[0])
        for k in range(n):
            last = x[last_row + k]
            step = -share * y[step_row + k]
            x[STRAIN_COUNT + k] = x[STRAIN_COUNT + k] + active * where_positive(back, -back * last, step)
            x[last_row + k] = where_positive(back, kept * last, step)
        return x, new_slope, new_before

    return advance
