"""Provenance of what was held, fitted and assumed."""

import pytest

from tests.support.synthetic_laboratory import Laboratory, biaxial, random_fabric
from weavesim.calibration import calibrate
from weavesim.fabric.presets import glass_polypropylene


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tests")
    true = random_fabric(6)
    paths = biaxial(true, Laboratory(repeat_count=3, point_count=30), folder, ratios=((1.0, 1.0),))
    return calibrate("glass-polypropylene-polynomial", biaxial=paths, starts=1)


def test_a_fitted_number_has_its_interval_as_range(found):
    fabric = found.fabric
    entry, origin = found.estimate("yarn_stiffness"), fabric.origin_of("unit_cell.weft_modulus")
    area = fabric.unit_cell.weft_cross_section
    assert origin.of == ("unit_cell.warp_modulus", "unit_cell.weft_modulus") and not origin.assumed
    assert origin.range == pytest.approx((entry.low / area, entry.high / area), rel=1e-5)
    assert "biaxial_0.csv (SHA-256" in origin.source


def test_a_held_number_is_assumed(found):
    assert found.estimate("yarn_bending").state == "held"
    origin = found.fabric.origin_of("unit_cell.warp_second_moment")
    assert origin.assumed and "unit_cell: yarn_bending" in found.fabric.assumed


def test_numbers_that_no_test_touched_keep_their_origin(found):
    base = glass_polypropylene()
    for name in ("thickness", "bending.modulus", "shear.locking_width", "unit_cell.warp_crimp_share"):
        if found.base.origin_of(name):
            assert found.fabric.origin_of(name) == found.base.origin_of(name)
    assert found.fabric.bending == base.bending
