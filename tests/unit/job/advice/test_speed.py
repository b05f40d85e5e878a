"""A speed for new strokes: by the inertia of the sheet, to a round number."""

import pytest

from weavesim import glass_polypropylene
from weavesim.job.advice.speed import rounded_down, suggested_speed


@pytest.mark.parametrize(("value", "rounded"), [(0.47, 0.4), (0.1, 0.1), (1.0, 1.0), (764.0, 600.0), (0.00437, 0.004)])
def test_numbers_are_rounded_down(value, rounded):
    assert rounded_down(value) == rounded


def test_a_stiffer_fabric_may_be_formed_faster():
    fabric = glass_polypropylene()
    heavy = fabric.model_copy(update={"areal_density": 4.0 * fabric.areal_density})
    assert suggested_speed([heavy]) < suggested_speed([fabric]) == suggested_speed([fabric, fabric])
