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
    protected: Sequence[str] = (),
    starts: int = 1,
    seed: int = 0,
    held_uncertainty: float = 0.0,
) -> Reduced:
    """Fit everything, then hold at their start what the data cannot tell, and fit the rest.

    Args:
        problem: to solve.
        held: names that are not to be fitted at all.
        keep_all: only say what the data cannot tell.
        protected: names that are never held.
        starts, seed, held_uncertainty: see ``solve``.
    """
    whole = solve(problem, held=held, starts=starts, seed=seed, held_uncertainty=held_uncertainty)
    dropped = undetermined(whole, protected)
    weak = weak_directions(whole)
    if not dropped or keep_all:
        return Reduced(whole, whole, dropped, weak)
    fit = solve(
        problem, held=[*held, *dropped], starts=max(1, starts // 2), seed=seed, held_uncertainty=held_uncertainty
    )
    # away from the absurd values of the whole fit more may turn out to be undetermined
    for _ in range(len(problem.unknowns)):
        more = undetermined(fit, protected)
        if not more or len(fit.chosen) <= 1:
            break
        dropped = (*dropped, *more)
        fit = solve(problem, held=[*held, *dropped], starts=1, seed=seed, held_uncertainty=held_uncertainty)
    return Reduced(fit, whole, dropped, weak)


def undetermined(fit: Fit, protected: Sequence[str] = ()) -> tuple[str, ...]:
    """Names to hold, one after the other the least determined, until the data tell all others apart."""
    unknowns = fit.problem.unknowns
    chosen = [int(k) for k in np.flatnonzero(fit.is_free)]
    is_log = np.array([unknown.is_log for unknown in unknowns])
    names: list[str] = []
    while len(chosen) > 1:
        j = fit.jacobian[:, chosen]
        deviation = np.sqrt(np.diag(inverse_square(j))) * _scale(fit, chosen)
        free = np.array([is_log[k] and unknowns[k].name not in protected for k in chosen])
        if not free.any():
            break
        deviation = np.where(free, deviation, 0.0)
        worst = int(np.argmax(deviation))
        if deviation[worst] <= LARGEST_DEVIATION and condition(j) <= LARGEST_CONDITION:
            break
        names.append(unknowns[chosen.pop(worst)].name)
    return tuple(names)


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
