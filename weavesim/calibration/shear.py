"""The shear law of picture frames and bias extensions together: an elastic curve, and friction at the crossovers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..fabric.curve import MeasuredCurve
from ..fabric.fabric import LARGEST_LOCKING_SHARE, Fabric
from ..fabric.shear import MomentCurve, ShearFriction
from .fitting.fit import Problem, Unknown
from .options import CalibrationOptions
from .readings import bias_factors
from .scatter import Scatter, scatter_of
from .series import Series, first_reversal

# Angle over which friction builds up where no loop shows it [rad], and its bounds.
SLIP_ANGLE = math.radians(1.0)
SLIP_ANGLE_RANGE = (math.radians(0.05), math.radians(6.0))
# Angles at which the limit of friction is fitted to a loop.
LIMIT_COUNT = 3
FRICTION, SLIP = "friction_limit", "slip_angle"
# Friction below this share of the largest moment is left out of the law.
LEAST_FRICTION = 1.0e-3
FRAME, BIAS = "picture frame", "bias extension"


@dataclass(frozen=True)
class ShearModel:
    """Parameters of the law, and how they predict a test.

    Attributes:
        knots: angles of the elastic curve, from 0, (k + 1,) [rad].
        limit_angles: at which friction has its limit, (l,) [rad]; (0,) for none or a constant one.
        has_friction: the law has some.
        tests: all series, and whether each is a bias extension.
        length, width: of the bias extension's strip [m].
        cell_moment: what the unit cell itself adds at the angles of each test, and at half of them [N/m].
    """

    knots: np.ndarray
    limit_angles: np.ndarray
    has_friction: bool
    tests: tuple[tuple[Series, bool], ...]
    length: float
    width: float
    cell_moment: tuple[tuple[np.ndarray | float, np.ndarray | float], ...]

    @property
    def knot_names(self) -> tuple[str, ...]:
        """Names of the unknown moments, one per knot but the first, (k,)."""
        return tuple(f"moment_at_{math.degrees(angle):.3g}_deg" for angle in self.knots[1:])

    @property
    def limit_names(self) -> tuple[str, ...]:
        """Names of the unknown limits of friction, (l,)."""
        if len(self.limit_angles) == 1:
            return (FRICTION,)
        return tuple(f"{FRICTION}_at_{math.degrees(angle):.3g}_deg" for angle in self.limit_angles)

    def split(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Moments (s, k + 1), limits (s, l) and slip angles (s,) of sets of values (s, p)."""
        count = len(self.knots) - 1
        moments = np.column_stack([np.zeros(len(values)), values[:, :count]])
        if not self.has_friction:
            return moments, np.zeros((len(values), 1)), np.full(len(values), SLIP_ANGLE)
        return moments, values[:, count:-1], values[:, -1]

    def predict(self, values: np.ndarray) -> np.ndarray:
        """Sets of values (s, p) to what is measured, (s, n)."""
        paths = [test.x for test, _ in self.tests] + [0.5 * test.x for test, is_bias in self.tests if is_bias]
        moments = self.moments_along(paths, *self.split(values))
        halves = iter(moments[len(self.tests) :])
        result = []
        for (test, is_bias), moment, cell in zip(self.tests, moments, self.cell_moment, strict=False):
            if is_bias:
                whole, half = bias_factors(test.x, self.length, self.width)
                result.append((moment + cell[0]) * whole + (next(halves) + cell[1]) * half)
            else:
                result.append(moment + cell[0])
        return np.concatenate(result, axis=1)

    def moments_along(
        self, paths: Sequence[np.ndarray], moments: np.ndarray, limits: np.ndarray, slip_angle: np.ndarray
    ) -> list[np.ndarray]:
        """Moment along paths of angles (n,) from rest, for sets of parameters, (s, n) each [N/m]."""
        ends = np.cumsum([0, *map(len, paths)])
        joined = np.concatenate(paths)
        total = np.array([MeasuredCurve.through(self.knots, row)(joined) for row in moments])
        pieces = [slice(a, b) for a, b in zip(ends, ends[1:], strict=False)]
        if not self.has_friction:
            return [total[:, piece] for piece in pieces]
        limit = np.array([np.interp(joined, self.limit_angles, row) for row in limits])
        stiffness = np.maximum(limits[:, :1], 1.0e-12) / slip_angle[:, None]
        # all paths at once; shorter ones stay at their end
        place = np.array([np.minimum(np.arange(max(map(len, paths))), len(path) - 1) for path in paths])
        place += ends[:-1, None]
        reach, slip = limit / stiffness, np.zeros((len(moments), len(paths)))
        friction = np.empty_like(total)
        for k in place.T:
            angle = joined[k]
            slip = angle - np.clip(angle - slip, -reach[:, k], reach[:, k])
            friction[:, k] = stiffness * (angle - slip)
        total += friction
        return [total[:, piece] for piece in pieces]

    def band(self, angle: np.ndarray, values: np.ndarray, is_bias: bool, *, back: bool = False) -> np.ndarray:
        """Prediction along a loading (and unloading) of one test, for drawing, (n,)."""
        path = np.concatenate([angle, angle[::-1]]) if back else angle
        drawn = replace(self, tests=((Series("", "", path, path, path, ("", "")), is_bias),), cell_moment=((0.0, 0.0),))
        return drawn.predict(values[None])[0]


