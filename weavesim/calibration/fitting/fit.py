"""Bounded least squares from several starts, with intervals that come from the scatter of repeats.

Unknowns are fitted in inner coordinates: logarithms of what must be positive, the rest over its size. Derivatives are
central differences of all unknowns at once, for which a model gets all sets of values in one call.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

# Coverage of the intervals, and the least number of repeats whose scatter gives them.
LEVEL = 0.95
LEAST_REPEAT_COUNT = 3
# Step of the differences in inner coordinates.
STEP = 1.0e-4
# Costs within this share of the best count as the same minimum.
SAME_COST = 1.0e-3
# A residual in place of one that cannot be computed, in standard deviations.
FAILED = 1.0e3

# (set_count, unknown_count) -> (set_count, observation_count)
Predict = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Unknown:
    """A value to be fitted.

    Attributes:
        name, unit, meaning: for reports.
        start: where fits begin; the value if it is held.
        low, high: bounds.
        is_log: fit its logarithm.
        size: typical size of one that is not.
        rank: of those that the data cannot tell, the one of the lowest rank is held first.
    """

    name: str
    unit: str
    meaning: str
    start: float
    low: float
    high: float
    is_log: bool = True
    size: float = 1.0
    rank: int = 0

    def inner(self, value: float | np.ndarray) -> np.ndarray:
        """Its coordinate in a fit, of a value or an array of them: the logarithm, or the value over its size."""
        return np.log(value) if self.is_log else np.asarray(value) / self.size

    def outer(self, inner: float | np.ndarray) -> np.ndarray:
        """Its value, of a coordinate in a fit or an array of them."""
        # what is not determined may be anything
        return np.exp(np.clip(inner, -700.0, 700.0)) if self.is_log else np.asarray(inner) * self.size


@dataclass(frozen=True)
class Problem:
    """Observations and the model that predicts them.

    Attributes:
        unknowns: (p,).
        predict: values of all unknowns to predictions; see ``Predict``.
        observed, sigma: what was measured, and its standard deviation, (n,).
        group: index of the kind of test of each observation, (n,).
        repeat: index of the specimen of each observation, (n,); no two groups share one.
        group_names: of the kinds of tests.
    """

    unknowns: tuple[Unknown, ...]
    predict: Predict
    observed: np.ndarray
    sigma: np.ndarray
    group: np.ndarray
    repeat: np.ndarray
    group_names: tuple[str, ...]

    @property
    def start(self) -> np.ndarray:
        """Values of all unknowns where fits begin, (p,)."""
        return np.array([unknown.start for unknown in self.unknowns])

    def residuals(self, values: np.ndarray) -> np.ndarray:
        """Of sets of values (k, p), in standard deviations, (k, n)."""
        with np.errstate(all="ignore"):
            found = (self.predict(np.atleast_2d(values)) - self.observed) / self.sigma
        return np.where(np.isfinite(found), np.clip(found, -FAILED, FAILED), FAILED)


@dataclass(frozen=True)
class Fit:
    """The best of several fits.

    Attributes:
        problem: that was solved.
        values: of all unknowns, held ones included, (p,).
        is_free: which were fitted, (p,).
        at_bound: which of these ended at a bound, (p,).
        jacobian: of the residuals by inner coordinates, (n, p), of all unknowns.
        cost: half the sum of squares.
        costs: of all starts, the best first.
        held_uncertainty: standard deviation of held values, as a share.
    """

    problem: Problem
    values: np.ndarray
    is_free: np.ndarray
    at_bound: np.ndarray
    jacobian: np.ndarray
    cost: float
    costs: tuple[float, ...]
    held_uncertainty: float = 0.0

    @cached_property
    def chosen(self) -> np.ndarray:
        """Indices of the unknowns that have an interval, (c,)."""
        return np.flatnonzero(self.is_free & ~self.at_bound)

    @cached_property
    def residual(self) -> np.ndarray:
        """In standard deviations, (n,)."""
        return self.problem.residuals(self.values)[0]

    @cached_property
    def predicted(self) -> np.ndarray:
        """Predictions of the best values, (n,), in the units of what was observed."""
        return self.problem.predict(self.values[None])[0]

    @cached_property
    def _inverse(self) -> np.ndarray:
        j = self.jacobian[:, self.chosen]
        return inverse_square(j)

    @cached_property
    def _parts(self) -> tuple[list[np.ndarray], np.ndarray]:
        """Covariance from each group, and its degrees of freedom."""
        inverse, j = self._inverse, self.jacobian[:, self.chosen]
        parts, freedom = [], []
        for group in range(len(self.problem.group_names)):
            rows = self.problem.group == group
            repeats = np.unique(self.problem.repeat[rows])
            if len(repeats) >= LEAST_REPEAT_COUNT:
                score = np.array([self._score(j, rows & (self.problem.repeat == r)) for r in repeats])
                score = score - score.mean(axis=0)
                middle = len(repeats) / (len(repeats) - 1.0) * score.T @ score
                freedom.append(len(repeats) - 1.0)
            else:
                own = j[rows].T @ j[rows]
                used = float(np.trace(inverse @ own))
                count = max(float(rows.sum()) - used, 1.0)
                variance = float(self.residual[rows] @ self.residual[rows]) / count
                middle = variance * self._inflation(rows) * own
                freedom.append(count)
            parts.append(inverse @ middle @ inverse)
        return parts, np.array(freedom)

    def _score(self, j: np.ndarray, rows: np.ndarray) -> np.ndarray:
        return j[rows].T @ self.residual[rows]

    def _inflation(self, rows: np.ndarray) -> float:
        """How much less neighbouring residuals tell if they are alike: (1 + r) / (1 - r) with their correlation r."""
        pairs = [
            (self.residual[k[:-1]], self.residual[k[1:]])
            for r in np.unique(self.problem.repeat[rows])
            if len(k := np.flatnonzero(rows & (self.problem.repeat == r))) > 2
        ]
        if not pairs:
            return 1.0
        before, after = (np.concatenate(part) for part in zip(*pairs, strict=True))
        alike = float(before @ after) / max(float(np.sqrt((before @ before) * (after @ after))), 1.0e-300)
        # what white noise of this length shows by chance does not count
        alike = min(max(alike - 1.0 / np.sqrt(len(before)), 0.0), 0.95)
        return (1.0 + alike) / (1.0 - alike)

    @cached_property
    def covariance(self) -> np.ndarray:
        """Of the inner coordinates of ``chosen``, (c, c)."""
        total = np.sum(self._parts[0], axis=0)
        if self.held_uncertainty > 0.0 and (held := np.flatnonzero(~self.is_free)).size:
            effect = self.effect_of_held
            spread = [
                self.held_uncertainty * (1.0 if u.is_log else abs(v) / u.size)
                for u, v in ((self.problem.unknowns[k], self.values[k]) for k in held)
            ]
            total = total + (effect * spread) @ (effect * spread).T
        return total

    @cached_property
    def effect_of_held(self) -> np.ndarray:
        """Change of the fitted inner coordinates per change of the held ones, (c, h)."""
        held = self.jacobian[:, ~self.is_free]
        return -self._inverse @ self.jacobian[:, self.chosen].T @ held

    @cached_property
    def deviation(self) -> np.ndarray:
        """Standard deviation of each inner coordinate, (p,); NaN of what was not fitted or is at a bound."""
        result = np.full(len(self.values), np.nan)
        result[self.chosen] = np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        return result

    @cached_property
    def half_width(self) -> np.ndarray:
        """Half of each interval in inner coordinates, (p,)."""
        from scipy.stats import t

        parts, freedom = self._parts
        shares = np.array([np.diag(part) for part in parts])
        total = np.maximum(shares.sum(axis=0), 1.0e-300)
        # Welch and Satterthwaite
        degrees = total**2 / np.maximum((shares**2 / freedom[:, None]).sum(axis=0), 1.0e-300)
        result = np.full(len(self.values), np.nan)
        result[self.chosen] = t.ppf(0.5 + 0.5 * LEVEL, degrees) * self.deviation[self.chosen]
        return result

    def interval(self, index: int) -> tuple[float, float]:
        """Of an unknown, at ``LEVEL``; NaN if it has none. It stays within the bounds."""
        unknown = self.problem.unknowns[index]
        middle, half = float(unknown.inner(self.values[index])), float(self.half_width[index])
        low, high = (float(unknown.outer(middle + sign * half)) for sign in (-1.0, 1.0))
        return (max(low, unknown.low), min(high, unknown.high)) if half == half else (np.nan, np.nan)

    @cached_property
    def relative(self) -> np.ndarray:
        """Standard deviation over the value, (p,); of a logarithm that of the value."""
        result = self.deviation.copy()
        for k, unknown in enumerate(self.problem.unknowns):
            if not unknown.is_log:
                result[k] *= unknown.size / max(abs(self.values[k]), 1.0e-3 * unknown.size)
        return result

    @cached_property
    def correlation(self) -> np.ndarray:
        """Of ``chosen``, (c, c)."""
        sigma = np.sqrt(np.maximum(np.diag(self.covariance), 1.0e-300))
        return self.covariance / np.outer(sigma, sigma)

    @cached_property
    def condition(self) -> float:
        """Condition number of the Jacobian of what was fitted, in inner coordinates."""
        return condition(self.jacobian[:, self.chosen])

    @property
    def same_minimum(self) -> int:
        """Number of starts that ended at the best cost."""
        return int(np.sum(np.array(self.costs) <= self.cost * (1.0 + SAME_COST) + 1.0e-9))


def inverse_square(jacobian: np.ndarray) -> np.ndarray:
    """(J^T J)^-1 of (n, p), (p, p); directions that are not seen at all get a very large, finite value."""
    _, values, rows = np.linalg.svd(jacobian, full_matrices=False)
    values = np.maximum(values, 1.0e-13 * values.max(initial=1.0e-300))
    return (rows.T / values**2) @ rows


def condition(jacobian: np.ndarray) -> float:
    """Largest over smallest singular value; infinite if one vanishes."""
    values = np.linalg.svd(jacobian, compute_uv=False)
    return float(values[0] / values[-1]) if values.size and values[-1] > 0.0 else np.inf


def solve(
    problem: Problem,
    *,
    held: Sequence[str] = (),
    starts: int = 1,
    seed: int = 0,
    spread: float = 10.0,
    held_uncertainty: float = 0.0,
    first: np.ndarray | None = None,
) -> Fit:
    """The best of fits from several starts.

    Args:
        problem: to solve.
        held: names of unknowns that keep their start.
        starts: number of starts; the first is the given one.
        seed: of the others.
        spread: the others lie within this factor of the given one, or as far from it over its size.
        held_uncertainty: see ``Fit``.
        first: values of the first start, (p,); those of the unknowns by default.
    """
    from scipy.optimize import least_squares
    from scipy.stats import qmc

    unknowns = problem.unknowns
    is_free = np.array([unknown.name not in held for unknown in unknowns])
    free = np.flatnonzero(is_free)
    fixed = problem.start
    low, high = (np.array([float(u.inner(getattr(u, name))) for u in unknowns])[free] for name in ("low", "high"))
    given = np.array([float(u.inner(v)) for u, v in zip(unknowns, fixed if first is None else first, strict=True)])[
        free
    ]
    given = np.clip(given, low + 1.0e-9 * (high - low), high - 1.0e-9 * (high - low))

    def outer(inner: np.ndarray) -> np.ndarray:
        """Sets of all values (k, p) of sets of free inner coordinates (k, f)."""
        inner = np.atleast_2d(inner)
        values = np.tile(fixed, (len(inner), 1))
        for column, index in enumerate(free):
            values[:, index] = unknowns[index].outer(inner[:, column])
        return values

    def residual(inner: np.ndarray) -> np.ndarray:
        return problem.residuals(outer(inner))[0]

    def derivative(inner: np.ndarray) -> np.ndarray:
        return _derivative(lambda sets: problem.residuals(outer(sets)), inner)

    begins = [given]
    if starts > 1 and len(free):
        points = qmc.Sobol(len(free), seed=seed).random(1 << (starts - 1).bit_length())[: starts - 1]
        reach = np.array([np.log(spread) if unknowns[k].is_log else 1.0 for k in free])
        begins += [np.clip(given + reach * (2.0 * p - 1.0), low + 1e-6 * (high - low), high - 1e-6 * (high - low))
                   for p in points]  # fmt: skip
    found = []
    for begin in begins:
        if not len(free):
            found.append((0.5 * float(residual(given) @ residual(given)), given))
            break
        result = least_squares(
            residual, begin, jac=derivative, bounds=(low, high), method="trf", x_scale="jac", xtol=1e-9, ftol=1e-9,
            gtol=1e-9, max_nfev=50 if begin is not given else 100,
        )  # fmt: skip
        found.append((float(result.cost), result.x))
    found.sort(key=lambda item: item[0])
    cost, best = found[0]
    near = np.array([1.0e-4 if unknowns[k].is_log else 1.0e-6 for k in free])
    below, above = best <= low + near, best >= high - near
    best = np.where(below, low, np.where(above, high, best))
    values = outer(best)[0]
    at_bound = np.zeros(len(unknowns), dtype=bool)
    at_bound[free] = below | above
    jacobian = _whole_jacobian(problem, values)
    return Fit(problem, values, is_free, at_bound, jacobian, cost, tuple(cost for cost, _ in found), held_uncertainty)


def _derivative(function: Callable[[np.ndarray], np.ndarray], inner: np.ndarray) -> np.ndarray:
    """Central differences of (k, p) -> (k, n) at a point (p,), in one call: (n, p)."""
    sets = inner + STEP * np.concatenate([np.eye(len(inner)), -np.eye(len(inner))])
    values = function(sets)
    return ((values[: len(inner)] - values[len(inner) :]) / (2.0 * STEP)).T


def _whole_jacobian(problem: Problem, values: np.ndarray) -> np.ndarray:
    """Derivative by the inner coordinates of all unknowns, (n, p), where a value of zero is taken as a bit more."""
    unknowns = problem.unknowns
    inner = np.array(
        [float(u.inner(max(v, 1.0e-300) if u.is_log else v)) for u, v in zip(unknowns, values, strict=True)]
    )

    def residuals(sets: np.ndarray) -> np.ndarray:
        outer = np.column_stack([u.outer(sets[:, k]) for k, u in enumerate(unknowns)])
        return problem.residuals(outer)

    return _derivative(residuals, inner)
