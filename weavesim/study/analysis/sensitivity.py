"""What matters: Sobol's indices with intervals, shares of the variance, rank correlations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..factors import Factor, Value

# Of the intervals, from so many resamples of the points.
CONFIDENCE, RESAMPLES = 0.95, 999


@dataclass(frozen=True)
class Effect:
    """What one factor does to one measure.

    Attributes:
        factor: its name.
        kind: "sobol" (first and total index), "levels" (share of the variance between its values), or "rank" (rank
            correlation).
        value: the first index, the share, or the correlation.
        low, high: 95 % interval of it; None without one.
        total: total index; None for other kinds.
        total_low, total_high: its interval.
        chance: probability that chance alone does as much; None for indices.
    """

    factor: str
    kind: str
    value: float
    low: float | None = None
    high: float | None = None
    total: float | None = None
    total_low: float | None = None
    total_high: float | None = None
    chance: float | None = None


def sobol_effects(factors: Sequence[Factor], values: Sequence[float], samples: int, seed: int) -> list[Effect]:
    """First and total indices with their intervals.

    Estimators of Saltelli et al. (2010) as scipy has them; intervals are percentiles of a bootstrap over the points.

    Args:
        factors: of the study.
        values: of a measure, in the order of ``plans.designs.sobol_design``.
        samples: of that design.
        seed: of the bootstrap.
    """
    from scipy.stats import sobol_indices

    count = len(factors)
    parts = np.asarray(values, dtype=float).reshape(count + 2, samples)

    def indices(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        # of a single factor scipy would make a scalar, which it then cannot fill
        mixed = parts[2:] if count > 1 else np.repeat(parts[2:], 2, axis=0)
        func = {"f_A": parts[0, places][None], "f_B": parts[1, places][None], "f_AB": mixed[:, None, places]}
        found = sobol_indices(func=func, n=samples)
        return found.first_order[:count], found.total_order[:count]

    first, total = indices(np.arange(samples))
    rng = np.random.default_rng(seed)
    again = [indices(rng.integers(0, samples, samples)) for _ in range(RESAMPLES)]
    sides = (50.0 * (1.0 - CONFIDENCE), 50.0 * (1.0 + CONFIDENCE))
    first_low, first_high = np.percentile([each[0] for each in again], sides, axis=0)
    total_low, total_high = np.percentile([each[1] for each in again], sides, axis=0)
    return [
        Effect(
            factor.name, "sobol", float(first[k]), float(first_low[k]), float(first_high[k]), float(total[k]),
            float(total_low[k]), float(total_high[k]),
        )
        for k, factor in enumerate(factors)
    ]  # fmt: skip


def level_effects(
    factors: Sequence[Factor], points: Sequence[tuple[Value, ...]], values: Sequence[float]
) -> list[Effect]:
    """Share of the variance of a measure between the values of each factor (eta squared), with its F-test.

    Nothing for a factor that has every value once: the share would be all of it, whatever the measure.
    """
    from scipy.stats import f_oneway

    measured = np.asarray(values, dtype=float)
    whole = float(((measured - measured.mean()) ** 2).sum()) if len(measured) else 0.0
    found = []
    for k, factor in enumerate(factors):
        groups: dict[Value, list[float]] = {}
        for point, value in zip(points, measured, strict=True):
            groups.setdefault(point[k], []).append(float(value))
        if len(groups) == len(points):
            continue
        means = sum(len(group) * (np.mean(group) - measured.mean()) ** 2 for group in groups.values())
        share = float(means / whole) if whole > 0.0 else 0.0
        chance = None
        if len(groups) > 1 and min(map(len, groups.values())) > 1 and 0.0 < share < 1.0 - 1.0e-12:
            chance = float(f_oneway(*groups.values()).pvalue)
        found.append(Effect(factor.name, "levels", share, chance=chance))
    return found


def rank_effects(
    factors: Sequence[Factor], points: Sequence[tuple[Value, ...]], values: Sequence[float]
) -> list[Effect]:
    """Spearman's rank correlation of a measure with each factor; for factors that are no numbers, the share between
    their values."""
    from scipy.stats import spearmanr

    found = []
    for k, factor in enumerate(factors):
        if not factor.is_numeric:
            found += level_effects([factor], [(point[k],) for point in points], values)
            continue
        column = [float(point[k]) for point in points]  # type: ignore[arg-type]
        if len(set(column)) < 2 or len(set(values)) < 2 or len(values) < 3:
            found.append(Effect(factor.name, "rank", 0.0))
            continue
        result = spearmanr(column, values)
        found.append(Effect(factor.name, "rank", float(result.statistic), chance=float(result.pvalue)))
    return found


def without_effect(
    factors: Sequence[Factor], points: Sequence[tuple[Value, ...]], values: Sequence[tuple[float, ...]]
) -> dict[str, int]:
    """Factors that change no measure at all, by pairs of runs that differ in nothing else: name, number of pairs."""
    found = {}
    for k, factor in enumerate(factors):
        first: dict[tuple[Value, ...], tuple[Value, tuple[float, ...]]] = {}
        pairs, same = 0, True
        for point, numbers in zip(points, values, strict=True):
            rest = (*point[:k], *point[k + 1 :])
            if rest not in first:
                first[rest] = point[k], numbers
            elif first[rest][0] != point[k]:
                pairs += 1
                same &= first[rest][1] == numbers
        if pairs and same:
            found[factor.name] = pairs
    return found
