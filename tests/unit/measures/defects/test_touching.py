"""A sheet on itself: a folded strip with a known gap, at any mesh; neighbours do not count."""

import numpy as np
import pytest

from tests.support.folded_strips import fold_blank
from weavesim.measures.defects.judgement import Judgement, Limits
from weavesim.measures.defects.touching import distance_to_others
from weavesim.measures.findings import FormedSheet
from weavesim.sheet.blank import Blank

THICKNESS = 1.0e-3


@pytest.mark.parametrize("size", [0.0013, 0.004])
def test_both_legs_of_a_fold_are_found_at_their_distance(size):
    gap = 1.05e-3
    blank = fold_blank(size, 0.04, gap)
    distance = distance_to_others(blank.node_position, blank.material_coordinates, blank.quads, THICKNESS, 1.1e-3)
    along = blank.material_coordinates[blank.quads].mean(axis=1)[:, 0]
    straight = np.abs(along - 0.04 - 0.25 * np.pi * gap) > 0.01
    assert distance[straight] == pytest.approx(gap, rel=1e-6)
    assert np.isinf(
        distance_to_others(blank.node_position, blank.material_coordinates, blank.quads, THICKNESS, 1.0e-3)
    ).all()


@pytest.mark.parametrize("size", [2.0e-4, 0.002])
def test_a_flat_sheet_does_not_touch_itself(size):
    blank = Blank.rectangle((0.0, 0.0), (20 * size, 6 * size), size)
    flat = blank.material_coordinates
    assert np.isinf(distance_to_others(blank.node_position, flat, blank.quads, THICKNESS, 1.1e-3)).all()


@pytest.mark.parametrize(
    ("gap", "limit", "found"), [(1.05e-3, 1e-4, True), (1.3e-3, 1e-4, False), (1.05e-3, None, False)]
)
def test_a_fold_is_a_region_with_its_gap(gap, limit, found):
    blank = fold_blank(0.004, 0.04, gap)
    count = blank.element_count
    values = {
        "warp_stretch": np.ones(count), "weft_stretch": np.ones(count), "warp_force": np.zeros(count),
        "weft_force": np.zeros(count), "shear_angle": np.zeros(count),
    }  # fmt: skip
    sheet = FormedSheet(blank, blank.node_position, values, THICKNESS)
    limits = Limits(self_contact_gap=limit, wrinkle_amplitude=None, bridging_gap=None)
    regions = Judgement(sheet, limits).regions
    assert [region.kind for region in regions] == ["self-contact"] * (2 if found else 0)  # either leg
    if found:
        assert regions[0].largest == pytest.approx(gap - THICKNESS, rel=1e-6)
        assert regions[0].severity == pytest.approx((THICKNESS + 1e-4) / gap, rel=1e-6)
        assert regions[0].as_dict()["gap_mm"] == pytest.approx(0.05, rel=1e-6)
