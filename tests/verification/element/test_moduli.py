"""Shear moduli: one convention, stress over angle, in transverse shear and twist; and that of equation (4)."""

import math

import numpy as np
import pytest

from weavesim.fabric import IsotropicBending, LinearShear, YarnBending
from weavesim.sheet.blank import Blank

THICKNESS, MODULUS = 1.0e-3, 3.0e6  # of ``fabric``; G
SIDE, SIZE = 0.02, 0.005


def flat() -> Blank:
    return Blank.rectangle((-0.5 * SIDE, -0.5 * SIDE), (0.5 * SIDE, 0.5 * SIDE), SIZE)


def twisted(sheet, laws, c: float) -> float:
    """Bending energy per area of w = c x y with its own normals."""
    blank = flat()
    x, y, _ = blank.node_position.T
    position = np.column_stack([x, y, c * x * y])
    director = np.column_stack([-c * y, -c * x, np.ones_like(x)])
    director /= np.linalg.norm(director, axis=1, keepdims=True)
    return sheet(blank, laws).energies(position, director)["bending"] / SIDE**2


@pytest.mark.parametrize("c", [0.05, 0.2, -0.2])
def test_twist_of_a_plate(c, sheet, fabric):
    """Kirchhoff: psi = 1/6 G t^3 c^2, so the twisting moment d psi / d(2c) per width on each side is G t^3 c / 6."""
    law = YarnBending.from_moduli(2.5 * MODULUS, 0.25, MODULUS, THICKNESS)
    expected = MODULUS * THICKNESS**3 / 6.0 * c**2
    assert twisted(sheet, fabric(bending=law), c) == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("ratio", [0.0, 0.25, 0.4])
def test_isotropic_moduli_give_the_isotropic_plate(ratio, sheet, fabric):
    """G = E / (2 (1 + nu)) of elasticity."""
    young = 7.5e6
    plate = IsotropicBending(modulus=young, poisson_ratio=ratio)
    yarns = YarnBending.from_moduli(young, ratio, 0.5 * young / (1.0 + ratio), THICKNESS)
    assert 2.0 * yarns.twist == pytest.approx(plate.stiffness(THICKNESS) * (1.0 - ratio))
    found = [twisted(sheet, fabric(bending=law), 0.1) for law in (plate, yarns)]
    assert found[0] == pytest.approx(found[1], rel=1e-4)


@pytest.mark.parametrize("angle", [0.001, 0.01])
def test_transverse_shear(angle, sheet, fabric):
    """Q = 5/6 G t gamma, psi = 1/2 Q gamma."""
    blank = flat()
    director = np.tile([math.sin(angle), 0.0, math.cos(angle)], (blank.node_count, 1))
    laws = fabric(transverse_shear_modulus=MODULUS)
    energy = sheet(blank, laws).energies(blank.node_position, director)["transverse_shear"] / SIDE**2
    assert energy == pytest.approx(0.5 * (5.0 / 6.0 * MODULUS * THICKNESS) * angle**2, rel=1e-4)


@pytest.mark.parametrize("angle", [0.001, 0.01])
def test_in_plane_shear(angle, sheet, fabric):
    """m = t tau, tau = G gamma; equation (4) has twice that modulus."""
    blank = flat()
    position = blank.node_position.copy()
    position[:, 0] += math.sin(angle) * blank.node_position[:, 1]
    position[:, 1] *= math.cos(angle)
    law = LinearShear(modulus=2.0 * MODULUS)
    energy = sheet(blank, fabric(shear=law)).energies(position, blank.initial_director)["shear"] / SIDE**2
    assert energy == pytest.approx(0.5 * MODULUS * THICKNESS * angle**2, rel=1e-3)
    assert law.moment(np.array(angle), THICKNESS) == pytest.approx(MODULUS * THICKNESS * angle, rel=1e-3)
