"""Equilibrium of the unknowns of cells in all lanes at once, and the tangent there, in double precision.

The state x of the lanes is a matrix with the rows of ``StateRows``.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import warp as wp

from ..lanes import fill, lane_maximum, larger, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from .cell_formulas import STRAIN_COUNT, TANGENT_ENTRIES, StateRows
from .iteration import FIRST_SHIFT
from .law import MAXIMUM_ITERATIONS

# A matrix may be shifted several times before a step is taken.
LARGEST_EVALUATION_COUNT = 10 * MAXIMUM_ITERATIONS
SHIFT_COUNT = 60
LEAST_SHIFT = wp.constant(wp.float64(FIRST_SHIFT))
# Rows of ``first``: energy, its derivatives by the strains, crossover pressure, residual.
ENERGY, SLOPE, PRESSURE, RESIDUAL = 0, 1, 1 + STRAIN_COUNT, 2 + STRAIN_COUNT


@cache
def equilibrium_function(unknown_count: int, first: wp.Function, iterate: wp.Function) -> Callable[..., Any]:
    """Warp function (p, x) -> (x, rows of ``first`` there).

    A first step is followed by ``first`` alone: mostly it is the last. Lanes that are done wait for the others; what
    they answer does not depend on them.
    """
    active_row = StateRows(unknown_count).row("active")

    @wp.func
    def without_unknowns(p: Any, start: Any):
        return start, first(p, start)

    if unknown_count == 0:
        return without_unknowns

    @wp.func
    def rows_like(like: Any):
        return wp.matrix(shape=(wp.static(RESIDUAL + 1), len(like)), dtype=wp.float64)

    @wp.func
    def equilibrium(p: Any, start: Any):
        x = start
        x[active_row] = fill(x[active_row], 1.0)
        y = rows_like(x[0])
        for evaluation in range(LARGEST_EVALUATION_COUNT):
            x = iterate(p, x)
            unfinished = lane_maximum(x[active_row])
            if evaluation == 0 or unfinished <= unfinished.dtype(0.0) or evaluation == LARGEST_EVALUATION_COUNT - 1:
                y = first(p, x)
                # a NaN is not above the tolerance and ends the iteration too
                beyond = where_positive(x[active_row], y[RESIDUAL] - fill(y[RESIDUAL], p.tolerance), -x[active_row])
                if lane_maximum(beyond) <= beyond.dtype(0.0):
                    break
        return x, y

    return equilibrium


@cache
def tangent_function(unknown_count: int, tangent_at: wp.Function) -> Callable[..., Any]:
    """Warp function (p, x) -> rows of ``tangent``, with a matrix of the unknowns that is positive definite."""
    shift_row, definite_row = StateRows(unknown_count).row("shift"), len(TANGENT_ENTRIES)

    @wp.func
    def definite_tangent(p: Any, x: Any):
        zero = fill(x[0], 0.0)
        x[shift_row] = zero
        c = tangent_at(p, x)
        for _attempt in range(SHIFT_COUNT):
            indefinite = where_positive(c[definite_row], zero, fill(zero, 1.0))
            if lane_maximum(indefinite) <= zero[0]:
                break
            shift = x[shift_row]
            x[shift_row] = where_positive(indefinite, larger(shift + shift, fill(shift, LEAST_SHIFT)), shift)
            c = tangent_at(p, x)
        return c

    return definite_tangent
