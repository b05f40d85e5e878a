"""Measured curves: shape-preserving through their points, or smoothed, and the evenly spaced table of the kernels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from ..errors import InputError

# Cubic pieces of a curve on the device.
CURVE_PIECE_COUNT = 512
# How a curve continues beyond its last point. "trusted" is the end slope too, of a law that holds there.
Extrapolation = Literal["end slope", "constant", "trusted"]
# Largest deviation of the table from the curve within the data, over the largest value there.
LARGEST_TABLE_ERROR = 0.02
# Largest relative change of the energy by merging close points, and by smoothing.
LARGEST_MERGING_LOSS = 0.02
LARGEST_SMOOTHING_LOSS = 0.05
# Slopes up to three times those of the adjacent lines keep a cubic piece monotone (Fritsch and Carlson 1980).
LARGEST_SLOPE_RATIO = 3.0
# Points of a smoothed curve.
SMOOTH_POINT_COUNT = 129

# Values of one quantity.
Column = Sequence[float] | np.ndarray
Function = Callable[[np.ndarray], np.ndarray]


def check_curve(abscissa: Sequence[float], values: Sequence[float], names: tuple[str, str], *, from_zero: bool) -> None:
    """Raise ValueError unless ``abscissa`` is finite and increases from 0 (``from_zero``: the first value is 0 too)."""
    x, y = np.array(abscissa), np.array(values)
    if len(x) != len(y) or len(x) < (2 if from_zero else 1):
        least = "two" if from_zero else "one"
        raise ValueError(f"{len(x)} {names[0]} and {len(y)} {names[1]}: give the same number of both, {least} or more")
    if not (np.all(np.isfinite(x)) and np.all(np.isfinite(y))):
        raise ValueError(f"{names[0]} and {names[1]} must be finite")
    _check_order(x, names[0])
    if x[0] != 0.0:
        raise ValueError(
            f"{names[0]} must start at 0; the first is {x[0]:.6g}: add the point (0, 0), or subtract the offset of the "
            "machine"
        )
    if from_zero and y[0] != 0.0:
        raise ValueError(
            f"{names[1]} must start at 0, as {names[0]} do; the first is {y[0]:.6g}: subtract what the machine reads "
            "without load"
        )


def _check_order(x: np.ndarray, name: str) -> None:
    """Raise ValueError unless the points increase; names the likely reason."""
    step = np.diff(x)
    if np.all(step > 0.0):
        return
    k = int(np.argmax(step <= 0.0))
    text = f"{name} must increase; entry {k + 1} is {x[k]:.6g}, entry {k + 2} is {x[k + 1]:.6g}"
    if np.all(step < 0.0):
        raise ValueError(f"{text}: they decrease all along; write the points, and their values, in the reverse order")
    top = int(np.argmax(x))
    rises, falls = np.all(step[:top] > 0.0), np.all(step[top:] <= 0.0)
    if rises and falls and 0.2 * len(x) < len(x) - 1 - top:
        raise ValueError(
            f"{text}: they rise to {x[top]:.6g} and fall again, as loading and unloading in one column do. Give both "
            "at the same points, with from_loading_and_unloading, or leave out the unloading"
        )
    if step[k] == 0.0:
        raise ValueError(f"{text}: keep one point of each, or their mean")
    raise ValueError(f"{text}: sort the points; if there are several tests, average them first")


def measured_columns(**columns: Column) -> tuple[np.ndarray, ...]:
    """Columns of one test, by name, as arrays (n,).

    Raises:
        InputError: values that are not finite numbers, or columns of unequal length.
    """
    result = []
    for name, values in columns.items():
        try:
            array = np.asarray(values)
        except ValueError:
            array = np.empty((), dtype=object)
        if array.ndim != 1 or array.dtype.kind not in "iuf" or not np.all(np.isfinite(array)):
            raise InputError(f"{name}: a list of finite numbers is needed")
        result.append(array.astype(float))
    if len({len(array) for array in result}) > 1:
        lengths = ", ".join(f"{len(array)} of {name}" for name, array in zip(columns, result, strict=True))
        raise InputError(f"{lengths}: the same number of values is needed in each")
    if len(result[0]) < 2:
        raise InputError(f"{next(iter(columns))}: at least two points are needed")
    return tuple(result)


def check_loop(loading: np.ndarray, unloading: np.ndarray) -> None:
    """Raise InputError if unloading is above loading on the whole: friction would supply energy."""
    if np.mean(unloading - loading) > 0.0:
        raise InputError("unloading lies above loading, by its mean: exchange the two columns")


def limited_slopes(slope: np.ndarray, rise: np.ndarray) -> np.ndarray:
    """Slopes at points (n,) with which cubic pieces never leave the band between their end values.

    Args:
        slope: wanted at the points, (n,); one that is within the limit keeps its bits.
        rise: slopes of the straight lines between the points, (n - 1,).
    """
    before, after = np.append(rise[:1], rise), np.append(rise, rise[-1:])
    most = LARGEST_SLOPE_RATIO * np.minimum(np.abs(before), np.abs(after))
    flat = (before * after <= 0.0) | (slope * before <= 0.0)  # a turning point of the data, or against them
    return np.where(flat, 0.0, np.clip(slope, -most, most))


@dataclass(frozen=True, eq=False)
class MeasuredCurve:
    """A curve of x >= 0 through points: cubic between them and shape-preserving, linear beyond the last.

    Attributes:
        knots, values, slopes: at the points, (n,) each.
        slope_beyond: of the line beyond the last point.
    """

    knots: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    slope_beyond: float

    @classmethod
    def through(cls, knots: Column, values: Column, extrapolation: Extrapolation = "end slope") -> MeasuredCurve:
        """Through the points (n,), at least two; knots increase.

        Slopes are three-point differences, second-order also at the ends, where these keep the curve between
        neighbouring values; otherwise they are reduced until it stays there. The end slope is never negative, and at
        most three times the mean slope of the last tenth of the curve.
        """
        knots, values = np.asarray(knots, dtype=float), np.asarray(values, dtype=float)
        slopes = np.gradient(values, knots, edge_order=2 if len(knots) > 2 else 1)
        slopes = limited_slopes(slopes, np.diff(values) / np.diff(knots))
        tenth = int(np.searchsorted(knots, knots[0] + 0.9 * (knots[-1] - knots[0]), side="right")) - 1
        start = min(max(tenth, 0), len(knots) - 2)
        mean = (values[-1] - values[start]) / (knots[-1] - knots[start])
        slopes[-1] = min(max(slopes[-1], 0.0), LARGEST_SLOPE_RATIO * max(mean, 0.0))
        return cls(knots, values, slopes, 0.0 if extrapolation == "constant" else float(slopes[-1]))

    @classmethod
    @lru_cache(maxsize=128)
    def of_test(
        cls,
        knots: tuple[float, ...],
        values: tuple[float, ...],
        *,
        resolution: float,
        smoothing: float,
        extrapolation: Extrapolation,
    ) -> MeasuredCurve:
        """Through the points of a test that starts at (0, 0), for a table of the given spacing.

        Args:
            knots, values: the points, (n,) each.
            resolution: points closer than this count as one, at their mean.
            smoothing: root mean square distance from the points that is allowed; 0 goes through every one.
            extrapolation: beyond the last point.

        Raises:
            ValueError: merging or smoothing would change the curve by too much, or it gets negative.
        """
        raw = np.asarray(knots, dtype=float), np.asarray(values, dtype=float)
        points = smoothed(*raw, smoothing) if smoothing > 0.0 else merged(*raw, resolution)
        curve = cls.through(*points, extrapolation)
        exact = _trapezoid(*raw)
        if smoothing > 0.0:
            what, largest, area = f"smoothing = {smoothing:.4g}", LARGEST_SMOOTHING_LOSS, curve.energy
        else:
            # by straight lines: cubic pieces between a few points depend on every point
            what, largest, area = (
                f"merging points closer than {resolution:.4g}", LARGEST_MERGING_LOSS, _trapezoid(*points),
            )  # fmt: skip
        if abs(area - exact) > largest * abs(exact):
            raise ValueError(
                f"{what} changes the area under the curve from {exact:.4g} to {area:.4g}, by more than "
                f"{largest:.0%}: " + ("give a smaller one" if smoothing > 0.0 else "it rises within too short a range")
            )
        return curve

    @property
    def end(self) -> float:
        """The last knot."""
        return float(self.knots[-1])

    @property
    def energy(self) -> float:
        """Area under the curve up to its last point."""
        h = np.diff(self.knots)
        pieces = 0.5 * h * (self.values[:-1] + self.values[1:]) + h**2 * (self.slopes[:-1] - self.slopes[1:]) / 12.0
        return float(pieces.sum())

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Values at ``x`` >= 0, of any shape."""
        knots, values, slope = self.knots, self.values, self.slopes
        i = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(knots) - 2)
        h = knots[i + 1] - knots[i]
        s = np.minimum(x - knots[i], h) / h
        inside = (
            values[i] * (1 + 2 * s) * (1 - s) ** 2
            + h * slope[i] * s * (1 - s) ** 2
            + values[i + 1] * s**2 * (3 - 2 * s)
            + h * slope[i + 1] * s**2 * (s - 1)
        )
        return inside + np.maximum(x - knots[-1], 0.0) * self.slope_beyond