def shear_problem(
    frames: Sequence[Series], strips: Sequence[Series], base: Fabric, options: CalibrationOptions
) -> tuple[Problem, ShearModel, dict[str, Scatter]]:
    """The fit of the shear law; at least one test is needed."""
    tests = [(test, False) for test in frames] + [(test, True) for test in strips]
    end = max(float(test.x.max()) for test, _ in tests)
    fewest = min(first_reversal(test.x) for test, _ in tests if test.x.max() > 0.9 * end)
    count = max(2, min(options.knots, fewest // 3))
    knots = np.linspace(0.0, round(end, 6), count + 1)
    unloads = any(test.unloads for test, _ in tests)
    limit_angles = np.linspace(0.0, knots[-1], LIMIT_COUNT) if unloads else np.zeros(1)
    length, width = options.bias_length or 0.0, options.bias_width or 0.0
    model = ShearModel(
        knots, limit_angles, options.friction == "auto", tuple(tests), length, width,
        tuple(_cell_moment(base, test.x) for test, _ in tests),
    )  # fmt: skip
    scatters = {name: scatter_of(found, options.noise) for name, found in ((FRAME, frames), (BIAS, strips)) if found}
    names = tuple(scatters)
    sizes = [len(test.x) for test, _ in tests]
    observed = np.concatenate([test.y for test, _ in tests])
    sigma = np.concatenate([scatters[BIAS if is_bias else FRAME].at(test.x) for test, is_bias in tests])
    group = np.repeat([names.index(BIAS if is_bias else FRAME) for _, is_bias in tests], sizes)
    repeat = np.repeat(np.arange(len(tests)), sizes)
    unknowns = _unknowns(model)
    return Problem(unknowns, model.predict, observed, sigma, group, repeat, names), model, scatters


def _cell_moment(base: Fabric, path: np.ndarray) -> tuple[np.ndarray | float, np.ndarray | float]:
    """What the unit cell itself adds to the moment, with unstretched yarns, at the angles and at half of them [N/m]."""
    if not base.unit_cell.law().depends_on_shear:
        return 0.0, 0.0
    from ..fabric.response import respond

    whole, half = (respond(base.unit_cell, np.ones((len(path), 2)), share * path).moment for share in (1.0, 0.5))
    return whole, half


def _unknowns(model: ShearModel) -> tuple[Unknown, ...]:
    """Knots start at the first test's own loading, friction at what its first degrees show."""
    test, is_bias = model.tests[0]
    x, y = test.loading
    if is_bias:
        whole, half = bias_factors(x, model.length, model.width)
        y = y / (whole + 0.6 * half)
    order = np.argsort(x, kind="stable")
    x, y = x[order], y[order]
    largest = float(np.abs(y).max())
    jump = max(float(np.interp(2.0 * SLIP_ANGLE, x, y)), 0.02 * largest) if model.has_friction else 0.0
    jump = min(jump, 0.5 * largest)
    unknowns = [
        Unknown(
            name, "N/m", f"elastic shear moment at {math.degrees(angle):.3g} degrees",
            max(float(np.interp(angle, x, y)) - jump, 0.01 * largest), 0.0, 1.0e3 * largest, is_log=False, size=largest,
        )
        for name, angle in zip(model.knot_names, model.knots[1:], strict=True)
    ]  # fmt: skip
    if model.has_friction:
        unknowns += [
            Unknown(
                name, "N/m", "moment at which the yarns slip on each other" + (
                    "" if len(model.limit_angles) == 1 else f", at {math.degrees(angle):.3g} degrees"
                ),
                jump, 0.0, 1.0e2 * largest, is_log=False, size=largest,
            )
            for name, angle in zip(model.limit_names, model.limit_angles, strict=True)
        ]  # fmt: skip
        unknowns.append(
            Unknown(SLIP, "rad", "angle over which friction builds up", SLIP_ANGLE, *SLIP_ANGLE_RANGE, is_log=True)
        )
    return tuple(unknowns)


def with_shear(base: Fabric, model: ShearModel, values: np.ndarray) -> tuple[Fabric, list[str]]:
    """The fabric with the fitted law, and what it keeps or leaves out."""
    notes: list[str] = []
    moments, limits, slip_angle = (part[0] for part in model.split(values[None]))
    last = float(model.knots[-1])
    locking: dict[str, float] = {}
    if isinstance(base.shear, MomentCurve):
        locking = {
            "locking_angle": max(base.shear.locking_angle, last),
            "locking_stiffness": base.shear.locking_stiffness, "locking_width": base.shear.locking_width,
        }  # fmt: skip
        if base.shear.locking_angle < last:
            notes.append(
                f"locking starts at {math.degrees(last):.3g} instead of {math.degrees(base.shear.locking_angle):.3g} "
                "degrees: up to there the measured curve has it"
            )
    shear = MomentCurve(angle=tuple(map(_rounded, model.knots)), moment_values=tuple(map(_rounded, moments)), **locking)
    friction = None
    pressed = getattr(base.shear_friction, "crossover_friction_length", 0.0)
    largest = float(moments.max() + limits.max())
    if model.has_friction and (limits.max() > LEAST_FRICTION * largest or pressed > 0.0):
        # it begins where its first limit is reached
        stiffness = float(max(limits[0], LEAST_FRICTION * largest) / slip_angle)
        most = LARGEST_LOCKING_SHARE * min(base.unit_cell.yarn_stiffness_per_width)
        if stiffness > most:
            notes.append(
                f"friction builds up with {most:.4g} N/m, not {stiffness:.4g}: a tenth of the yarn stiffness is allowed"
            )
        friction = ShearFriction(
            stiffness=_rounded(min(stiffness, most)), limit=tuple(map(_rounded, limits)),
            angle=tuple(map(_rounded, model.limit_angles)), crossover_friction_length=pressed,
        )  # fmt: skip
    elif model.has_friction:
        notes.append("the curves begin without a jump: the law has no friction")
    if pressed > 0.0:
        notes.append(f"crossover_friction_length = {pressed:.4g} m is kept: tests without known tension cannot give it")
    return base.model_copy(update={"shear": shear, "shear_friction": friction}), notes


def _rounded(value: float) -> float:
    return float(f"{value:.7g}")
