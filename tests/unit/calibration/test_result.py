"""Residuals: what is common to neighbours and repeats is systematic."""

import numpy as np
import pytest

from weavesim.calibration.result import residual_of
from weavesim.calibration.scatter import Scatter

SCATTER = Scatter(np.array([0.0, 1.0]), np.full(2, 0.5), "scatter of 3 repeats", 0.5)


def test_noise_is_not_systematic_but_a_wave_is():
    rng = np.random.default_rng(0)
    repeat = np.repeat([0, 1, 2], 300)
    noise = rng.standard_normal(900)
    found = residual_of("test", "N", noise, repeat, 10.0, SCATTER)
    assert found.root_mean_square == pytest.approx(1.0, rel=0.1) and found.systematic < 0.25
    wave = np.tile(np.sin(np.linspace(0.0, 6.0, 300)), 3)
    found = residual_of("test", "N", wave, repeat, 10.0, SCATTER)
    assert found.systematic == pytest.approx(found.root_mean_square, rel=0.05)
    assert found.ratio == pytest.approx(found.systematic / 0.5)


def test_specimens_on_either_side_of_the_fit_are_no_misfit():
    found = residual_of("test", "N", np.repeat([1.0, -1.0], 100), np.repeat([0, 1], 100), 10.0, SCATTER)
    assert found.root_mean_square == pytest.approx(1.0) and found.systematic == pytest.approx(0.0)


def test_repeats_with_few_points():
    found = residual_of("test", "N", np.array([1.0, -1.0, 1.0]), np.array([0, 0, 1]), 10.0, SCATTER)
    assert np.isfinite(found.systematic)
