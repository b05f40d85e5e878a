"""One iteration of a safeguarded Newton method for the unknowns of a cell, as formulas (docs/theory.md, section 2).

Everything is decided without branches: a lane whose residual is within the tolerance is held, one whose matrix is not
positive definite stays where it is and comes back with a shift.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from ..formula.graph import Expression, Graph

# Largest change of an unknown in one step, and largest change that is accepted without a look at the energy.
STEP_LIMIT = 0.25
SMALL_STEP = 1.0e-3
# Shares of a step that overshoots that are undone.
LEAST_UNDONE, MOST_UNDONE = 1.0 / 16.0, 15.0 / 16.0
# Shift of a matrix that is not positive definite: this, then twice as much each time.
FIRST_SHIFT = 1.0e-3
STRAIN_COUNT = 3


class Balance:
    """How far the unknowns are from equilibrium.

    The residual is the largest |dpsi/dq| over the size of the forces, a floor, and the rounding error of the stiffest
    unknown. ``active`` is 1 where a lane that was active is not in equilibrium yet.
    """

    def __init__(
        self,
        graph: Graph,
        slopes: Sequence[Expression],
        second: Mapping[tuple[int, int], Expression],
        state: Mapping[str, Expression],
    ):
        forces = slopes[STRAIN_COUNT:]
        stiffest = graph.number(0.0)
        for k, row in enumerate(range(STRAIN_COUNT, len(slopes))):
            own = graph.magnitude(second[row, row]) * (1.0 + graph.magnitude(state[f"unknown{k}"]))
            stiffest = graph.larger(own, stiffest)
        tolerance, floor, resolution = (
            graph.symbol(name, uniform=True) for name in ("tolerance", "force_floor", "resolution")
        )
        worst = largest(graph, forces)
        size = floor + resolution * stiffest
        for slope in slopes[:STRAIN_COUNT]:
            size = size + graph.magnitude(slope)
        # a maximum drops what is not a number, a sum does not
        total = graph.sum((1.0, slope) for slope in (forces or slopes))
        known = graph.comparison("==", total, total)
        self.residual = graph.choice(known, worst / size, total)
        # the residual that is reported is a quotient, with another rounding
        unsettled = [known, graph.comparison(">", worst, 0.999 * tolerance * size)]
        was_active = graph.comparison(">", state["active"], graph.number(0.0))
        still = graph.combination("all", [was_active, *unsettled])
        self.active = graph.choice(still, graph.number(1.0), graph.number(0.0))


def largest(graph: Graph, values: Sequence[Expression]) -> Expression:
    """Largest magnitude; 0 of none."""
    result = graph.number(0.0)
    for value in values:
        result = graph.larger(graph.magnitude(value), result)
    return result


def iteration(
    force: Sequence[Expression],
    second: Mapping[tuple[int, int], Expression],
    matrix: Any,
    state: Mapping[str, Expression],
) -> dict[str, Expression]:
    """The state after one iteration, by name.

    A step has overshot if the slope along it has changed its sign and kept more than half its size, or if it is not
    small and the energy has grown. It is then partly undone, by a Newton step along it, so that the point stays between
    two known slopes. All other steps are Newton's, shortened to the limit.

    Args:
        force: derivatives of the energy by the unknowns, at this state.
        second: the second derivatives.
        matrix: of the unknowns, shifted: ``solved`` and ``definite``.
        state: its symbols by name.
    """
    if not force:
        return {}
    graph, n, energy = state["shift"].graph, len(force), state["shift"].graph.symbol("energy")
    unknowns, changes = ([state[f"{kind}{k}"] for k in range(n)] for kind in ("unknown", "change"))
    one, zero = graph.number(1.0), graph.number(0.0)
    active = graph.comparison(">", state["active"], zero)

    share = undone_share(graph, energy, force, second, state)
    undo = graph.comparison(">", share, zero)
    kept = 1.0 - share
    step = matrix.solved(force)
    limit = STEP_LIMIT / graph.larger(largest(graph, step), graph.number(STEP_LIMIT))
    ready = graph.combination("any", [undo, matrix.definite])
    moving = graph.combination("all", [active, ready])

    def held(new: Expression, old: Expression) -> Expression:
        return graph.choice(moving, new, old)

    newton = [-(limit * part) for part in step]
    slope = dot(graph, force, newton)
    moves = [graph.choice(undo, -(share * c), d) for c, d in zip(changes, newton, strict=True)]
    new_unknowns = [held(q + move, q) for q, move in zip(unknowns, moves, strict=True)]
    new_changes = [held(graph.choice(undo, kept * c, d), c) for c, d in zip(changes, newton, strict=True)]
    waiting = graph.combination("all", [active, graph.negation(ready)])
    shift = held(smaller_shift(state["shift"]), zero)
    return {
        **{f"unknown{k}": value for k, value in enumerate(new_unknowns)},
        **{f"change{k}": value for k, value in enumerate(new_changes)},
        "shift": graph.choice(waiting, larger_shift(state["shift"]), shift),
        "slope": held(graph.choice(undo, kept * state["slope"], slope), state["slope"]),
        "before": held(graph.choice(undo, state["before"], energy), state["before"]),
        "iterations": state["iterations"] + graph.choice(moving, one, zero),
    }


def larger_shift(shift: Expression) -> Expression:
    """For the next try to make a matrix positive definite."""
    return shift.graph.larger(2.0 * shift, shift.graph.number(FIRST_SHIFT))


def smaller_shift(shift: Expression) -> Expression:
    """For the next state: where the matrix stays indefinite, the search goes on near the last shift."""
    graph, left = shift.graph, 0.25 * shift
    return graph.choice(graph.comparison(">=", left, graph.number(FIRST_SHIFT)), left, graph.number(0.0))


def undone_share(
    graph: Graph,
    energy: Expression,
    force: Sequence[Expression],
    second: Mapping[tuple[int, int], Expression],
    state: Mapping[str, Expression],
) -> Expression:
    """Share of the last step that is undone, 0 if it has not overshot."""
    n = len(force)
    changes = [state[f"change{k}"] for k in range(n)]
    rise = dot(graph, force, changes)
    bend = graph.sum(
        (1.0 if i == j else 2.0, second[STRAIN_COUNT + i, STRAIN_COUNT + j] * changes[i] * changes[j])
        for i in range(n)
        for j in range(i + 1)
    )
    share = rise / graph.larger(bend, graph.number(1.0e-300))
    share = graph.smaller(graph.larger(share, graph.number(LEAST_UNDONE)), graph.number(MOST_UNDONE))
    noise = 1.0e-15 * (graph.magnitude(state["before"]) + graph.symbol("force_floor", uniform=True))
    zero = graph.number(0.0)
    over = graph.comparison(">", rise + 0.5 * state["slope"], zero)
    is_long = graph.comparison(">", largest(graph, changes), graph.number(SMALL_STEP))
    grown = graph.combination("all", [is_long, graph.comparison(">", energy, state["before"] + noise)])
    # without a step before there is nothing to undo
    stepped = graph.comparison("<", state["slope"], zero)
    return graph.choice(graph.combination("all", [stepped, graph.combination("any", [over, grown])]), share, zero)


def dot(graph: Graph, first: Sequence[Expression], second: Sequence[Expression]) -> Expression:
    """Sum of the products of two rows of expressions."""
    return graph.sum((1.0, a * b) for a, b in zip(first, second, strict=True))
