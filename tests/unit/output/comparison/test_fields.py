"""Names of compared quantities say their units."""

import pytest

from weavesim.output.comparison.fields import FIELDS, UNITS, keyed, titled


@pytest.mark.parametrize(
    ("key", "title"),
    [
        ("shear_angle_deg", "shear angle [degrees]"), ("thickness", "thickness [m]"),
        ("thickness_m", "thickness [m]"), ("warp_force_n_per_m", "warp force [N/m]"),
        ("warp_force", "warp force [N/m]"), ("distance_mm", "distance [mm]"), ("warp_stretch", "warp stretch"),
    ],
)  # fmt: skip
def test_a_title_has_the_unit(key, title):
    assert titled(key) == title


def test_units_are_those_of_fields():
    assert set(UNITS) <= set(FIELDS)


def test_names_in_files_end_in_their_units():
    assert [keyed(name) for name in ("shear_angle_deg", "thickness", "warp_stretch")] == [
        "shear_angle_deg", "thickness_m", "warp_stretch"
    ]  # fmt: skip
