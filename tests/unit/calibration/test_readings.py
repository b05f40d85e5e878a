"""Tables of tests: read as laboratories write them, or refused before any fit, with file, line and column."""

import math

import numpy as np
import pytest

from tests.support.bad_tests import BAD, STRIP, bias, frame
from weavesim.calibration import CalibrationOptions, calibrate
from weavesim.calibration.fitting import fit as fitting
from weavesim.calibration.readings import (
    bias_factors,
    bias_series,
    biaxial_tests,
    check_moments,
    frame_series,
)
from weavesim.errors import InputError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.scenes.bias_extension import BiasExtensionParameters, closed_form_force


@pytest.fixture
def no_fit(monkeypatch):
    def solve(*arguments, **named):
        raise AssertionError("a fit has begun")

    monkeypatch.setattr(fitting, "solve", solve)


@pytest.mark.parametrize("bad", BAD.values(), ids=BAD)
def test_a_bad_table_is_told_before_the_fit(tmp_path, no_fit, bad):
    path = tmp_path / "test.csv"
    path.write_bytes(bad.text if isinstance(bad.text, bytes) else bad.text.encode())
    with pytest.raises(InputError, match=f"test.csv.*(?:{bad.message})"):
        calibrate("glass-polypropylene", **{bad.test: path}, **bad.options)


def test_there_are_at_least_thirty():
    assert len(BAD) >= 30 and sum("line" in bad.message for bad in BAD.values()) >= 30


def options(tmp_path, text, test="picture_frame", **given):
    path = tmp_path / "test.csv"
    path.write_text(text, encoding="utf-8")
    return CalibrationOptions(fabric="glass-polypropylene", **{test: path}, **given)


def test_a_force_of_the_machine_becomes_the_moment_of_the_law(tmp_path):
    (series,), (file,) = frame_series(options(tmp_path, frame(), frame_side=0.25, fabric_side=0.2))
    angle = np.radians(np.arange(0, 41, 4))
    force = 0.5 * np.degrees(angle) + 0.02 * np.degrees(angle) ** 2
    np.testing.assert_allclose(series.x, angle)
    np.testing.assert_allclose(series.y, force * 0.25 * np.sin(0.25 * math.pi - 0.5 * angle) / 0.04, rtol=1e-6)
    assert len(file.sha256) == 64 and file.byte_count == (tmp_path / "test.csv").stat().st_size


def test_a_displacement_of_the_frame_becomes_its_angle(tmp_path):
    angle = np.radians(np.linspace(0.0, 40.0, 11))
    travel = 2e3 * 0.25 * (np.cos(0.25 * math.pi - 0.5 * angle) - math.sqrt(0.5))
    rows = "".join(f"{d:.9g},{k * k}\n" for k, d in enumerate(travel))
    (series,), _ = frame_series(options(tmp_path, "crosshead [mm],load [N]\n" + rows, frame_side=0.25))
    np.testing.assert_allclose(series.x, angle, atol=1e-8)


def test_a_strip_up_to_the_trusted_angle(tmp_path):
    given = options(tmp_path, bias(), "bias_extension", **STRIP)
    (series,), _ = bias_series(given)
    assert np.degrees(series.x.max()) < 35.0
    short, _ = bias_series(given.model_copy(update={"bias_largest_angle": 20.0}))
    assert len(short[0].x) < len(series.x) and "beyond 20 degrees left out" in short[0].notes[-1]


def test_the_factors_of_a_strip_are_those_of_the_scene():
    fabric = glass_polypropylene()
    parameters = BiasExtensionParameters(length=0.23, width=0.115)
    displacement = 0.03
    diagonal = parameters.zone_length
    angle = 0.5 * math.pi - 2.0 * math.acos((diagonal + displacement) / (math.sqrt(2.0) * diagonal))
    whole, half = bias_factors(np.array([angle]), 0.23, 0.115)
    moments = fabric.shear.moment(np.array([angle, 0.5 * angle]))
    force = float(whole[0] * moments[0] + half[0] * moments[1])
    assert force == pytest.approx(closed_form_force(parameters, fabric, displacement), rel=1e-9)


def test_preload_and_slack_of_a_machine(tmp_path):
    text = "displacement [mm],force [N]\n" + "".join(
        f"{d},{max(0.0, 0.3 * (d - 5) + 0.01 * (d - 5) ** 2):.5g}\n" for d in range(0, 36)
    )
    (slack,), _ = bias_series(options(tmp_path, text, "bias_extension", **STRIP))
    (taut,), _ = bias_series(options(tmp_path, text, "bias_extension", preload=0.25, **STRIP))
    assert np.flatnonzero(slack.y)[0] > 4 and taut.y[0] > 0.25 and taut.x[0] == 0.0
    assert "preload of 0.25 N" in " ".join(taut.notes)


def test_a_crosshead_that_does_not_begin_at_zero(tmp_path):
    text = "displacement [mm],force [N]\n" + "".join(f"{d + 12},{0.2 * d + 0.01 * d**2:.5g}\n" for d in range(25))
    (series,), _ = bias_series(options(tmp_path, text, "bias_extension", **STRIP))
    assert series.x[0] == 0.0 and "begin at 12 mm" in " ".join(series.notes)


def test_an_unloading_in_its_own_column_is_part_of_the_path(tmp_path):
    text = "angle [deg],force [N/m],force unloading [N/m]\n" + "".join(
        f"{a},{0.5 * a + (a > 0):.3f},{0.4 * a - 1:.3f}\n" for a in range(0, 41, 4)
    )
    (series,), _ = frame_series(options(tmp_path, text))
    assert series.unloads and len(series.x) == 22 and series.lines[11] == 12


def test_biaxial_forces_per_width(tmp_path):
    header = "warp strain [%],weft strain [%],warp force [kN],weft force [kN]\n"
    rows = "".join(f"{0.1 * k},{0.05 * k},{0.2 * k},{0.1 * k}\n" for k in range(8))
    (test,), _ = biaxial_tests(options(tmp_path, header + rows, "biaxial", biaxial_width=0.1))
    np.testing.assert_allclose(test.strain[-1], [0.007, 0.0035])
    np.testing.assert_allclose(test.force[-1], [14000.0, 7000.0])


def test_columns_by_the_name_that_the_user_gives(tmp_path):
    text = frame("Sigma-7 [deg],K9 [N/m]")
    (series,), _ = frame_series(options(tmp_path, text, column=("angle=Sigma-7", "force=K9")))
    assert len(series.x) == 11
    with pytest.raises(InputError, match="fource is no role; did you mean 'force'"):
        frame_series(options(tmp_path, text, column="fource=K9"))
    with pytest.raises(InputError, match="write ROLE=NAME"):
        frame_series(options(tmp_path, text, column="K9"))


def test_unusual_values_may_be_meant(tmp_path):
    text = frame("angle [deg],force [kN]", scale=10.0)
    given = options(tmp_path, text, frame_side=0.25, accept_unusual=True)
    series, _ = frame_series(given)
    check_moments(series, lambda test: test.y, accept_unusual=True)
