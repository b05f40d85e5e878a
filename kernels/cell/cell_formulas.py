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
# What a cell answers.
ANSWERS = ("energy", "warp_force", "weft_force", "moment", "pressure", "residual")
# Second derivatives by row and column, the row not before the column.
Second = Mapping[tuple[int, int], Expression]


def state_names(unknown_count: int) -> list[str]:
    """Strains (stretches - 1, shear angle), unknowns, and the shift of the unknowns' matrix."""
    return [*(f"strain{k}" for k in range(STRAIN_COUNT)), *(f"unknown{k}" for k in range(unknown_count)), "shift"]


def newton_names(unknown_count: int) -> list[str]:
    """What Newton's method keeps from one evaluation to the next, besides unknowns and shift."""
    return [*(f"change{k}" for k in range(unknown_count)), "slope", "before", "active", "iterations"]


@dataclass(frozen=True)
class CellFormulas:
    """Formulas of one cell, of its parameters and its state (``state_names``).

    Newton's method goes from ``evaluation`` to ``advance`` until no lane is active. The latter needs only what the
    former tells, as symbols, and is left out in the end.

    Attributes:
        unknown_count: of the cell.
        evaluation: by name: ``ANSWERS``; whether it is not in equilibrium ("active", 1 or 0); and what varies of the
            forces on the unknowns ("force0") and of the second derivatives by them ("second3_0").
        advance: unknowns, shift and ``newton_names`` after a step, by name.
        follow: derivatives of unknowns in equilibrium by strains that are not zero, by the numbers of both.
        tangent: C11, C12, C22, C13, C23, C33, and whether the unknowns' matrix was positive definite, 1 or 0.
        slopes: derivatives of the energy by strains and unknowns.
        parts: of the energy.
    """

    unknown_count: int
    evaluation: dict[str, Expression]
    advance: dict[str, Expression]
    follow: dict[tuple[int, int], Expression]
    tangent: list[Expression]
    slopes: list[Expression]
    parts: list[Expression]


def cell_formulas(fields: Sequence[tuple[str, int]], unknown_count: int, functions: CellFunctions) -> CellFormulas:
    """Formulas of a cell from its Warp functions; ``fields`` are names and lengths of its parameters.

    Raises:
        Unreadable: if a function cannot be read as a formula.
    """
    graph = Graph()
    state = {name: graph.symbol(name) for name in (*state_names(unknown_count), *newton_names(unknown_count))}
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
    balance = Balance(graph, slopes, second, state)
    answers = (total, *slopes[:STRAIN_COUNT], *crossover, balance.residual)
    told = Told(graph, slopes, second, unknown_count)
    return CellFormulas(
        unknown_count,
        evaluation=dict(zip(ANSWERS, answers, strict=True)) | {"active": balance.active} | told.outputs,
        advance=iteration(told.forces, told.second, Matrix(graph, unknown_count, told.second, state["shift"]), state),
        follow=following(graph, unknown_count, told.second),
        tangent=[*condensed(graph, unknown_count, second, inner), graph.choice(inner.definite, *numbers(graph, 1, 0))],
        slopes=slopes,
        parts=part_list,
    )


def numbers(graph: Graph, *values: float) -> list[Expression]:
    """Numbers as constants of a graph."""
    return [graph.number(value) for value in values]


class Told:
    """Forces on the unknowns and second derivatives by them, as an evaluation tells them: as symbols where they vary.

    Attributes:
        outputs: those that vary, by the names of the symbols.
        forces: on the unknowns.
        second: the second derivatives by an unknown and a strain or unknown.
    """

    def __init__(self, graph: Graph, slopes: Sequence[Expression], second: Second, unknown_count: int):
        self.outputs: dict[str, Expression] = {}
        rows = range(STRAIN_COUNT, STRAIN_COUNT + unknown_count)
        self.forces = [self._symbol(graph, f"force{i - STRAIN_COUNT}", slopes[i]) for i in rows]
        self.second = {(i, j): self._symbol(graph, f"second{i}_{j}", second[i, j]) for i in rows for j in range(i + 1)}

    def _symbol(self, graph: Graph, name: str, value: Expression) -> Expression:
        if value.uniform:
            return value
        self.outputs[name] = value
        return graph.symbol(name)


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


def following(graph: Graph, unknown_count: int, second: Second) -> dict[tuple[int, int], Expression]:
    """-psi_qq^-1 psi_qs: derivatives by (unknown, strain), without those that are zero."""
    inner = Matrix(graph, unknown_count, second, graph.number(0.0))
    entries = {}
    for i in range(STRAIN_COUNT):
        moved = inner.solved([-second[STRAIN_COUNT + k, i] for k in range(unknown_count)])
        entries |= {(k, i): entry for k, entry in enumerate(moved) if not entry.is_equal(0.0)}
    return dict(sorted(entries.items()))


def condensed(graph: Graph, unknown_count: int, second: Second, inner: Matrix) -> list[Expression]:
    """psi_ss - psi_sq psi_qq^-1 psi_qs, the six entries of ``TANGENT_ENTRIES``."""
    mixed = [[second[STRAIN_COUNT + k, i] for k in range(unknown_count)] for i in range(STRAIN_COUNT)]
    yielding = [inner.solved(column) for column in mixed]
    entries = []
    for i, j in TANGENT_ENTRIES:
        yielded = graph.sum((1.0, a * b) for a, b in zip(mixed[i], yielding[j], strict=True))
        entries.append(second[max(i, j), min(i, j)] - yielded)
    return entries
