"""The shear law of frames and strips against tests whose law is known."""

import math

import numpy as np
import pytest

from tests.support.synthetic_laboratory import (
    BIAS_LENGTH,
    BIAS_WIDTH,
    FABRIC_SIDE,
    FRAME_SIDE,
    Laboratory,
    bias_extension,
    moment,
    picture_frame,
    random_fabric,
    write_columns,
)
from weavesim.calibration import calibrate
from weavesim.fabric.closed_forms import moment_along

EXACT = Laboratory(noise=0.0, specimen=0.0, repeat_count=1)
SIDES = {"frame_side": FRAME_SIDE, "fabric_side": FABRIC_SIDE}
STRIP = {"bias_length": BIAS_LENGTH, "bias_width": BIAS_WIDTH}


@pytest.fixture(scope="module")
def loop(tmp_path_factory):
    """A fabric, and its calibration with an exact loop of a frame."""
    true = random_fabric(1)
    path = picture_frame(true, EXACT, tmp_path_factory.mktemp("loop"))
    return true, calibrate("glass-polypropylene-polynomial", picture_frame=path, **SIDES)


def test_an_exact_loop_gives_curve_and_friction(loop):
    true, found = loop
    angle = np.radians(np.linspace(3.0, 45.0, 40))
    np.testing.assert_allclose(found.fabric.shear.moment(angle), true.shear.moment(angle), rtol=0.02, atol=0.3)
    limit, slope = true.shear_friction.limit[0], true.shear_friction.stiffness
    for entry in found.estimates["shear"]:
        if entry.name.startswith("friction_limit"):
            assert entry.value == pytest.approx(limit, rel=0.05)
    assert found.estimate("slip_angle").value == pytest.approx(limit / slope, rel=0.1)
    assert not found.assumed


def test_the_law_predicts_the_loop_as_the_fit_does(loop):
    """What a run gets is what was fitted."""
    _, found = loop
    (series,) = found.shear.frames
    law = moment_along(found.fabric, series.x)
    np.testing.assert_allclose(law, found.shear.reduced.fit.predicted, rtol=1e-4, atol=0.05)


def test_a_strip_alone_gives_the_law_that_its_zones_mix(tmp_path):
    true = random_fabric(2)
    path = bias_extension(true, EXACT, tmp_path)
    found = calibrate("glass-polypropylene-polynomial", bias_extension=path, **STRIP)
    angle = np.radians(np.linspace(5.0, 34.0, 30))
    np.testing.assert_allclose(moment_along(found.fabric, angle), moment(true, angle), rtol=0.03)
    assert found.residuals[0].root_mean_square < 0.01 * found.residuals[0].largest


def test_loading_alone_takes_the_jump_for_friction_and_says_so(tmp_path):
    true = random_fabric(3)
    angle = np.radians(np.concatenate([np.linspace(0.0, 4.0, 17), np.linspace(5.0, 45.0, 41)]))
    path = write_columns(
        tmp_path / "frame.csv",
        {"angle [deg]": np.degrees(angle), "normalised force [N/m]": moment(true, angle) / np.cos(angle)},
    )
    found = calibrate("glass-polypropylene-polynomial", picture_frame=path)
    assert found.estimate("friction_limit").value == pytest.approx(true.shear_friction.limit[0], rel=0.15)
    assert found.assumed == ("shear: split of friction and elastic curve",)
    assert any("no unloading was measured" in warning and "correlation" in warning for warning in found.warnings)
    assert found.fabric.origin_of("shear_friction.limit").assumed
    elastic = calibrate("glass-polypropylene-polynomial", picture_frame=path, friction="none")
    assert elastic.fabric.shear_friction is None and elastic.assumed == ("shear: no friction",)
    assert elastic.fabric.origin_of("shear_friction").assumed
    # the forces of a loading hardly depend on the split, but a jump without friction is fitted badly
    late = angle > math.radians(8.0)
    both = (moment_along(c.fabric, angle)[late] for c in (found, elastic))
    np.testing.assert_allclose(*both, rtol=0.03, atol=1.0)


def test_a_law_that_cannot_follow_is_said(tmp_path):
    angle = np.radians(np.linspace(0.0, 45.0, 91))
    waves = 20.0 * np.degrees(angle) / 45.0 + 6.0 * np.sin(angle * 30.0) ** 2
    path = write_columns(tmp_path / "frame.csv", {"angle [deg]": np.degrees(angle), "force [N/m]": waves})
    found = calibrate("glass-polypropylene-polynomial", picture_frame=path, knots=4)
    assert any("a bad fit" in warning for warning in found.warnings) and found.residuals[0].ratio > 1.0


def test_frames_and_strips_that_contradict_each_other_are_said(tmp_path):
    true = random_fabric(4)
    soft = true.model_copy(update={"shear": true.shear.model_copy(
        update={"moment_values": tuple(0.5 * m for m in true.shear.moment_values)})})  # fmt: skip
    laboratory = Laboratory(noise=0.01, specimen=0.01, repeat_count=3)
    frames, strips = picture_frame(true, laboratory, tmp_path), bias_extension(soft, laboratory, tmp_path)
    found = calibrate("glass-polypropylene-polynomial", picture_frame=frames, bias_extension=strips, **SIDES, **STRIP)
    assert any("contradict each other: the bias extension is softer" in warning for warning in found.warnings)
    agreeing = calibrate(
        "glass-polypropylene-polynomial", picture_frame=frames, **SIDES, **STRIP,
        bias_extension=bias_extension(true, laboratory, tmp_path),
    )  # fmt: skip
    assert not any("contradict" in warning for warning in agreeing.warnings)


def test_nothing_is_fitted_beyond_the_data(loop):
    _, found = loop
    assert found.fabric.shear.trusted_angle == pytest.approx(math.radians(45.0), rel=1e-4)
    assert found.fabric.shear.locking_angle >= found.fabric.shear.trusted_angle
