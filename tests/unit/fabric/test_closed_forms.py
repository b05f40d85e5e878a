"""Closed forms of the fabric tests against balances of power and each other."""

import numpy as np
import pytest

from weavesim.fabric.closed_forms import (
    bias_zone_areas,
    elastica_profile,
    elastica_stiffness,
    heavy_elastica,
    moment_along,
    peirce_stiffness,
    trellis_angle,
    trellis_angle_rate,
)
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.shear import ShearFriction


def test_a_trellis_shears_as_its_diagonals_say():
    side, angle = 0.2, np.radians([0.0, 10.0, 40.0])
    diagonal = 2.0 * side * np.cos(0.25 * np.pi - 0.5 * angle)
    np.testing.assert_allclose(trellis_angle(diagonal, side), angle, atol=1e-12)
    step = 1e-7
    slope = (trellis_angle(diagonal + step, side) - trellis_angle(diagonal - step, side)) / (2 * step)
    np.testing.assert_allclose(trellis_angle_rate(diagonal, side), slope, rtol=1e-6)


def test_zones_fill_the_strip():
    assert sum(bias_zone_areas(0.23, 0.115)) == pytest.approx(0.23 * 0.115)


def test_friction_adds_its_limit_on_the_way_out_and_takes_it_back():
    fabric = glass_polypropylene()
    rubbing = fabric.model_copy(update={"shear_friction": ShearFriction(stiffness=500.0, limit=(5.0,))})
    path = np.radians([*range(31), *range(29, -1, -1)])
    difference = moment_along(rubbing, path) - moment_along(fabric, path)
    assert difference[30] == pytest.approx(5.0) and difference[-1] == pytest.approx(-5.0)


def test_peirce_is_six_per_cent_above_the_elastica_at_the_usual_angle():
    angle = np.radians(41.5)
    assert elastica_stiffness(angle, 0.1, 7.3) == pytest.approx(7.3 * 0.05**3, rel=2e-3)
    assert peirce_stiffness(angle, 0.1, 7.3) == pytest.approx(1.057 * 7.3 * 0.05**3, rel=2e-3)


def test_the_profile_of_the_elastica_ends_where_its_chord_does():
    load, angle = heavy_elastica(1.0)
    x, drop = elastica_profile(0.1, 1.0e-3, load * 1.0e-3 / 0.1**3, np.array([0.0, 0.1]))
    assert (x[0], drop[0]) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert np.arctan2(drop[1], x[1]) == pytest.approx(angle, rel=1e-4)
