"""What a calibration gives: values with intervals, residuals, the fabric."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..fabric.fabric import Fabric
from .bending import BendingEstimate, Strip
from .cell import CellModel
from .fitting.fit import Fit
from .fitting.reduction import Reduced
from .options import CalibrationOptions
from .readings import Biaxial, DataFile
from .scatter import Scatter
from .series import Series
from .shear import ShearModel

FITTED, HELD, AT_BOUND = "fitted", "held", "at its bound"
# Parts of a test, by whose means the systematic residual is told.
RESIDUAL_BINS = 15


@dataclass(frozen=True)
class Estimate:
    """A calibrated value.

    Attributes:
        name, unit, meaning: of the value.
        value: found, or held.
        low, high: interval that contains the true value in 95 % of calibrations; NaN where there is none.
        state: "fitted", "held" or "at its bound".
        given: in the fabric that was given; NaN if it has no such value.
    """

    name: str
    unit: str
    meaning: str
    value: float
    low: float
    high: float
    state: str
    given: float

    @property
    def has_interval(self) -> bool:
        """Whether the data tell its interval."""
        return math.isfinite(self.low)


@dataclass(frozen=True)
class Residual:
    """How well a kind of test is fitted, in the unit of what was measured.

    Attributes:
        test, unit: kind of test and unit.
        root_mean_square: of all residuals.
        systematic: root mean square of what is common to neighbouring points and repeats.
        scatter: of the repeats, or the noise, see ``source``.
        largest: value that was measured.
        source: of the scatter.
    """

    test: str
    unit: str
    root_mean_square: float
    systematic: float
    scatter: float
    largest: float
    source: str

    @property
    def ratio(self) -> float:
        """Systematic residual over scatter."""
        return self.systematic / self.scatter


@dataclass(frozen=True)
class ShearPart:
    """Fit of the shear law."""

    reduced: Reduced
    model: ShearModel
    scatters: dict[str, Scatter]
    frames: tuple[Series, ...]
    strips: tuple[Series, ...]


@dataclass(frozen=True)
class CellPart:
    """Fit of the unit cell."""

    reduced: Reduced
    model: CellModel
    scatters: dict[str, Scatter]
    tests: tuple[Biaxial, ...]


@dataclass(frozen=True)
class BendingPart:
    """Bending stiffnesses."""

    strips: tuple[Strip, ...]
    estimates: tuple[BendingEstimate, ...]


@dataclass(frozen=True)
class Calibration:
    """What ``calibrate`` returns.

    Attributes:
        fabric: calibrated.
        base: the fabric that was given.
        options: of the calibration.
        estimates: all values, by part ("unit cell", "shear", "bending").
        residuals: of each kind of test that was fitted.
        warnings: what a reader must know before using the fabric.
        notes: what was done to the data, and what was kept.
        assumed: names of values that no test gave.
        files: of the tests.
        date: of the calibration, UTC.
    """

    fabric: Fabric
    base: Fabric
    options: CalibrationOptions
    estimates: dict[str, tuple[Estimate, ...]]
    residuals: tuple[Residual, ...]
    warnings: tuple[str, ...]
    notes: tuple[str, ...]
    assumed: tuple[str, ...]
    files: tuple[DataFile, ...]
    date: str
    shear: ShearPart | None = None
    cell: CellPart | None = None
    bending: BendingPart | None = None
    check: dict[str, Any] = field(default_factory=dict)

    def estimate(self, name: str) -> Estimate:
        """A value by its name.

        Raises:
            KeyError: no such value.
        """
        return next(e for part in self.estimates.values() for e in part if e.name == name)


def residual_of(
    test: str, unit: str, difference: np.ndarray, repeat: np.ndarray, largest: float, scatter: Scatter
) -> Residual:
    """Size of residuals (n,), and of their part that neighbours and repeats share."""
    bins = []
    for r in np.unique(repeat):
        own = difference[repeat == r]
        bins.append([float(part.mean()) for part in np.array_split(own, min(RESIDUAL_BINS, len(own)))])
    width = min(map(len, bins))
    common = (
        np.mean([row[:width] for row in bins], axis=0) if len({len(row) for row in bins}) == 1 else np.concatenate(bins)
    )
    return Residual(
        test, unit, float(np.sqrt(np.mean(difference**2))), float(np.sqrt(np.mean(np.square(common)))),
        scatter.yardstick, largest, scatter.source,
    )  # fmt: skip


def estimates_of(fit: Fit, given: Sequence[float]) -> list[Estimate]:
    """The estimate of every unknown of a fit; ``given`` are their values before it."""
    result = []
    for k, unknown in enumerate(fit.problem.unknowns):
        low, high = fit.interval(k)
        state = HELD if not fit.is_free[k] else AT_BOUND if fit.at_bound[k] else FITTED
        result.append(
            Estimate(
                unknown.name, unknown.unit, unknown.meaning, float(fit.values[k]), low, high, state, float(given[k])
            )
        )
    return result
