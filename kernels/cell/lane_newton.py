"""Equilibrium of the unknowns of cells in all lanes at once, and the tangent there, in double precision.

The state x of the lanes is a matrix with the rows of ``state_names``.
"""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import warp as wp

from ..formula.functions import definitions
from ..formula.graph import Expression
from ..formula.writer import Constants, assignments, over_lanes
from ..lane_types import LaneTypes
from ..lanes import fill, lane_maximum, larger, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from .cell_formulas import ANSWERS, TANGENT_ENTRIES, CellFormulas, newton_names, state_names
from .iteration import FIRST_SHIFT
from .law import MAXIMUM_ITERATIONS

# A matrix may be shifted several times before a step is taken.
LARGEST_EVALUATION_COUNT = 10 * MAXIMUM_ITERATIONS
SHIFT_COUNT = 60
# Arguments of the function in C++.
STRAIN_ARGUMENTS = ("warp_strain", "weft_strain", "shear_angle")
LEAST_SHIFT = wp.constant(wp.float64(FIRST_SHIFT))


def found_names(formulas: CellFormulas) -> list[str]:
    """Rows of ``equilibrium_text``: answers, iterations, unknowns, derivatives of the unknowns by the strains."""
    unknowns = [f"unknown{k}" for k in range(formulas.unknown_count)]
    return [*ANSWERS, "iterations", *unknowns, *(follow_name(*pair) for pair in formulas.follow)]


def follow_name(unknown: int, strain: int) -> str:
    return f"unknown{unknown}_by_strain{strain}"


def equilibrium_text(formulas: CellFormulas, constants: Constants, types: LaneTypes) -> str:
    """C++ of a function (p, strains, q) -> rows of ``found_names``, all in the precision of ``types``.

    Each evaluation tells the answers, and is followed by a step of the unknowns as long as a lane is not in
    equilibrium. Lanes that are done wait for the others; what they answer does not depend on them. All of it is one
    function of C++, since a matrix of Warp is filled with zeros wherever it is declared, and copied where it is handed
    over.
    """
    n, lanes, names = formulas.unknown_count, types.lane_count, found_names(formulas)
    told = [name for name in formulas.evaluation if name not in (*ANSWERS, "active")]
    followed = {follow_name(*pair): value for pair, value in formulas.follow.items()}
    kept = [*state_names(n), *newton_names(n), *ANSWERS, *told, *followed]
    functions: set[str] = set()

    def loop(outputs: Mapping[str, Expression]) -> list[str]:
        places = {f"{name}[i]": value for name, value in outputs.items()}
        lines, called = assignments(places, constants, {name: f"{name}[i]" for name in kept}, "double")
        functions.update(called)
        return over_lanes(lines, lanes)

    given = [f"strain{k}[i] = {name}[i];" for k, name in enumerate(STRAIN_ARGUMENTS)]
    given += [f"unknown{k}[i] = q.data[{k}][i];" for k in range(n)]
    given += [f"{name}[i] = {float(name == 'active')};" for name in ("shift", *newton_names(n))]
    evaluate = loop(formulas.evaluation)
    if n:
        evaluate = [
            "for (int evaluation = 0;; ++evaluation) {",
            *evaluate,
            "bool unfinished = false;",
            f"for (int i = 0; i < {lanes}; ++i) unfinished |= active[i] > 0.0;",
            f"if (!unfinished || evaluation == {LARGEST_EVALUATION_COUNT}) break;",
            *loop(formulas.advance),
            "}",
            *loop(followed),
        ]
    told_back = [f"result.data[{row}][i] = {name}[i];" for row, name in enumerate(names)]
    return "\n".join(
        [
            *definitions(functions, "double"),
            f"double {', '.join(f'{name}[{lanes}]' for name in kept)};",
            *over_lanes(given, lanes),
            *evaluate,
            f"wp::mat_t<{len(names)}, {lanes}, wp::{types.real.__name__}> result;",
            *over_lanes(told_back, lanes),
            "return result;",
        ]
    )


@cache
def tangent_function(unknown_count: int, tangent_at: wp.Function) -> Callable[..., Any]:
    """Warp function (p, x) -> rows of ``tangent``, with a matrix of the unknowns that is positive definite."""
    shift_row, definite_row = state_names(unknown_count).index("shift"), len(TANGENT_ENTRIES)

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
