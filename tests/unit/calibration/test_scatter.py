"""Weights: the scatter of repeats, the noise of one test, or what is stated."""

import numpy as np
import pytest

from weavesim.calibration.scatter import scatter_of
from weavesim.calibration.series import Series


def test(y, x=None):
    x = np.linspace(0.0, 1.0, len(y)) if x is None else x
    return Series("test.csv", "", x, np.asarray(y, dtype=float), np.arange(len(y)), ("x", "y"))


test.__test__ = False  # pytest would collect it


def test_repeats_that_differ_more_towards_the_end():
    x = np.linspace(0.0, 1.0, 80)
    rng = np.random.default_rng(0)
    scatter = scatter_of([test((1.0 + 0.1 * rng.standard_normal()) * x) for _ in range(30)])
    assert scatter.at(np.array([0.9]))[0] == pytest.approx(0.09, rel=0.3)
    assert scatter.at(np.array([0.2]))[0] < 0.04
    assert "30 repeats" in scatter.source


def test_repeats_of_different_length_and_points():
    rng = np.random.default_rng(1)
    tests = [test(3.0 + 0.1 * rng.standard_normal(n), np.linspace(0.0, end, n)) for n, end in ((90, 1.0), (70, 0.8))]
    assert scatter_of(tests).yardstick == pytest.approx(0.1, rel=0.4)


def test_a_single_test_from_its_points_or_as_stated():
    rng = np.random.default_rng(2)
    x = np.linspace(0.0, 1.0, 300)
    single = test(x**2 + 0.02 * rng.standard_normal(300))
    found = scatter_of([single])
    assert found.at(x)[0] == pytest.approx(0.02, rel=0.2) and found.yardstick >= 0.01
    stated = scatter_of([single], 0.05)
    assert stated.yardstick == pytest.approx(0.05 * np.abs(single.y).max()) and "stated" in stated.source
