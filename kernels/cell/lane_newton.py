"""Equilibrium of an energy's unknowns in all lanes at once, by a safeguarded Newton method, in double precision.

The state x of the lanes is a matrix with a row for every strain, every unknown, and the shift of Newton's matrix.
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
TRIAL_COUNT = 30
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
    """Warp function (p, x) -> (x, rows of ``first`` there, relative residual, iterations)."""
    n = unknown_count
    row_count = FORCE + n + 1
    step_row, stiffness_row, definite_row = FORCE + n, FORCE + 2 * n, FORCE + 2 * n + 1
    relative_residual = residual_function(n)
    descend = descent_function(n, first)

    @wp.func
    def empty_rows(like: Any):
        return wp.matrix(shape=(row_count, len(like)), dtype=wp.float64)

    @wp.func
    def definite_newton(p: Any, x: Any, active: Any):
        """Rows of ``newton`` with the first shift that makes the matrix positive definite: 0, 1e-3, 2e-3, 4e-3, ..."""
        zero = fill(active, 0.0)
        x[STRAIN_COUNT + n] = zero
        y = newton(p, x)
        for _attempt in range(SHIFT_COUNT):
            indefinite = where_positive(y[definite_row], zero, active)
            if lane_maximum(indefinite) <= zero[0]:
                break
            shift = x[STRAIN_COUNT + n]
            x[STRAIN_COUNT + n] = where_positive(indefinite, next_shift(shift), shift)
            y = newton(p, x)
        return y

    @wp.func
    def newton_step(y: Any, active: Any):
        """Newton's step where a lane is active, shortened to the limit, and its largest entry."""
        longest = magnitude(y[step_row])
        for k in range(1, n):
            longest = larger(longest, magnitude(y[step_row + k]))
        share = active
        if lane_maximum(longest) > STEP_LIMIT:
            limit = fill(longest, STEP_LIMIT)
            share = active * (limit / larger(longest, limit))
        step = wp.matrix(shape=(n, len(active)), dtype=wp.float64)
        for k in range(n):
            step[k] = where_positive(active, share * y[step_row + k], share)
        return step, share * longest

    @wp.func
    def equilibrium(p: Any, start: Any):
        x = start
        zero = fill(x[0], 0.0)
        active = fill(zero, 1.0)
        iterations = zero
        residual = active
        y = empty_rows(x[0])
        for _iteration in range(MAXIMUM_ITERATIONS):
            z = definite_newton(p, x, active)
            stiffest = z[stiffness_row]
            tolerance = fill(zero, p.tolerance)
            needed = relative_residual(p, z, stiffest) - tolerance
            iterations = iterations + where_positive(needed, active, zero)
            step, longest = newton_step(z, active)
            x, y, reached = descend(p, x, z, stiffest, step, longest)
            residual = where_positive(active, reached, residual)
            # a NaN is not above the tolerance and ends the loop too
            active = where_positive(residual - tolerance, active, zero)
            if lane_maximum(active) <= zero[0]:
                break
        return x, y, residual, iterations

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
def descent_function(unknown_count: int, first: wp.Function) -> Callable[..., Any]:
    """Warp function (p, x, rows of ``newton`` there, stiffest, step, its largest entry) -> (x after it, rows of
    ``first``, residual)."""
    n = unknown_count
    relative_residual = residual_function(n)

    @wp.func
    def moved(x: Any, step: Any, share: Any):
        for k in range(n):
            x[STRAIN_COUNT + k] = x[STRAIN_COUNT + k] - share * step[k]
        return x

    @wp.func
    def along(y: Any, step: Any):
        """Directional derivative of the energy along the step's opposite."""
        slope = y[FORCE] * step[0]
        for k in range(1, n):
            slope = slope + y[FORCE + k] * step[k]
        return slope

    @wp.func
    def descend(p: Any, x: Any, before: Any, stiffest: Any, step: Any, longest: Any):
        """Take the step, shortened while it overshoots or, unless it is small, the energy grows.

        It overshoots if the slope along it has changed sign and kept more than half its size; in both cases the search
        continues until the slope has lost half its size.
        """
        zero = fill(longest, 0.0)
        half = longest.dtype(0.5)
        slope = along(before, step)
        share = fill(longest, 1.0)
        low = zero
        high = zero
        fall = slope
        z = moved(x, step, share)
        y = first(p, z)
        residual = relative_residual(p, y, stiffest)
        energy = before[0] + longest.dtype(1.0e-15) * (magnitude(before[0]) + fill(zero, p.force_floor))
        for trial in range(TRIAL_COUNT):
            # positive beyond the minimum along the step
            rise = -along(y, step)
            grown = where_positive(share * longest - fill(zero, SMALL_STEP), y[0] - energy, zero)
            unsettled = residual - fill(zero, p.tolerance)
            over = where_positive(unsettled, larger(rise - half * slope, grown), zero)
            under = where_positive(high, where_positive(unsettled, -half * slope - rise, zero), zero)
            if lane_maximum(larger(over, under)) <= zero[0]:
                break
            # between two known points, alternate secant and bisection: at a kink the secant alone converges slowly
            part = fill(zero, half)
            if trial % 2 == 0:
                secant = smaller(larger(fall / (fall + rise), fill(zero, 0.1)), fill(zero, 0.9))
                part = where_positive(over, where_positive(rise, secant, part), part)
            high = where_positive(over, share, high)
            low = where_positive(over, low, where_positive(under, share, low))
            fall = where_positive(over, fall, where_positive(under, -rise, fall))
            searching = larger(over, under)
            share = where_positive(searching, low + part * (high - low), share)
            z = moved(x, step, share)
            y = first(p, z)
            residual = relative_residual(p, y, stiffest)
        return z, y, residual

    return descend
