"""What a cell needs of its energy, as formulas: derivatives, Newton's step, the condensed tangent.

The functions of a cell are read once (``formula/reader.py``). Everything else is derived from them exactly, in forms
that leave out what is zero.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..formula.builtins import Vector
from ..formula.derivatives import Derivatives
from ..formula.graph import Expression, Graph
from ..formula.reader import read
from ..formula.values import Parameters, Unreadable
from .energy_cell import CellFunctions
from .iteration import STRAIN_COUNT, Balance, iteration

# Rows of the second derivatives by the strains.
TANGENT_ENTRIES = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
# Least stiffness of an unknown over the floor of the forces, and over the stiffest unknown: below, it is idle.
LEAST_STIFFNESS = 1.0e-12
# Least pivot of a matrix that counts as positive definite, over its diagonal entry.
LEAST_PIVOT = 1.0e-9
# Second derivatives by row and column, the row not before the column.
Second = Mapping[tuple[int, int], Expression]


@dataclass(frozen=True)
class StateRows:
    """Rows of the state of a block of cells: strains (stretches - 1, shear angle), and those of Newton's method."""

    unknown_count: int

    def names(self) -> tuple[str, ...]:
        n = range(self.unknown_count)
        strains = [f"strain{k}" for k in range(STRAIN_COUNT)]
        unknowns = [f"{kind}{k}" for kind in ("unknown", "change") for k in n]
        return (*strains, *unknowns, "shift", "slope", "before", "stiffest", "active", "iterations")

    def row(self, name: str) -> int:
        return self.names().index(name)


@dataclass(frozen=True)
class CellFormulas:
    """Formulas of one cell, of its parameters and of its state (``StateRows``).

    Attributes:
        unknown_count: of the cell.
        first: energy, its derivatives by the strains, crossover pressure, relative residual.
        iteration: the state after one iteration of Newton's method.
        tangent: C11, C12, C22, C13, C23, C33, and whether the unknowns' matrix was positive definite, 1 or 0.
        slopes: derivatives of the energy by strains and unknowns.
        parts: of the energy.
    """

    unknown_count: int
    first: list[Expression]
    iteration: list[Expression]
    tangent: list[Expression]
    slopes: list[Expression]
    parts: list[Expression]


def cell_formulas(fields: Sequence[tuple[str, int]], unknown_count: int, functions: CellFunctions) -> CellFormulas:
    """Formulas of a cell from its Warp functions; ``fields`` are names and lengths of its parameters.

    Raises:
        Unreadable: if a function cannot be read as a formula.
    """
    graph = Graph()
    state = {name: graph.symbol(name) for name in StateRows(unknown_count).names()}
    x = list(state.values())[: STRAIN_COUNT + unknown_count]
    members: dict[str, Any] = {}
    for name, length in fields:
        entries = [graph.symbol(f"{name}[{k}]", uniform=True) for k in range(length)]
        members[name] = entries[0] if length == 1 else Vector(entries)
    arguments = [Parameters(members), 1.0 + x[0], 1.0 + x[1], x[2], Vector(x[STRAIN_COUNT:] or [graph.number(0.0)])]

    def formula(function: Any, length: int | None = None) -> list[Expression]:
        found = read(graph, function, arguments)
        found = list(found) if isinstance(found, tuple) else [found]
        if not all(isinstance(one, Expression) for one in found) or len(found) != (length or len(found)):
            raise Unreadable(f"{function.key} does not return {length or 'numbers'}")
        return found

    along = [Derivatives(variable) for variable in x]
    part_list = formula(functions.parts) if functions.parts is not None else formula(functions.energy, 1)
    total = graph.sum((1.0, part) for part in part_list)
    gradient, pressure = functions.gradient, functions.crossover_pressure
    slopes = formula(gradient, len(x)) if gradient is not None else [derivative(total) for derivative in along]
    second = {(i, j): along[j](slopes[i]) for i in range(len(x)) for j in range(i + 1)}
    crossover = formula(pressure, 1) if pressure is not None else [graph.number(0.0)]
    inner = Matrix(graph, unknown_count, second, state["shift"])
    balance = Balance(graph, slopes, state["stiffest"])
    return CellFormulas(
        unknown_count,
        first=[total, *slopes[:STRAIN_COUNT], *crossover, balance.residual],
        iteration=iteration(total, slopes, second, inner, state),
        tangent=[*condensed(graph, unknown_count, second, inner), graph.choice(inner.definite, *numbers(graph, 1, 0))],
        slopes=slopes,
        parts=part_list,
    )


