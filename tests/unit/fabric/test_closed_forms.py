"""Closed forms of the fabric tests against balances of power and each other."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.fabric.cell.membrane import LinearMembrane
from weavesim.fabric.closed_forms import (
    bias_zone_areas,
    elastica_profile,
    elastica_stiffness,
    free_stretch,
    heavy_elastica,
    moment_along,
    peirce_stiffness,
    trellis_angle,
    trellis_angle_rate,
    yarn_forces,
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


def test_a_linear_membrane_pulls_in_as_its_coupling_says():
    """Across the pull: C_12 e_1 + (C_22 + K_c) e_2 = 0, K_c of the sheet itself, which is pushed together."""
    cell = LinearMembrane(warp_stiffness=2.0e4, weft_stiffness=1.0e4, coupling_stiffness=3.0e3)
    fabric = glass_polypropylene().with_linear_shear(1.0e5)
    fabric = fabric.model_copy(update={"unit_cell": cell, "compressive_stiffness": 500.0})
    strain = np.array([0.0, 0.01, 0.02])
    for pulled, across in ((0, 1.0e4), (1, 2.0e4)):
        free = free_stretch(fabric, 1.0 + strain, pulled=pulled)
        np.testing.assert_allclose(free - 1.0, -3.0e3 / (across + 500.0) * strain, atol=1e-12)
        pair = (1.0 + strain, free) if pulled == 0 else (free, 1.0 + strain)
        forces = yarn_forces(fabric, np.stack(pair, axis=1))
        along = (2.0e4, 1.0e4)[pulled] - 3.0e3**2 / (across + 500.0)
        np.testing.assert_allclose(forces[:, pulled], along * strain, rtol=1e-9, atol=1e-6)
        np.testing.assert_allclose(forces[:, 1 - pulled], 0.0, atol=1e-6)


def test_a_family_without_equilibrium_is_refused():
    cell = LinearMembrane(warp_stiffness=1.0e4, weft_stiffness=1.0e3, coupling_stiffness=3.0e3)
    fabric = glass_polypropylene().with_linear_shear(1.0e4)
    fabric = fabric.model_copy(update={"unit_cell": cell, "compressive_stiffness": 0.0})
    with pytest.raises(InputError, match="no equilibrium between stretches of 0.5 and 1.2; reduce the strain"):
        free_stretch(fabric, np.array([1.2]), pulled=0)
