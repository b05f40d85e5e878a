"""Measured curves: cubic interpolation through their points, and the evenly spaced table that the kernels read."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..errors import InputError


def check_curve(abscissa: Sequence[float], values: Sequence[float], names: tuple[str, str], *, from_zero: bool) -> None:
    """Raise ValueError unless ``abscissa`` is finite and increases from 0 (``from_zero``: the first value is 0 too)."""
    x, y = np.array(abscissa), np.array(values)
    if len(x) != len(y) or len(x) < (2 if from_zero else 1):
        least = "two" if from_zero else "one"
        raise ValueError(f"{len(x)} {names[0]} and {len(y)} {names[1]}: give the same number of both, {least} or more")
    if not (np.all(np.isfinite(x)) and np.all(np.isfinite(y))):
        raise ValueError(f"{names[0]} and {names[1]} must be finite")
    if x[0] != 0.0 or np.any(np.diff(x) <= 0.0):
        raise ValueError(f"{names[0]} must start at 0 and increase")
    if from_zero and y[0] != 0.0:
        raise ValueError(f"{names[1]} must start at 0, as {names[0]} do")


# Values of one quantity.
Column = Sequence[float] | np.ndarray


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


def interpolate(knots: Column, values: Column, x: np.ndarray) -> np.ndarray:
    """Cubic curve through points at ``x`` >= 0; extrapolated with its end slope, or zero if that is negative.

    Args:
        knots, values: the points, (n,) each, at least two; knots increase.
        x: where to evaluate, any shape.

    Returns:
        Values in the unit of ``values``, in the shape of ``x``. Slopes at the points are three-point differences,
        second-order also at the ends.
    """
    knots, values = np.asarray(knots, dtype=float), np.asarray(values, dtype=float)
    slope = np.gradient(values, knots, edge_order=2 if len(knots) > 2 else 1)
    slope[-1] = max(slope[-1], 0.0)
    i = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(knots) - 2)
    h = knots[i + 1] - knots[i]
    s = np.minimum(x - knots[i], h) / h
    inside = (
        values[i] * (1 + 2 * s) * (1 - s) ** 2
        + h * slope[i] * s * (1 - s) ** 2
        + values[i + 1] * s**2 * (3 - 2 * s)
        + h * slope[i + 1] * s**2 * (s - 1)
    )
    return inside + np.maximum(x - knots[-1], 0.0) * slope[-1]


def tabulate(
    function: Callable[[np.ndarray], np.ndarray], spacing: float, piece_count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Cubic pieces of a function of x >= 0 between evenly spaced knots, and one linear piece beyond the last.

    Slopes are finite differences of the function, since it may be more than the interpolated curve (locking is added).
    Exact slopes would change the last digits of every run.

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
    c2 = (3.0 * rise - 2.0 * slope[:-1] - slope[1:]) / spacing
    c3 = (slope[:-1] + slope[1:] - 2.0 * rise) / spacing**2
    slope[-1:] = slope_beyond
    coefficients = np.column_stack([values, slope, np.append(c2, 0.0), np.append(c3, 0.0)])
    h = spacing
    pieces = h * (coefficients[:-1] @ np.array([1.0, h / 2.0, h**2 / 3.0, h**3 / 4.0]))
    return coefficients, np.concatenate([[0.0], np.cumsum(pieces)])
