"""``weavesim calibrate``: tests of a laboratory in, a folder with a fabric file and a report out."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Self

from pydantic import Field, model_validator

from ..calibration import Calibration, CalibrationOptions
from ..calibration.calibration import calibrated
from ..calibration.options import TESTS
from ..calibration.record import REPORT_NAME, check_folder, write_calibration

SPECIMEN = (
    "frame_side", "fabric_side", "frame_convention", "bias_length", "bias_width", "biaxial_width", "cantilever_yarn",
    "bias_largest_angle", "frame_largest_angle", "preload", "offset", "noise", "column",
)  # fmt: skip
PANELS = {
    **dict.fromkeys(TESTS, "Tests; each may be repeated"), **dict.fromkeys(SPECIMEN, "Specimens and tables"),
    **dict.fromkeys(("out", "overwrite", "check_with_scene", "accept_unusual", "name"), "Run"),
}  # fmt: skip


class CalibrateParameters(CalibrationOptions):
    """Fit a fabric to tests of a laboratory, and say how well it is known."""

    out: Path = Field(default=Path("out/calibration"), description="folder for the results")
    overwrite: bool = Field(default=False, description="replace an earlier calibration in that folder")
    check_with_scene: bool = Field(
        default=False, description="simulate the bias extension with the calibrated fabric, and compare"
    )

    @model_validator(mode="after")
    def _can_be_checked(self) -> Self:
        if self.check_with_scene and not self.bias_extension:
            raise ValueError("check_with_scene needs a bias_extension to compare with")
        return self


def calibrate_into_folder(parameters: CalibrateParameters) -> list[str]:
    """Calibrate and write the results; returns lines for the user.

    Raises:
        InputError: bad options or tables, before anything is fitted.
    """
    check_folder(parameters.out, parameters.overwrite)
    names = CalibrationOptions.model_fields
    calibration = calibrated(CalibrationOptions(**{name: getattr(parameters, name) for name in names}))
    if parameters.check_with_scene:
        # scenes are above this package in the layer order
        check = import_module("weavesim.scenes.bias_check").check_bias_extension
        calibration = replace(calibration, check=check(calibration.fabric, calibration))
    path = write_calibration(calibration, parameters.out, overwrite=parameters.overwrite)
    return [*_lines(calibration), f"Fabric: {path}", f"Report: {parameters.out / REPORT_NAME}"]


def _lines(calibration: Calibration) -> list[str]:
    lines = []
    for part, entries in calibration.estimates.items():
        lines.append(f"{part}:")
        for e in entries:
            interval = f"  {e.low:.4g} to {e.high:.4g}" if e.has_interval else ""
            state = "" if e.state == "fitted" else f"  ({e.state})"
            lines.append(f"  {e.name:<28} {e.value:>11.5g} {e.unit:<6}{interval}{state}")
    for r in calibration.residuals:
        lines.append(
            f"{r.test}: residual {r.root_mean_square:.3g} {r.unit}, systematic {r.systematic:.3g}; {r.source} "
            f"{r.scatter:.3g}"
        )
    for name, value in calibration.check.items():
        if isinstance(value, int | float):
            lines.append(f"check with the scene: {name.replace('_', ' ')} {value:.4g}")
    return [*lines, *(f"Warning: {warning}" for warning in calibration.warnings)]
