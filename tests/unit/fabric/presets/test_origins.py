"""No number of a preset is without source, range of trust and whether it is assumed."""

import math

import pytest

from weavesim.fabric.presets import PRESETS
from weavesim.fabric.provenance import given_numbers

MEASURED = ("glass-polypropylene", "glass-polypropylene-hkust", "glass-polypropylene-consensus")


@pytest.mark.parametrize("name", PRESETS)
def test_every_number_of_every_preset_has_its_origin(name):
    fabric = PRESETS[name]()
    for number in given_numbers(fabric):
        origin = fabric.origin_of(number)
        assert origin is not None, number
        assert number in origin.of, f"{number}: only its table has a source"
        assert origin.range is not None or origin.scatter is not None, f"{number}: no range of trust"
        assert origin.assumed == ("assumed" in origin.source or number == "shear.smoothing" and origin.assumed), number
        assert len(origin.source) > 10


@pytest.mark.parametrize("name", PRESETS)
def test_every_number_is_within_its_range(name):
    fabric = PRESETS[name]()
    assert list(fabric.disproportions()) == []
    for key, number in given_numbers(fabric).items():
        origin = fabric.origin_of(key)
        if origin.range is not None and not isinstance(number.value, tuple):
            assert origin.range[0] <= number.value <= origin.range[1], key


@pytest.mark.parametrize("name", PRESETS)
def test_no_provenance_is_about_nothing(name):
    fabric = PRESETS[name]()
    about = {key for origin in fabric.provenance for key in origin.of}
    assert about - set(given_numbers(fabric)) <= {"shear_friction"}
    assert ("shear_friction" in about) <= (fabric.shear_friction is None)


@pytest.mark.parametrize("name", MEASURED)
def test_what_was_measured_and_what_was_not(name):
    fabric = PRESETS[name]()
    assumed = {number for number in given_numbers(fabric) if fabric.origin_of(number).assumed}
    assert {"unit_cell.crossover_height", "bending.modulus", "shear.locking_angle"} <= assumed
    assert not {"areal_density", "thickness", "shear.moment_values", "shear.angle", "unit_cell.warp_modulus"} & assumed
    friction = "shear_friction.limit" if fabric.shear_friction else "shear_friction"
    assert fabric.origin_of(friction).assumed
    assert math.degrees(fabric.origin_of("shear.angle").range[1]) == pytest.approx(35.0)


def test_the_glass_that_the_yarns_hold_explains_their_stiffness():
    """The note on E A: 1870 tex with 60 % of glass by mass, 2550 kg/m^3 and 72 GPa."""
    fabric = PRESETS["glass-polypropylene"]()
    stiffness = 0.6 * 1870e-6 / 2550.0 * 72e9
    assert stiffness == pytest.approx(fabric.unit_cell.axial_stiffness[0], rel=0.01)
    assert "31.7" in fabric.origin_of("unit_cell.warp_modulus").note and round(stiffness) == pytest.approx(
        31700, abs=50
    )


@pytest.mark.parametrize("name", [name for name in PRESETS if name.startswith("assumed")])
def test_an_assumed_fabric_assumes_everything(name):
    fabric = PRESETS[name]()
    assert all(fabric.origin_of(number).assumed for number in given_numbers(fabric))
