"""A calibration: from tests to a fabric, with what is held, and what is wrong."""

from __future__ import annotations

import math
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from ..checks import as_typed
from ..errors import InputError, did_you_mean
from ..fabric.fabric import Fabric
from ..fabric.file import resolve_fabric
from ..input_files import shown
from ..ranges import check_usual
from ..version import __version__
from .bending import estimates, strips, trend, with_bending
from .cell import BIAXIAL, cell_problem
from .fitting.fit import LEAST_REPEAT_COUNT, Fit
from .fitting.reduction import Reduced, fit_reduced
from .options import CalibrationOptions
from .origins import with_origins
from .readings import DataFile, bias_factors, bias_series, biaxial_tests, check_moments, frame_series
from .result import (
    AT_BOUND,
    FITTED,
    BendingPart,
    Calibration,
    CellPart,
    Estimate,
    Residual,
    ShearPart,
    estimates_of,
    residual_of,
)
from .scatter import Scatter
from .series import Series
from .shear import BIAS, FRAME, FRICTION, SLIP, shear_problem, with_shear

# A misfit that is said: the systematic residual over the scatter of repeats or the stated noise.
LARGEST_MISFIT = 1.0
# Starts of the shear fit, which is nearly linear.
SHEAR_START_COUNT = 2


def calibrate(fabric: str | Path, **options: Any) -> Calibration:
    """Fit the parameters of a fabric to its tests; ``docs/tutorial_calibration.md`` shows one from end to end.

    Args:
        fabric: preset or fabric file: what is known already, and where fits start.
        options: fields of ``CalibrationOptions``, such as ``picture_frame="frame.csv"``, ``frame_side=0.25``.

    Raises:
        InputError: options or tables that are wrong, before anything is fitted; with file, line and column.
    """
    return calibrated(CalibrationOptions(fabric=str(fabric), **options))


def calibrated(options: CalibrationOptions) -> Calibration:
    """The calibration of these options; see ``calibrate``."""
    if not options.accept_unusual:
        try:
            check_usual(options)
        except ValueError as error:
            raise InputError(str(error)) from None
    base = resolve_fabric(options.fabric, accept_unusual=options.accept_unusual)
    work = _Work(options, base)
    # everything is read and checked before anything is fitted
    work.read()
    work.fit()
    return work.result()


