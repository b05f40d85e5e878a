"""Which parameters data can tell apart, and the reduced set that they can."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .fit import Fit, Problem, condition, inverse_square, solve

# A parameter whose standard deviation exceeds this share of it is not determined; nor are sets whose condition number
# exceeds the other: small changes of the data then move them against each other.
LARGEST_DEVIATION = 0.3
LARGEST_CONDITION = 1.0e4
# Entries of a direction that are named.
LEAST_ENTRY = 0.25


@dataclass(frozen=True)
class Direction:
    """A combination of parameters that the data hardly see: exponents of a product, or shares of a sum.

    Attributes:
        entries: name and share, the largest first.
        deviation: standard deviation along it, in inner coordinates: 1 is a factor of e.
    """

    entries: tuple[tuple[str, float], ...]
    deviation: float


@dataclass(frozen=True)
class Reduced:
    """A fit, and what was held for it.

    Attributes:
        fit: of what the data can tell apart, or of everything if nothing was held.
        whole: the fit of everything that was asked for.
        held: names that the data cannot tell, in the order in which they were held.
        weak: directions of ``whole`` that the data cannot tell.
    """

    fit: Fit
    whole: Fit
    held: tuple[str, ...]
    weak: tuple[Direction, ...]


def fit_reduced(
    problem: Problem,
    *,
    held: Sequence[str] = (),
    keep_all: bool = False,
    starts: int = 1,
    seed: int = 0,
    held_uncertainty: float = 0.0,
) -> Reduced:
    """Fit everything, then hold at their start what the data cannot tell, and fit the rest.

    Args:
        problem: to solve.
        held: names that are not to be fitted at all.
        keep_all: only say what the data cannot tell.
        starts, seed, held_uncertainty: see ``solve``.
    """
    whole = solve(problem, held=held, starts=starts, seed=seed, held_uncertainty=held_uncertainty)
    weak = weak_directions(whole)
    dropped: list[str] = []
    fit = whole
    # one after the other: the values of a whole fit may be so absurd that its derivatives mislead
    while name := least_determined(fit):
        dropped.append(name)
        fit = solve(problem, held=[*held, *dropped], starts=1, seed=seed, held_uncertainty=held_uncertainty)
    if not dropped or keep_all:
        return Reduced(whole, whole, tuple(dropped), weak)
    if starts > 1:
        fit = solve(problem, held=[*held, *dropped], starts=starts, seed=seed, held_uncertainty=held_uncertainty)
    return Reduced(fit, whole, tuple(dropped), weak)


def least_determined(fit: Fit) -> str:
    """The parameter to hold next; "" if the data tell all apart, or only one is left.

    Of those that are not determined it is the one of the lowest rank, of equal ranks the least determined.
    """
    unknowns = fit.problem.unknowns
    chosen = [int(k) for k in np.flatnonzero(fit.is_free)]
    if len(chosen) < 2:
        return ""
    j = fit.jacobian[:, chosen]
    deviation = np.sqrt(np.diag(inverse_square(j))) * _scale(fit, chosen)
    loose = deviation > LARGEST_DEVIATION
    if condition(j) > LARGEST_CONDITION:
        loose |= np.abs(np.linalg.svd(j, full_matrices=False)[2][-1]) >= LEAST_ENTRY
    candidates = [int(row) for row in np.flatnonzero(loose) if unknowns[chosen[row]].is_log]
    if not candidates:
        return ""
    worst = min(candidates, key=lambda row: (unknowns[chosen[row]].rank, -deviation[row]))
    return unknowns[chosen[worst]].name


def _scale(fit: Fit, chosen: Sequence[int]) -> np.ndarray:
    """Residuals larger than the stated scatter widen everything."""
    count = max(len(fit.residual) - len(chosen), 1)
    return np.full(len(chosen), max(1.0, float(np.sqrt(fit.residual @ fit.residual / count))))


def weak_directions(fit: Fit) -> tuple[Direction, ...]:
    """Directions of the fitted logarithms whose standard deviation exceeds the limit, the weakest first."""
    unknowns = fit.problem.unknowns
    chosen = [int(k) for k in np.flatnonzero(fit.is_free) if unknowns[k].is_log]
    if len(chosen) < 2:
        return ()
    _, values, rows = np.linalg.svd(fit.jacobian[:, chosen], full_matrices=False)
    found = []
    for value, row in zip(values[::-1], rows[::-1], strict=True):
        deviation = float(_scale(fit, chosen)[0] / value) if value > 0.0 else np.inf
        if deviation <= LARGEST_DEVIATION and values[0] <= LARGEST_CONDITION * value:
            continue
        order = np.argsort(-np.abs(row))
        entries = tuple((unknowns[chosen[k]].name, float(row[k])) for k in order if abs(row[k]) >= LEAST_ENTRY)
        found.append(Direction(entries, deviation))
    return tuple(found)
