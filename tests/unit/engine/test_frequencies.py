"""Stiffnesses of the stabilisation."""

import pytest

from weavesim.engine.frequencies import hourglass_coefficients
from weavesim.fabric.fabric import Stabilisation
from weavesim.fabric.presets import glass_polypropylene


def test_in_plane_stabilisation_knows_nothing_of_the_yarns():
    fabric = glass_polypropylene()
    stiffer = fabric.unit_cell.model_copy(update={"warp_modulus": 100.0 * fabric.unit_cell.warp_modulus})
    changed = fabric.model_copy(update={"unit_cell": stiffer})
    assert hourglass_coefficients(changed) == hourglass_coefficients(fabric)
    shear = fabric.with_linear_shear(1.0e6), fabric.with_linear_shear(2.0e6)
    assert hourglass_coefficients(shear[1])[0] == pytest.approx(2.0 * hourglass_coefficients(shear[0])[0])
    none = fabric.model_copy(update={"stabilisation": Stabilisation(in_plane=0.0, warping=0.0, director=0.0)})
    assert hourglass_coefficients(none) == (0.0, 0.0, 0.0)
