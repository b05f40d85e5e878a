"""A damping for a new set-up, by the time of its strokes and by the slowest swing of what is released."""

import math

import pytest

from weavesim import glass_polypropylene
from weavesim.job.advice.damping import DECAYS, release_damping, slowest_bending, suggested_damping
from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome


def test_vibrations_fall_by_e_six_times():
    for time in (0.01, 0.05, 0.12, 1.7):
        damping = suggested_damping(time)
        assert 0.8 * DECAYS < 0.5 * damping * time < 1.25 * DECAYS
        assert damping == float(f"{damping:.2g}")


def test_it_is_what_the_double_dome_has():
    parameters = DoubleDomeParameters()
    assert suggested_damping(double_dome(parameters).duration) == parameters.damping


def test_a_released_sheet_is_stopped_in_its_slowest_bending():
    fabric = glass_polypropylene()
    slowest = slowest_bending(fabric, 0.3)
    # a free strip: cos(k L) cosh(k L) = 1, omega = k^2 sqrt(B / rho)
    root = 4.730040745
    assert math.cos(root) * math.cosh(root) == pytest.approx(1.0, abs=1e-5)
    rigidity, density = fabric.bending_stiffness_scale, fabric.areal_density
    assert slowest == pytest.approx((root / 0.3) ** 2 * math.sqrt(rigidity / density), rel=1e-4)
    assert release_damping(fabric, 0.3) == pytest.approx(2.0 * slowest, rel=0.15)
    assert slowest_bending(fabric, 0.6) == pytest.approx(0.25 * slowest)
