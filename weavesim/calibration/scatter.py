"""How much repeats of a test scatter: the weights of a fit, and the yardstick of its residual."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .series import Series, noise_of

GRID_COUNT = 40
# Width of the window that smooths variances, as a share of the range.
WINDOW = 0.15
# Scatter is at least this share of its mean square root, and of the largest value.
LEAST_SHARE, LEAST_OF_LARGEST = 0.2, 1.0e-3
# Least scatter where only one test is there and no noise is stated, as a share of the largest value.
UNSTATED = 0.01


@dataclass(frozen=True)
class Scatter:
    """Standard deviation of what was measured.

    Attributes:
        x, sigma: along the abscissa, (n,) each; constant beyond.
        source: where it comes from, for reports.
        yardstick: a residual above it is said.
    """

    x: np.ndarray
    sigma: np.ndarray
    source: str
    yardstick: float

    def at(self, x: np.ndarray) -> np.ndarray:
        """Standard deviations at abscissas (n,), (n,)."""
        return np.interp(x, self.x, self.sigma)


def scatter_of(tests: Sequence[Series], stated: float | None = None) -> Scatter:
    """Of the repeats of one kind of test; of a single one from its points, or as stated.

    Args:
        tests: of equal dimensions, x the abscissa that they share.
        stated: standard deviation as a share of the largest value; of a single test only.
    """
    largest = max(float(np.abs(t.y).max()) for t in tests)
    if len(tests) > 1:
        grid, curves = on_common_grid(tests)
        variance = curves.var(axis=0, ddof=1)
        distance = (grid[:, None] - grid[None, :]) / (WINDOW * float(np.ptp(grid)))
        weight = np.exp(-0.5 * distance**2)
        sigma = np.sqrt(weight @ variance / weight.sum(axis=1))
        mean = float(np.sqrt(np.mean(variance)))
        sigma = np.maximum(sigma, max(LEAST_SHARE * mean, LEAST_OF_LARGEST * largest))
        return Scatter(grid, sigma, f"scatter of {len(tests)} repeats", max(mean, LEAST_OF_LARGEST * largest))
    (test,) = tests
    ends = np.array([test.x.min(), test.x.max()])
    if stated is not None:
        value = stated * largest
        return Scatter(ends, np.full(2, value), f"stated noise, {stated:.3g} of the largest value", value)
    # a curve that was smoothed or digitised has hardly any noise, and is not exact for that
    own = noise_of(test)
    value = max(own, UNSTATED * largest)
    source = "noise of the points of a single test" if own == value else "1 % of the largest value of a single test"
    return Scatter(ends, np.full(2, value), source, value)


def on_common_grid(tests: Sequence[Series]) -> tuple[np.ndarray, np.ndarray]:
    """A grid over the range that all tests share, (g,), and their loading on it, (test_count, g)."""
    loadings = []
    for test in tests:
        x, y = test.loading
        x, index = np.unique(x, return_index=True)
        loadings.append((x, y[index]))
    grid = np.linspace(max(x[0] for x, _ in loadings), min(x[-1] for x, _ in loadings), GRID_COUNT)
    return grid, np.array([np.interp(grid, x, y) for x, y in loadings])
