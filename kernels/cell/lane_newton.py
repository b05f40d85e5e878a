"""Equilibrium of the unknowns of cells in all lanes at once, and the tangent there, in double precision.

The state x of the lanes is a matrix with the rows of ``state_names``. This serves cells whose energy can be read as a
formula (``energy_lanes``), with exact derivatives; ``newton`` serves the others.
"""

from collections.abc import Callable, Mapping, Sequence
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
LEAST_SHIFT = wp.constant(wp.float64(FIRST_SHIFT))
# Arguments of the functions in C++.
STRAIN_ARGUMENTS = ("warp_strain", "weft_strain", "shear_angle")
# Rows of ``stiffness_text``.
STIFFNESS_ROWS = ("c11", "c12", "c22", "c13", "c23", "c33", "warp_force", "weft_force", "moment", "pressure")


def found_names(formulas: CellFormulas) -> list[str]:
    """Rows of ``equilibrium_text``: answers, iterations, unknowns, derivatives of the unknowns by the strains."""
    unknowns = [f"unknown{k}" for k in range(formulas.unknown_count)]
    return [*ANSWERS, "iterations", *unknowns, *(follow_name(*pair) for pair in formulas.follow)]


def follow_name(unknown: int, strain: int) -> str:
    """Name of the derivative of an unknown by a strain, both by their numbers."""
    return f"unknown{unknown}_by_strain{strain}"


class LoopWriter:
    """Loops over the lanes of a function in C++ with arguments (p, strains, q), whose values are arrays by name.

    A matrix of Warp would be filled with zeros wherever it is declared, and copied where it is handed over.
    """

    def __init__(self, formulas: CellFormulas, constants: Constants, types: LaneTypes):
        self.formulas, self.constants, self.types = formulas, constants, types
        self.lanes, self.functions = types.lane_count, set[str]()
        self.names = [*state_names(formulas.unknown_count), *newton_names(formulas.unknown_count)]

    def loop(self, outputs: Mapping[str, Expression]) -> list[str]:
        """All outputs, then written into the arrays of their names."""
        self.names += [name for name in outputs if name not in self.names]
        places = {f"{name}[i]": value for name, value in outputs.items()}
        read = {name: f"{name}[i]" for name in self.names}
        lines, called = assignments(places, self.constants, read, "double")
        self.functions.update(called)
        return over_lanes(lines, self.lanes)

    def equilibrium(self, evaluation: Mapping[str, Expression]) -> list[str]:
        """Evaluations, each followed by a step of the unknowns as long as a lane is not in equilibrium.

        Lanes that are done wait for the others; what they answer does not depend on them.
        """
        evaluate = self.loop(evaluation)
        if self.formulas.unknown_count == 0:
            return evaluate
        return [
            "for (int evaluation = 0;; ++evaluation) {",
            *evaluate,
            "bool unfinished = false;",
            f"for (int i = 0; i < {self.lanes}; ++i) unfinished |= active[i] > 0.0;",
            f"if (!unfinished || evaluation == {LARGEST_EVALUATION_COUNT}) break;",
            *self.loop(self.formulas.advance),
            "}",
        ]

    def function(self, body: Sequence[str], rows: Sequence[str]) -> str:
        """The whole function, which returns the rows of these names in the precision of the lanes."""
        n, lanes = self.formulas.unknown_count, self.lanes
        given = [f"strain{k}[i] = {name}[i];" for k, name in enumerate(STRAIN_ARGUMENTS)]
        given += [f"unknown{k}[i] = q.data[{k}][i];" for k in range(n)]
        given += [f"{name}[i] = {float(name == 'active')};" for name in ("shift", *newton_names(n))]
        lines = [
            *definitions(self.functions, "double"),
            f"double {', '.join(f'{name}[{lanes}]' for name in self.names)};",
            *over_lanes(given, lanes),
            *body,
            f"wp::mat_t<{len(rows)}, {lanes}, wp::{self.types.real.__name__}> result;",
            *over_lanes([f"result.data[{row}][i] = {name}[i];" for row, name in enumerate(rows)], lanes),
            "return result;",
        ]
        return "\n".join(lines)


def equilibrium_text(formulas: CellFormulas, constants: Constants, types: LaneTypes) -> str:
    """C++ of a function (p, strains, q) -> rows of ``found_names``, all in the precision of ``types``."""
    writer = LoopWriter(formulas, constants, types)
    body = writer.equilibrium(formulas.evaluation)
    if formulas.follow:
        body += writer.loop({follow_name(*pair): value for pair, value in formulas.follow.items()})
    return writer.function(body, found_names(formulas))


def stiffness_text(formulas: CellFormulas, constants: Constants, types: LaneTypes) -> str:
    """C++ of a function (p, strains, q) -> ``STIFFNESS_ROWS`` in equilibrium, all in the precision of ``types``.

    The tangent is condensed with a matrix of the unknowns that is positive definite.
    """
    writer = LoopWriter(formulas, constants, types)
    body = writer.equilibrium(formulas.evaluation)
    entries = STIFFNESS_ROWS[: len(TANGENT_ENTRIES)]
    condense = writer.loop(dict(zip((*entries, "definite"), formulas.tangent, strict=True)))
    shifted = f"shift[i] + shift[i] > {FIRST_SHIFT!r} ? shift[i] + shift[i] : {FIRST_SHIFT!r}"
    body += [
        f"for (int i = 0; i < {types.lane_count}; ++i) shift[i] = 0.0;",
        "for (int attempt = 0;; ++attempt) {",
        *condense,
        "bool indefinite = false;",
        f"for (int i = 0; i < {types.lane_count}; ++i) indefinite |= definite[i] <= 0.0;",
        f"if (!indefinite || attempt == {SHIFT_COUNT}) break;",
        *over_lanes([f"shift[i] = definite[i] > 0.0 ? shift[i] : ({shifted});"], types.lane_count),
        "}",
    ]
    return writer.function(body, STIFFNESS_ROWS)


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
