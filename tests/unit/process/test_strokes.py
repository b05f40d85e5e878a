"""Motion curves."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.process.strokes import ForceDriven, SmoothStroke, Stroke
from weavesim.process.supports import Drive


def test_smooth_stroke_is_smooth_and_ends_where_it_should():
    stroke = SmoothStroke.ramped(-0.01, speed=0.5, ramp_time=4e-3, start_time=1e-3)
    drive = Drive(stroke, (1.0, 0.0, 0.0))
    assert stroke.duration == pytest.approx(1e-3 + 0.02 + 4e-3)
    times = np.linspace(-1e-3, stroke.duration + 1e-3, 4001)
    way = np.array([drive.at(t) for t in times])
    speed = np.gradient(way, times)
    assert way[0] == 0.0 and way[-1] == pytest.approx(-0.01, abs=1e-15)
    assert speed.min() == pytest.approx(-0.5, rel=1e-6)
    # 0.5 m/s within 4 ms, at most 1.5 times as steep as the mean
    assert np.abs(np.gradient(speed, times)).max() == pytest.approx(1.5 * 0.5 / 4e-3, rel=1e-2)
    there_and_back = stroke.and_back(rest=2e-3)
    assert there_and_back.duration == pytest.approx(0.001 + 2.0 * 0.024 + 2e-3)
    assert there_and_back.displacements[-1] == 0.0
    assert Drive(Stroke((0.0, 1.0), (0.0, 0.3)), (1.0, 0.0, 0.0)).initial_speed == pytest.approx(0.3)


@pytest.mark.parametrize("ramp_time", [-0.1, np.nan, np.inf])
def test_a_ramp_time_that_is_none_is_refused(ramp_time):
    with pytest.raises(InputError, match="ramp_time"):
        ForceDriven.constant(1.0, 1.0, ramp_time)
