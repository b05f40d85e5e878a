"""Calibrations as a whole: laboratories' frames, and random fabrics whose values are known."""

import math
from pathlib import Path

import numpy as np
import pytest

import weavesim
from tests.support.coverage_study import Study
from tests.support.synthetic_laboratory import Laboratory
from weavesim.calibration import calibrate
from weavesim.fabric.closed_forms import moment_along
from weavesim.fabric.presets import glass_polypropylene

DATA = Path(weavesim.__file__).parent / "fabric" / "data" / "cao2008"
LABORATORIES = ("hkust", "kul_1st", "lmsp", "uml", "ut")


@pytest.fixture(scope="module")
def laboratories():
    """The calibration of each laboratory's picture frame."""
    return {
        name: calibrate("glass-polypropylene-polynomial", picture_frame=DATA / f"frame_{name}.csv")
        for name in LABORATORIES
    }


def test_every_laboratory_is_fitted_closer_than_they_agree(laboratories):
    """Root mean square residual of each against the standard deviation among laboratories at the same angles."""
    angle = np.radians(np.arange(1.0, 34.0, 0.5))
    curves = []
    for name in LABORATORIES:
        (series,) = laboratories[name].shear.frames
        curves.append(np.interp(angle, series.x, series.y))
    among = np.std(curves, axis=0, ddof=1)
    for name, curve in zip(LABORATORIES, curves, strict=True):
        fitted = moment_along(laboratories[name].fabric, np.concatenate([[0.0], angle]))[1:]
        residual = float(np.sqrt(np.mean((fitted - curve) ** 2)))
        assert residual < 0.25 * float(np.sqrt(np.mean(among**2))), name
        assert not any("bad fit" in warning for warning in laboratories[name].warnings), name


def test_the_jump_of_each_laboratory_is_its_friction(laboratories):
    """Between 3 and 17 N/m in all but the conditioned specimen of HKUST, which has none."""
    limits = {name: found.estimate("friction_limit") for name, found in laboratories.items()}
    assert limits["hkust"].value == 0.0 and laboratories["hkust"].fabric.shear_friction is None
    for name in LABORATORIES[1:]:
        assert 3.0 < limits[name].value < 17.5, name


def test_everything_else_is_that_of_the_given_fabric(laboratories):
    found = laboratories["ut"]
    for name in ("unit_cell", "bending", "thickness", "areal_density", "compaction"):
        assert getattr(found.fabric, name) == getattr(found.base, name)
    assert "frame_ut.csv (SHA-256" in found.fabric.source and found.fabric.origin_of("shear.moment_values")
    assert math.degrees(found.fabric.shear.trusted_angle) == pytest.approx(34.0, abs=0.01)


def test_intervals_contain_the_true_values_about_as_often_as_they_say(tmp_path):
    """Few fabrics; the verification study has a hundred."""
    study = Study.run(range(2), tmp_path, Laboratory(repeat_count=4, point_count=32))
    # 19 values each, those of a fabric correlated: 95 % of 38 are 36
    assert 34 <= study.value_count <= 38
    assert study.coverage() > 0.8


def test_a_loop_of_a_preset_is_not_touched_by_what_the_preset_assumes(tmp_path):
    base = glass_polypropylene()
    path = tmp_path / "given.toml"
    path.write_text(base.to_toml(), encoding="utf-8")
    found = calibrate(path, bending_length=(0.04, 0.041))
    assert found.fabric.shear == base.shear and found.fabric.unit_cell == base.unit_cell
    assert found.fabric.origin_of("bending.modulus").source.startswith("bending, calibrated by weavesim")
    assert "sheet bending" not in found.fabric.assumed
