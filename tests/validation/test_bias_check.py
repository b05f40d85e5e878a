"""The check of a calibration with the scene of the bias extension."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.synthetic_laboratory import BIAS_LENGTH, BIAS_WIDTH, Laboratory, bias_extension, random_fabric
from weavesim.calibration import calibrate
from weavesim.calibration.pictures import check_figure
from weavesim.scenes.bias_check import check_bias_extension


@pytest.mark.slow
def test_the_simulated_strip_follows_the_closed_form(tmp_path):
    laboratory = Laboratory(noise=0.002, specimen=0.01, repeat_count=3)
    path = bias_extension(random_fabric(2), laboratory, tmp_path)
    found = calibrate(
        "glass-polypropylene-polynomial", bias_extension=path, bias_length=BIAS_LENGTH, bias_width=BIAS_WIDTH,
        bias_largest_angle=25.0, friction="none",
    )  # fmt: skip
    check = check_bias_extension(found.fabric, found)
    assert check["kinematic_angle_deg"] == pytest.approx(25.0, abs=0.2)
    # eight elements across: the mesh shears less, by about one element in the length of the trellis
    assert 0.88 < check["zone_c_angle_deg"] / check["kinematic_angle_deg"] < 0.97
    assert check["simulation_from_closed_form"] < 0.06
    # the fit follows the measurement, so the simulation is as far from both
    assert check["simulation_from_measurement"] == pytest.approx(check["simulation_from_closed_form"], abs=0.01)
    curves = check["curves"]
    assert np.all(np.isfinite(curves["force_n"])) and len(curves["force_n"]) == len(curves["measured_force_n"])
    (chart,) = check_figure(replace(found, check=check)).axes
    assert len(chart.lines) == 3