class _Work:
    """Collects the parts of a calibration."""

    def __init__(self, options: CalibrationOptions, base: Fabric) -> None:
        self.options, self.base, self.fabric = options, base, base
        self.warnings: list[str] = []
        self.notes: list[str] = []
        self.assumed: list[str] = []
        self.files: list[DataFile] = []
        self.estimates: dict[str, tuple[Estimate, ...]] = {}
        self.residuals: list[Residual] = []
        self.shear: ShearPart | None = None
        self.cell: CellPart | None = None
        self.bending: BendingPart | None = None

    def read(self) -> None:
        options = self.options
        self.frames, files = frame_series(options) if options.picture_frame else ([], [])
        self.files += files
        self.bias, files = bias_series(options) if options.bias_extension else ([], [])
        self.files += files
        self.biaxial, files = biaxial_tests(options) if options.biaxial else ([], [])
        self.files += files
        self.strips, files = strips(options, self.base)
        self.files += files
        check_moments(self.frames, lambda test: test.y, options.accept_unusual)
        check_moments(self.bias, self._bias_moment, options.accept_unusual)
        for test in (*self.frames, *self.bias):
            self.notes += [f"{test.place}: {note}" for note in test.notes]
        for file in self.files:
            self.notes += [f"{shown(Path(file.path).name)}: {note}" for note in file.notes]
        if self.biaxial:
            self.cell_problem = cell_problem(self.biaxial, self.base.unit_cell, options)
            known = [unknown.name for unknown in self.cell_problem[0].unknowns]
            for name in options.fit:
                if name not in known:
                    raise InputError(
                        f"{as_typed('fit')} = {name!r}: one of {', '.join(known)} is needed{did_you_mean(name, known)}"
                    )
        elif options.fit:
            raise InputError(f"{as_typed('fit')} names parameters of the unit cell, which only biaxial tests give")

    def _bias_moment(self, test: Series) -> np.ndarray:
        whole, half = bias_factors(test.x, self.options.bias_length or 0.0, self.options.bias_width or 0.0)
        return test.y / (whole + half)

    def fit(self) -> None:
        if self.biaxial:
            self._fit_cell()
        if self.frames or self.bias:
            self._fit_shear()
        if self.strips:
            self._fit_bending()

    # -------------------------------------------------------------------------------------------------------- unit cell

    def _fit_cell(self) -> None:
        problem, model, scatters = self.cell_problem
        options = self.options
        names = [unknown.name for unknown in problem.unknowns]
        held = [name for name in names if options.fit and name not in options.fit]
        reduced = fit_reduced(
            problem, held=held, keep_all=options.full or bool(options.fit), starts=options.starts, seed=options.seed,
            held_uncertainty=options.held_uncertainty,
        )  # fmt: skip
        self.cell = CellPart(reduced, model, scatters, tuple(self.biaxial))
        fit = reduced.fit
        self.estimates["unit cell"] = tuple(estimates_of(fit, [u.start for u in problem.unknowns]))
        self.fabric = self.fabric.model_copy(update={"unit_cell": model.cell(fit.values)})
        self._residuals(fit, BIAXIAL, "N/m", scatters, np.ones(len(problem.observed), dtype=bool))
        self._weakness(reduced)
        self.assumed += [f"unit_cell: {names[k]}" for k in np.flatnonzero(~fit.is_free)]
        if len(fit.costs) > 1 and fit.same_minimum == 1:
            self.warnings.append(
                f"unit cell: only one of {len(fit.costs)} starts found this minimum; others are worse by "
                f"{fit.costs[1] / max(fit.cost, 1e-300) - 1.0:.0%} or more: give more starts, or better ones"
            )
        self.warnings += [f"unit cell: {text}" for text in self.fabric.unit_cell.warnings()]

    def _weakness(self, reduced: Reduced) -> None:
        """What the data cannot tell apart."""
        names = {k: unknown.name for k, unknown in enumerate(reduced.whole.problem.unknowns)}
        if not reduced.held:
            return
        condition = reduced.whole.condition
        whole = dict(zip(names.values(), reduced.whole.values.tolist(), strict=True))
        loose = ", ".join(f"{name} (fitted freely: {whole[name]:.3g})" for name in reduced.held)
        if reduced.fit is reduced.whole:
            action = "they were fitted all the same, as asked: do not trust them one by one"
        else:
            action = (
                "held at the values of the given fabric, and the rest was fitted again; "
                f"{as_typed('full')} keeps the whole set"
            )
        self.warnings.append(
            f"unit cell: the data cannot tell {loose}; the condition number of all parameters together is "
            f"{condition:.2g}; {action}"
        )
        fit = reduced.fit
        if reduced.fit is not reduced.whole and fit.chosen.size:
            held = np.flatnonzero(~fit.is_free)
            for column, k in enumerate(held):
                effect = fit.effect_of_held[:, column]
                changes = ", ".join(
                    f"{names[int(i)]} {0.1 * e:+.1%}"
                    for i, e in zip(fit.chosen, effect, strict=True)
                    if abs(e) > 0.01 and fit.problem.unknowns[int(i)].is_log
                )
                self.notes.append(
                    f"unit cell: {names[int(k)]} is held at {fit.values[k]:.4g}; 10 % more would change "
                    f"{changes or 'nothing else by 0.1 % or more'}"
                )

    # ------------------------------------------------------------------------------------------------------------ shear

    def _fit_shear(self) -> None:
        problem, model, scatters = shear_problem(self.frames, self.bias, self.base, self.options)
        is_loop = any(test.unloads for test in (*self.frames, *self.bias))
        held = [] if is_loop or not model.has_friction else self._held_slip()
        reduced = fit_reduced(problem, held=held, starts=SHEAR_START_COUNT, seed=self.options.seed)
        fit = reduced.fit
        self.shear = ShearPart(reduced, model, scatters, tuple(self.frames), tuple(self.bias))
        given = [
            float(self.base.shear.moment(np.array([angle]), self.base.thickness)[0])
            for angle in model.knots[1:].tolist()
        ]
        if model.has_friction:
            limit = getattr(self.base.shear_friction, "limit_at", None)
            given += [float(limit(np.array([angle]))[0]) if limit else 0.0 for angle in model.limit_angles.tolist()] + [
                math.nan
            ]
        self.estimates["shear"] = tuple(estimates_of(fit, given))
        self.fabric, notes = with_shear(self.fabric, model, fit.values)
        self.notes += [f"shear: {note}" for note in notes]
        if model.has_friction and not is_loop and self.fabric.shear_friction is not None:
            self.assumed.append("shear: split of friction and elastic curve")
            self.warnings.append(
                "shear: no unloading was measured, so the initial jump is taken for friction: forces while shearing do "
                f"not depend on that{_correlation_of_split(fit)}, but springback and losses do; measure a loop, or "
                f"give {as_typed('friction')} = none"
            )
        if self.fabric.shear_friction is not None and not self._is_free(fit, SLIP):
            self.assumed.append("shear: angle over which friction builds up")
            self.notes.append(
                f"shear: {SLIP} is held at {fit.values[-1]:.3g} rad: the data do not show how friction builds up"
            )
        if not model.has_friction:
            self.assumed.append("shear: no friction")
        for name, unit, tests in ((FRAME, "N/m", self.frames), (BIAS, "N", self.bias)):
            if tests:
                self._residuals(fit, name, unit, scatters, problem.group == problem.group_names.index(name))
        self._contradiction(fit)

    @staticmethod
    def _is_free(fit: Fit, name: str) -> bool:
        return any(u.name == name and free for u, free in zip(fit.problem.unknowns, fit.is_free, strict=True))

    def _held_slip(self) -> list[str]:
        """The slip angle, if no point lies where friction builds up."""
        tests = [*self.frames, *self.bias]
        early = sum(int(np.sum((test.x > 0.0) & (test.x < math.radians(3.0)))) for test in tests)
        return [SLIP] if early < 4 else []

    def _contradiction(self, fit: Fit) -> None:
        """Frames and strips that want different laws."""
        if not (self.frames and self.bias):
            return
        means = []
        for group in range(2):
            rows = fit.problem.group == group
            means.append(float(np.mean(fit.residual[rows] * np.sign(fit.problem.observed[rows]))))
        if means[0] * means[1] < 0.0 and min(map(abs, means)) > 0.5:
            softer = FRAME if means[0] > 0.0 else BIAS
            self.warnings.append(
                f"shear: picture frame and bias extension contradict each other: the {softer} is softer than both "
                "together say; tension of the yarns in the frame, or slip in the strip, is in one of them"
            )

    # ---------------------------------------------------------------------------------------------------------- bending

    def _fit_bending(self) -> None:
        found = estimates(self.strips)
        self.bending = BendingPart(tuple(self.strips), tuple(found))
        yarns: dict[str, Any] = {"both": "warp", "warp": "warp", "weft": "weft"}
        self.estimates["bending"] = tuple(
            Estimate(
                "bending_stiffness" if e.yarn == "both" else f"{e.yarn}_bending_stiffness", "N m",
                f"bending stiffness per width of {e.count} specimen{'s' if e.count > 1 else ''}", e.value,
                e.low, e.high, FITTED, self.base.bending.strip_stiffness(yarns[e.yarn], self.base.thickness),
            )
            for e in found
        )  # fmt: skip
        for e in found:
            if e.count < 2:
                self.warnings.append(f"bending: one specimen of {e.yarn}: no interval can be stated")
        if text := trend(self.strips):
            self.warnings.append(text)
        self.fabric, notes, assumed = with_bending(self.fabric, found)
        self.notes += notes
        self.assumed += assumed

    # ----------------------------------------------------------------------------------------------------------- common

    def _residuals(self, fit: Fit, test: str, unit: str, scatters: dict[str, Scatter], rows: np.ndarray) -> None:
        problem = fit.problem
        residual = residual_of(
            test, unit, fit.predicted[rows] - problem.observed[rows], problem.repeat[rows],
            float(np.abs(problem.observed[rows]).max()), scatters[test],
        )  # fmt: skip
        self.residuals.append(residual)
        if residual.ratio > LARGEST_MISFIT:
            self.warnings.append(
                f"{test}: a bad fit: the systematic residual is {residual.systematic:.3g} {unit} "
                f"({residual.systematic / residual.largest:.1%} of the largest value), {residual.ratio:.2g} times the "
                f"{residual.source}: the law cannot follow these data"
            )
        groups = [rows & (problem.group == group) for group in np.unique(problem.group[rows])]
        fewest = min(len(np.unique(problem.repeat[own])) for own in groups)
        if fewest < LEAST_REPEAT_COUNT:
            self.notes.append(
                f"{test}: fewer than three repeats: the intervals take the deviations of the points for independent, "
                "and do not contain the scatter among specimens"
            )

    def result(self) -> Calibration:
        if not self.options.accept_unusual:
            try:
                check_usual(self.fabric)
            except ValueError as error:
                self.warnings.append(f"the calibrated fabric: {error}".split("\nIf this is meant")[0])
        for part, entries in self.estimates.items():
            self.warnings += [
                f"{part}: {e.name} ended at its bound, {e.value:.4g} {e.unit}: it has no interval"
                for e in entries
                if e.state == AT_BOUND and not (e.name.startswith(FRICTION) and e.value == 0.0)
            ]
        date = datetime.now(UTC).isoformat(timespec="seconds")
        sources = "; ".join(
            f"{file.test.replace('_', ' ')} {shown(Path(file.path).name)} (SHA-256 {file.sha256[:12]})"
            for file in self.files
        )
        if self.options.bending_length:
            sources = "; ".join(filter(None, [sources, "bending lengths as given"]))
        source = (
            f"calibrated by weavesim {__version__} on {date[:10]} from {sources}; everything else as in "
            f"{self.base.name!r}" + (f" ({self.base.source})" if self.base.source else "")
        )
        kept = [name for name in self.base.assumed if not self._is_measured(name)]
        kept = ["everything that no test gave" if name == "everything" else name for name in kept]
        fabric = self.fabric.model_copy(
            update={
                "name": self.options.name or f"{self.base.name}, calibrated"[:200], "source": source,
                "assumed": tuple(dict.fromkeys([*kept, *self.assumed])),
            }
        )  # fmt: skip
        fabric = with_origins(fabric, self.estimates, self.options, tuple(self.files), date, tuple(self.assumed))
        return Calibration(
            fabric, self.base, self.options, self.estimates, tuple(self.residuals), tuple(self.warnings),
            tuple(dict.fromkeys(self.notes)), tuple(dict.fromkeys(self.assumed)), tuple(self.files), date, self.shear,
            self.cell, self.bending,
        )  # fmt: skip

    def _is_measured(self, name: str) -> bool:
        """Whether an entry of the given fabric's ``assumed`` is no longer so."""
        fitted = {e.name for part in self.estimates.values() for e in part if e.state == FITTED}
        by_entry = {
            "sheet bending": bool(self.bending), "yarn bending": "yarn_bending" in fitted,
            "contact stiffness": "contact_stiffness" in fitted, "crimp": "crossover_height" in fitted,
            "shear": bool(self.shear), "everything": False,
        }  # fmt: skip
        return by_entry.get(name, False)


def _correlation_of_split(fit: Fit) -> str:
    """How strongly friction and elastic moments stand for each other, in words."""
    names = [fit.problem.unknowns[int(k)].name for k in fit.chosen]
    friction = [k for k, name in enumerate(names) if name.startswith(FRICTION)]
    elastic = [k for k, name in enumerate(names) if name.startswith("moment_at")]
    if not friction or not elastic:
        return ""
    strongest = float(fit.correlation[np.ix_(friction, elastic)].min())
    return f" (their correlation with the elastic moments is down to {strongest:.2f})"