def numbers(graph: Graph, *values: float) -> list[Expression]:
    return [graph.number(value) for value in values]


class Matrix:
    """The second derivatives by the unknowns, H + shift diag |H|, as factors L D L^T.

    An unknown without any stiffness, such as the strain of a float of zero length, gets that of the stiffest. Unknowns
    that few others touch are eliminated first, which keeps zeros zero.
    """

    def __init__(self, graph: Graph, size: int, second: Second, shift: Expression):
        self.size = size
        entry = {
            (i, j): second[STRAIN_COUNT + max(i, j), STRAIN_COUNT + min(i, j)] for i in range(size) for j in range(size)
        }
        touched = [sum(not entry[i, j].is_equal(0.0) for j in range(size)) for i in range(size)]
        self.order = sorted(range(size), key=lambda k: touched[k])
        own = {k: graph.magnitude(entry[k, k]) for k in range(size)}
        largest = LEAST_STIFFNESS * graph.symbol("force_floor", uniform=True)
        for k in range(size):
            largest = graph.larger(own[k], largest)
        self.lower: dict[tuple[int, int], Expression] = {}
        self.inverse: dict[int, Expression] = {}
        column: dict[tuple[int, int], Expression] = {}
        conditions = []
        for place, k in enumerate(self.order):
            before = self.order[:place]
            idle = graph.comparison("<", own[k], 1.0e-12 * largest)
            scale = graph.choice(idle, largest, own[k])
            pivot = entry[k, k] + shift * own[k]
            for j in before:
                pivot = pivot - column[k, j] * self.lower[k, j]
            pivot = graph.choice(idle, scale, pivot)
            good = graph.comparison(">", pivot, LEAST_PIVOT * scale)
            conditions.append(good)
            self.inverse[k] = 1.0 / graph.choice(good, pivot, scale)
            for i in self.order[place + 1 :]:
                rest = entry[i, k]
                for j in before:
                    rest = rest - column[i, j] * self.lower[k, j]
                column[i, k] = rest
                self.lower[i, k] = rest * self.inverse[k]
        self.definite = graph.combination("all", conditions)

    def solved(self, right: Sequence[Expression]) -> list[Expression]:
        """The matrix' inverse times a vector."""
        found = dict(enumerate(right))
        for place, k in enumerate(self.order):
            for j in self.order[:place]:
                found[k] = found[k] - self.lower[k, j] * found[j]
        for k in found:
            found[k] = found[k] * self.inverse[k]
        for place, k in reversed(list(enumerate(self.order))):
            for j in self.order[place + 1 :]:
                found[k] = found[k] - self.lower[j, k] * found[j]
        return [found[k] for k in range(self.size)]


def condensed(graph: Graph, unknown_count: int, second: Second, inner: Matrix) -> list[Expression]:
    """psi_ss - psi_sq psi_qq^-1 psi_qs, the six entries of ``TANGENT_ENTRIES``."""
    mixed = [[second[STRAIN_COUNT + k, i] for k in range(unknown_count)] for i in range(STRAIN_COUNT)]
    yielding = [inner.solved(column) for column in mixed]
    entries = []
    for i, j in TANGENT_ENTRIES:
        yielded = graph.sum((1.0, a * b) for a, b in zip(mixed[i], yielding[j], strict=True))
        entries.append(second[max(i, j), min(i, j)] - yielded)
    return entries
