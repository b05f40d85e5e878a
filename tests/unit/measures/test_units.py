"""Names of numbers and fields with their units."""

import pytest

from weavesim.measures.units import split_unit, with_unit


@pytest.mark.parametrize(
    ("name", "unit", "expected"),
    [
        ("thickness", "m", "thickness_m"), ("warp_force", "N/m", "warp_force_n_per_m"),
        ("warp_stretch", "1", "warp_stretch"),
        ("shear_angle_deg", "degrees", "shear_angle_deg"), ("pressure", "N/m^2", "pressure_pa"),
        ("density", "kg/m^2", "density_kg_per_m2"), ("permeability_1", "m^2", "permeability_1_m2"),
        ("gap_m", "m", "gap_m"),
    ],
)  # fmt: skip
def test_a_field_has_its_unit_in_its_name_once(name, unit, expected):
    assert with_unit(name, unit) == expected


def test_what_has_a_known_unit_is_split_again():
    name, unit = split_unit(with_unit("warp_force", "N/m"))
    assert (name, unit.symbol) == ("warp_force", "N/m")
