"""Fabrics: derived quantities, and which values are refused."""

import math

import pytest

from weavesim.errors import InputError
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.fabric import LARGEST_LOCKING_SHARE, Fabric, Stabilisation
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.shear import LinearShear


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"areal_density": 0.0}, "areal_density = 0.0"),
        ({"thickness": -1e-3}, "thickness = -0.001"),
        ({"transverse_shear_modulus": -1.0}, "transverse_shear_modulus"),
        ({"compressive_stiffness": math.nan}, "compressive_stiffness"),
        ({"in_plane_bending_stiffness": -1.0}, "in_plane_bending_stiffness"),
    ],
)
def test_bad_fabrics_are_refused_by_name(changes, message):
    fabric = glass_polypropylene()
    values = {name: getattr(fabric, name) for name in type(fabric).model_fields}
    with pytest.raises(InputError, match=message):
        Fabric(**(values | changes))


def test_locking_is_bounded_by_the_yarns():
    fabric = glass_polypropylene()
    largest = LARGEST_LOCKING_SHARE * min(fabric.unit_cell.yarn_stiffness_per_width)
    values = {name: getattr(fabric, name) for name in type(fabric).model_fields}
    hard = fabric.shear.model_copy(update={"locking_stiffness": 1.01 * largest})
    with pytest.raises(InputError, match="locking_stiffness"):
        Fabric(**(values | {"shear": hard}))
    allowed = fabric.shear.model_copy(update={"locking_stiffness": largest})
    assert Fabric(**(values | {"shear": allowed})).shear.locking_stiffness == largest


def test_parameters_cannot_be_changed():
    with pytest.raises(InputError, match="thickness does not change once it is made; model_copy"):
        glass_polypropylene().thickness = 1.0


def test_plate_stiffness():
    assert IsotropicBending(modulus=3e9, poisson_ratio=0.3).stiffness(2e-3) == pytest.approx(3e9 * 8e-9 / 12 / 0.91)
    fabric = glass_polypropylene()
    assert fabric.transverse_shear_stiffness == pytest.approx(5.0 / 6.0 * fabric.transverse_shear_modulus * 1.2e-3)


def test_linear_law_is_a_switch():
    fabric = glass_polypropylene()
    linear = fabric.with_linear_shear(2.0e6)
    assert linear.shear == LinearShear(modulus=2.0e6)
    assert linear.unit_cell == fabric.unit_cell
    assert linear.shear_stiffness_scale == pytest.approx(0.5 * 2.0e6 * 1.2e-3, rel=0.3)


def test_bad_stabilisation_is_refused():
    with pytest.raises(InputError, match="in_plane = -0.1"):
        Stabilisation(in_plane=-0.1)
