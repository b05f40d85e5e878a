"""Names of compared quantities say their units."""

import pytest

from weavesim.output.comparison.fields import FIELDS, UNITS, titled


@pytest.mark.parametrize(
    ("key", "title"),
    [
        ("shear_angle_deg", "shear angle [degrees]"), ("thickness", "thickness [m]"),
        ("warp_force", "warp force [N/m]"), ("distance_mm", "distance [mm]"), ("warp_stretch", "warp stretch"),
    ],
)  # fmt: skip
def test_a_title_has_the_unit(key, title):
    assert titled(key) == title


def test_units_are_those_of_fields():
    assert set(UNITS) <= set(FIELDS)
