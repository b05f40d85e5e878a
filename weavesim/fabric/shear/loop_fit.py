"""A measured loop of loading and unloading in shear, prepared and fitted (``loop.py`` says what for)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ...errors import InputError
from ..curve import MeasuredCurve

# A test is averaged to about this many points, and its elastic curve has these.
POINT_COUNT, ELASTIC_POINT_COUNT = 400, 13
# Smaller changes of direction are noise of the angle, over its range; a smaller unloading says nothing.
SMALLEST_TURN, SMALLEST_UNLOADING, FEWEST_POINTS = 0.02, 0.15, 20
# A frame that goes slack reads less than this, over the largest moment, while the angle still falls.
SLACK = 0.02
# Slope at which friction sets in, over its limit [1/rad]: within 15 to 0.05 degrees; and where the fit starts.
LEAST_ONSET, LARGEST_ONSET = 1.0 / math.radians(15.0), 1.0 / math.radians(0.05)
FIRST_ONSETS = tuple(1.0 / math.radians(degrees) for degrees in (4.0, 1.0, 0.25))
NORMAL_95 = 1.96


class LoopTest(NamedTuple):
    """A test as it is fitted.

    Attributes:
        angle, moment: in the order of time, averaged (n,) [rad], [N/m].
        scatter: standard deviation from one measured point to the next [N/m].
        largest: moment [N/m].
        unloaded_between: smallest and largest angle of unloading [rad].
    """

    angle: np.ndarray
    moment: np.ndarray
    scatter: float
    largest: float
    unloaded_between: tuple[float, float]


class LoopFit(NamedTuple):
    """Elastic curve and friction with the least squares.

    Attributes:
        knots, elastic: of the elastic curve [rad], [N/m].
        limit_knots, limits, limit_error: of the friction's limit (m,), with half of the 95 % interval.
        stiffness, stiffness_interval: of the friction, with the 95 % interval [N/m].
        onset: stiffness over the mean limit [1/rad].
        residual: root mean square distance [N/m].
        criterion: Schwarz's: the least is best.
    """

    knots: np.ndarray
    elastic: np.ndarray
    limit_knots: np.ndarray
    limits: np.ndarray
    limit_error: np.ndarray
    stiffness: float
    stiffness_interval: tuple[float, float]
    onset: float
    residual: float
    criterion: float


def prepared(angle: np.ndarray, moment: np.ndarray) -> tuple[LoopTest, list[str]]:
    """The test without what a slack frame reads, averaged; and notes."""
    notes: list[str] = []
    span = float(np.ptp(angle))
    if angle.min() < -0.05 * span:
        raise InputError(
            f"angle is down to {math.degrees(angle.min()):.3g} degrees: subtract the offset, or give the part that "
            "starts at zero"
        )
    angle = np.maximum(angle - (angle[0] if abs(angle[0]) < 0.02 * span else 0.0), 0.0)
    pieces = list(_branches(angle, SMALLEST_TURN * span))
    falls = [angle[a:b] for a, b, up in pieces if not up]
    if len(angle) < FEWEST_POINTS or not any(np.ptp(part) > SMALLEST_UNLOADING * span for part in falls):
        raise InputError(
            "angle: there is no unloading in this test (it must fall by more than 15 % of its range, in 20 points or "
            "more); loading alone does not tell elastic moment and friction apart: see split_jump for an assumption"
        )
    scatter = max(_scatter(moment[a:b]) for a, b, _ in pieces)
    largest = float(moment.max())
    end = _slack_from(angle, moment, pieces, max(SLACK * largest, 3.0 * scatter))
    if end < len(moment):
        notes.append(
            f"from point {end + 1} on, at {math.degrees(angle[end]):.3g} degrees, the test reads no moment: the frame "
            "is slack there, and the rest is left out"
        )
        angle, moment = angle[:end], moment[:end]
        pieces = [(a, min(b, end), up) for a, b, up in pieces if a < end]
    falls = [angle[a:b] for a, b, up in pieces if not up]
    unloaded = (float(min(part.min() for part in falls)), float(max(part.max() for part in falls)))
    if _height(angle, moment, pieces) < -2.0 * scatter:
        raise InputError(
            "unloading lies above loading, by its mean: the test is not in the order of time, or columns are exchanged"
        )
    groups = _averaged(_without_jitter(angle, pieces), moment, pieces)
    return LoopTest(*groups, scatter, largest, unloaded), notes


def _branches(angle: np.ndarray, turn: float) -> Iterator[tuple[int, int, bool]]:
    """Start, end, and whether it rises, of each part of a path between changes of direction larger than ``turn``."""
    start, extreme, rising = 0, 0, True
    for k in range(1, len(angle)):
        if (angle[k] >= angle[extreme]) if rising else (angle[k] <= angle[extreme]):
            extreme = k
        elif abs(angle[k] - angle[extreme]) > turn:
            if extreme > start:
                yield start, extreme + 1, rising
            start, extreme, rising = extreme, k, not rising
    yield start, len(angle), rising


def _without_jitter(angle: np.ndarray, pieces: Sequence[tuple[int, int, bool]]) -> np.ndarray:
    """Angles that only rise or only fall in each branch: friction would take noise for a change of direction."""
    result = angle.copy()
    for start, end, rises in pieces:
        part = result[start:end] if rises else -result[start:end]
        part = 0.5 * (np.maximum.accumulate(part) + np.minimum.accumulate(part[::-1])[::-1])
        result[start:end] = part if rises else -part
    return result


def _slack_from(angle: np.ndarray, moment: np.ndarray, pieces: Sequence[tuple[int, int, bool]], least: float) -> int:
    """The first point of an unloading that reads nothing, until it ends; the number of points without one."""
    up = next((slice(a, b) for a, b, rises in pieces if rises), None)
    for start, end, rises in pieces:
        low = np.flatnonzero(moment[start:end] < least)
        if rises or up is None or not len(low):
            continue
        first = start + int(low[0])
        rest, before = slice(first, end), slice(max(start, 2 * first - end), first)
        if end - first < 8 or first - before.start < 3 or np.ptp(angle[rest]) < SMALLEST_TURN * np.ptp(angle):
            continue
        order = np.argsort(angle[up], kind="stable")
        loading = np.interp(angle[rest], angle[up][order], moment[up][order])
        is_flat = abs(_slope(angle[rest], moment[rest])) < 0.25 * abs(_slope(angle[before], moment[before]))
        if (
            is_flat
            and moment[rest].min() > -least
            and np.mean(loading) > 2.0 * abs(np.mean(moment[rest])) + 0.5 * least
        ):
            return first
    return len(moment)


def _slope(x: np.ndarray, y: np.ndarray) -> float:
    centred = x - x.mean()
    return float(centred @ y / max(float(centred @ centred), 1.0e-30))


def _height(angle: np.ndarray, moment: np.ndarray, pieces: Sequence[tuple[int, int, bool]]) -> float:
    """Mean of loading less unloading over the angles of the first unloading [N/m]."""
    up = next((piece for piece in pieces if piece[2]), None)
    down = next(piece for piece in pieces if not piece[2])
    if up is None:
        return 0.0
    order = np.argsort(angle[up[0] : up[1]], kind="stable")
    loading = np.interp(angle[down[0] : down[1]], angle[up[0] : up[1]][order], moment[up[0] : up[1]][order])
    return float(np.mean(loading - moment[down[0] : down[1]]))


def _averaged(
    angle: np.ndarray, moment: np.ndarray, pieces: Sequence[tuple[int, int, bool]]
) -> tuple[np.ndarray, np.ndarray]:
    """Means of neighbouring points, never across a change of direction; its last point stays."""
    size = max(math.ceil(len(angle) / POINT_COUNT), 1)
    if size == 1:
        return angle, moment
    means = []
    for start, end, _ in pieces:
        for first in range(start, end - 1, size):
            block = slice(first, min(first + size, end - 1))
            means.append((angle[block].mean(), moment[block].mean()))
        means.append((angle[end - 1], moment[end - 1]))
    result = np.array(means)
    return result[:, 0], result[:, 1]


def _scatter(moment: np.ndarray) -> float:
    """Standard deviation of a branch from one point to the next; the median ignores the places where it bends."""
    if len(moment) < 3:
        return 0.0
    return float(1.4826 * np.median(np.abs(moment[:-2] - 2.0 * moment[1:-1] + moment[2:])) / math.sqrt(6.0))


class _Model:
    """Predictions of a test; parameters are the elastic values but the first, the limits, log(onset), and the share of
    the limit at the start if that is not rest."""

    def __init__(self, test: LoopTest, limit_count: int, from_rest: bool) -> None:
        self.test, self.limit_count, self.from_rest = test, limit_count, from_rest
        self.knots = np.linspace(0.0, float(test.angle.max()), ELASTIC_POINT_COUNT)
        low, high = test.unloaded_between
        # the start from rest tells the limit at zero
        self.limit_knots = np.linspace(0.0 if from_rest else low, high, limit_count) if limit_count > 1 else np.zeros(1)
        # (n, m): share of each limit at each angle
        unit = np.eye(limit_count)
        self._shares = np.column_stack([np.interp(test.angle, self.limit_knots, row) for row in unit])

    def split(self, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray, float, float]:
        """Elastic values with the first, limits, onset, share of the limit at the start."""
        count = ELASTIC_POINT_COUNT - 1
        elastic, rest = parameters[:count], parameters[count:]
        start = 0.0 if self.from_rest else float(rest[self.limit_count + 1])
        return np.append(0.0, elastic), rest[: self.limit_count], math.exp(rest[self.limit_count]), start

    def elastic(self, parameters: np.ndarray) -> np.ndarray:
        return MeasuredCurve.through(self.knots, self.split(parameters)[0])(self.test.angle)

    def friction(self, sets: np.ndarray) -> np.ndarray:
        """Friction moments (n, k) of k sets of parameters, all at once."""
        parts = [self.split(parameters) for parameters in sets]
        limits, onset = np.array([part[1] for part in parts]).T, np.array([part[2] for part in parts])
        limit = self._shares @ limits
        mean = np.maximum(limits.mean(axis=0), 1.0e-12)
        reach = limit / (onset * mean)
        angle = self.test.angle
        slip = np.zeros(len(sets)) if self.from_rest else angle[0] - np.array([part[3] for part in parts]) * reach[0]
        result = np.empty_like(limit)
        for k, (gamma, most) in enumerate(zip(angle, reach, strict=True)):
            bent = np.clip(gamma - slip, -most, most)
            slip = gamma - bent
            result[k] = bent
        return result * onset * mean

    def residual(self, parameters: np.ndarray) -> np.ndarray:
        return self.elastic(parameters) + self.friction(parameters[None, :])[:, 0] - self.test.moment

    def jacobian(self, parameters: np.ndarray) -> np.ndarray:
        """Forward differences, of which those of friction are one path."""
        count = ELASTIC_POINT_COUNT - 1
        step = 1.0e-6 * np.maximum(np.abs(parameters), 1.0e-3 * self.test.largest)
        step[count + self.limit_count :] = 1.0e-6
        moved = parameters + np.diag(step)
        here = self.elastic(parameters)
        columns = [(self.elastic(moved[k]) - here) / step[k] for k in range(count)]
        paths = self.friction(np.vstack([parameters, moved[count:]]))
        return np.column_stack([*columns, (paths[:, 1:] - paths[:, :1]) / step[count:]])


def fitted(test: LoopTest, limit_count: int, from_rest: bool, like: LoopFit | None = None) -> LoopFit:
    """The best fit with that many points of the limit, from several starts, or from that of a fit ``like`` it."""
    from scipy.optimize import least_squares

    model = _Model(test, limit_count, from_rest)
    elastic_count = ELASTIC_POINT_COUNT - 1
    count = elastic_count + limit_count + (1 if from_rest else 2)
    low, high = np.zeros(count), np.full(count, np.inf)
    place = elastic_count + limit_count
    low[place], high[place] = math.log(LEAST_ONSET), math.log(LARGEST_ONSET)
    if not from_rest:
        low[-1], high[-1] = -1.0, 1.0
    order = np.argsort(test.angle, kind="stable")
    middle = np.maximum(np.interp(model.knots[1:], test.angle[order], _running_mean(test.moment[order])), 0.0)
    best = None
    for onset in FIRST_ONSETS if like is None else (like.onset,):
        start = np.zeros(count)
        start[:elastic_count] = middle + 1.0e-3 * test.largest
        start[elastic_count:place] = 0.1 * test.largest
        start[place] = math.log(onset)
        found = least_squares(model.residual, start, model.jacobian, (low, high), x_scale="jac", max_nfev=200)
        if best is None or found.cost < best.cost:
            best = found
    assert best is not None
    return _result(model, best.x)


def _running_mean(values: np.ndarray) -> np.ndarray:
    """Over a twentieth of the points, so that loading and unloading are averaged."""
    half = max(len(values) // 40, 1)
    padded = np.pad(values, half, mode="edge")
    return np.convolve(padded, np.full(2 * half + 1, 1.0 / (2 * half + 1)), mode="valid")


def _result(model: _Model, parameters: np.ndarray) -> LoopFit:
    test, m = model.test, model.limit_count
    residual = model.residual(parameters)
    n, count = len(residual), len(parameters)
    square = float((residual**2).sum())
    jacobian = model.jacobian(parameters)
    covariance = np.linalg.pinv(jacobian.T @ jacobian, hermitian=True) * square / max(n - count, 1)
    elastic, limits, onset, _ = model.split(parameters)
    place = ELASTIC_POINT_COUNT - 1
    error = NORMAL_95 * np.sqrt(np.diag(covariance)[place : place + m])
    mean = float(limits.mean())
    # of log(stiffness) = log(onset) + log(mean limit)
    slope = np.append(np.full(m, 1.0 / (m * max(mean, 1.0e-12))), 1.0)
    block = covariance[place : place + m + 1, place : place + m + 1]
    spread = math.exp(min(NORMAL_95 * math.sqrt(max(float(slope @ block @ slope), 0.0)), 50.0))
    stiffness = onset * mean
    scale = max(square / n, (1.0e-6 * test.largest) ** 2)
    return LoopFit(
        model.knots, elastic, model.limit_knots, limits, error, stiffness, (stiffness / spread, stiffness * spread),
        onset, math.sqrt(square / n), n * math.log(scale) + count * math.log(n),
    )  # fmt: skip
