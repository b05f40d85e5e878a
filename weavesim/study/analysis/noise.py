"""Numerical noise of a measure: how far it scatters between runs that differ in nothing that anybody means."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Noise:
    """Standard deviation of a single run.

    Attributes:
        deviation: pooled over all repeated points.
        low, high: 95 % interval of it, if the scatter is normal.
        degrees: of freedom.
        points: how many points were repeated.
    """

    deviation: float
    low: float
    high: float
    degrees: int
    points: int

    @property
    def least_difference(self) -> float:
        """Difference of two runs that chance exceeds in 5 % of all pairs."""
        from scipy.stats import t

        return math.sqrt(2.0) * self.deviation * float(t.ppf(0.5 + 0.5 * CONFIDENCE, self.degrees))


def noise_of(groups: Sequence[Sequence[float]]) -> Noise | None:
    """Noise from repeats of some points; None without a point that was repeated.

    Args:
        groups: the values of each point: of the run itself and of its repeats.
    """
    from scipy.stats import chi2

    used = [np.asarray(group, dtype=float) for group in groups if len(group) > 1]
    degrees = sum(len(group) - 1 for group in used)
    if not degrees:
        return None
    total = sum(float(((group - group.mean()) ** 2).sum()) for group in used)
    low, high = (math.sqrt(total / chi2.ppf(0.5 + side * 0.5 * CONFIDENCE, degrees)) for side in (1.0, -1.0))
    return Noise(math.sqrt(total / degrees), low, high, degrees, len(used))


def chance_of(values: Sequence[float], noise: Noise) -> float:
    """Probability that noise alone scatters as much as these values of different points: an F-test of variances."""
    from scipy.stats import f

    if len(values) < 2:
        return 1.0
    variance = float(np.var(values, ddof=1))
    if noise.deviation == 0.0:
        return 0.0 if variance > 0.0 else 1.0
    return float(f.sf(variance / noise.deviation**2, len(values) - 1, noise.degrees))