def merged(x: np.ndarray, y: np.ndarray, resolution: float) -> tuple[np.ndarray, np.ndarray]:
    """Points (n,) of which none are closer than ``resolution``: closer ones are replaced by their mean.

    The first point is kept, and so is the place of the last.
    """
    if np.all(np.diff(x) >= resolution * (1.0 - 1.0e-9)):
        return x, y
    group, start = np.zeros(len(x), dtype=int), x[0]
    for k in range(1, len(x)):
        new = x[k] - start >= resolution
        group[k] = group[k - 1] + int(new)
        start = x[k] if new else start
    count = np.bincount(group)
    if len(count) < 2:
        return x[[0, -1]], y[[0, -1]]
    mean_x, mean_y = (np.bincount(group, column) / count for column in (x, y))
    mean_x[0], mean_y[0], mean_x[-1] = x[0], y[0], x[-1]
    return mean_x, mean_y


def smoothed(x: np.ndarray, y: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Points of a smoothing spline from (0, 0) whose root mean square distance from the given ones is ``tolerance``.

    Raises:
        ValueError: too few points, or a curve that gets negative by more than the tolerance.
    """
    from scipy.interpolate import UnivariateSpline

    if len(x) < 6:
        raise ValueError(f"smoothing = {tolerance:.4g}: {len(x)} points are too few to be smoothed; leave it out")
    weight = np.full(len(x), 1.0 / tolerance)
    weight[0] *= 1.0e3  # the origin is exact
    spline = UnivariateSpline(x, y, w=weight, k=3, s=len(x))
    knots = np.linspace(x[0], x[-1], SMOOTH_POINT_COUNT)
    values = np.asarray(spline(knots))
    values[0] = y[0]
    if values.min() < -tolerance:
        k = int(np.argmin(values))
        raise ValueError(
            f"smoothing = {tolerance:.4g}: the smoothed curve is {values[k]:.4g} at {knots[k]:.4g}, below zero by more "
            "than that; subtract the machine's own force"
        )
    return knots, np.maximum(values, 0.0)


def _trapezoid(x: np.ndarray, y: np.ndarray) -> float:
    return float((0.5 * (y[1:] + y[:-1]) * np.diff(x)).sum())


def noise(x: np.ndarray, y: np.ndarray) -> float:
    """Standard deviation of the noise of points (n,), from each one's distance to the line through its neighbours."""
    if len(x) < 3:
        return 0.0
    share = (x[1:-1] - x[:-2]) / (x[2:] - x[:-2])
    distance = y[1:-1] - (1.0 - share) * y[:-2] - share * y[2:]
    # the median ignores the few places where the curve itself bends
    return float(1.4826 * np.median(np.abs(distance) / np.sqrt(1.0 + (1.0 - share) ** 2 + share**2)))


def tabulate(function: Function, spacing: float, piece_count: int) -> tuple[np.ndarray, np.ndarray]:
    """Cubic pieces of a function of x >= 0 between evenly spaced knots, and one linear piece beyond the last.

    Slopes are finite differences of the function, since it may be more than the interpolated curve (locking is added),
    limited like those of a ``MeasuredCurve``. Exact slopes would change the last digits of every run.

    Returns:
        Coefficients c of c_0 + c_1 x + c_2 x^2 + c_3 x^3 from each knot on, (piece_count + 1, 4), and the integral of
        the function up to each knot, (piece_count + 1,).
    """
    knots = spacing * np.arange(piece_count + 1)
    values = function(knots)
    step = 1.0e-4 * spacing
    slope = np.empty_like(values)
    slope[1:] = (function(knots[1:] + step) - function(knots[1:] - step)) / (2.0 * step)
    slope[0] = (-3.0 * values[0] + 4.0 * function(knots[:1] + step)[0] - function(knots[:1] + 2.0 * step)[0]) / (
        2.0 * step
    )
    slope_beyond = (function(knots[-1:] + step) - values[-1:]) / step
    rise = np.diff(values) / spacing
    slope = limited_slopes(slope, rise)
    c2 = (3.0 * rise - 2.0 * slope[:-1] - slope[1:]) / spacing
    c3 = (slope[:-1] + slope[1:] - 2.0 * rise) / spacing**2
    slope[-1:] = slope_beyond
    coefficients = np.column_stack([values, slope, np.append(c2, 0.0), np.append(c3, 0.0)])
    h = spacing
    pieces = h * (coefficients[:-1] @ np.array([1.0, h / 2.0, h**2 / 3.0, h**3 / 4.0]))
    return coefficients, np.concatenate([[0.0], np.cumsum(pieces)])


def table_error(function: Function, end: float, within: float) -> float:
    """Largest distance of the table of a function from it, for x up to ``within``, over its largest value there."""
    spacing = end / CURVE_PIECE_COUNT
    coefficients, _ = tabulate(function, spacing, CURVE_PIECE_COUNT)
    x = np.linspace(0.0, min(within, end), 8 * CURVE_PIECE_COUNT, endpoint=False) + 1.0e-9 * end
    piece = np.minimum((x / spacing).astype(int), CURVE_PIECE_COUNT - 1)
    s = x - piece * spacing
    c = coefficients[piece].T
    exact = function(x)
    largest = float(np.abs(exact).max())
    return float(np.abs(c[0] + s * (c[1] + s * (c[2] + s * c[3])) - exact).max()) / largest if largest > 0.0 else 0.0


def check_table(function: Function, end: float, within: float, unit: str, noise: float) -> None:
    """Raise ValueError if the kernels' table cannot follow a curve within its data."""
    error = table_error(function, end, within)
    if error > LARGEST_TABLE_ERROR:
        raise ValueError(
            f"the curve changes by {error:.1%} of its largest value within {end / CURVE_PIECE_COUNT:.3g} {unit}, the "
            f"spacing of the table that a run reads; at most {LARGEST_TABLE_ERROR:.0%} are allowed. Smooth it: "
            f"smoothing = {noise:.2g} is about its noise"
        )
