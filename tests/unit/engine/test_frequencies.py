"""Stiffnesses of the stabilisation."""

import pytest

from weavesim import SelfContact, Sheet
from weavesim.engine.frequencies import hourglass_coefficients
from weavesim.fabric.fabric import Stabilisation
from weavesim.fabric.presets import glass_polypropylene
from weavesim.sheet.blank import Blank


def test_in_plane_stabilisation_knows_nothing_of_the_yarns():
    fabric = glass_polypropylene()
    stiffer = fabric.unit_cell.model_copy(update={"warp_modulus": 100.0 * fabric.unit_cell.warp_modulus})
    changed = fabric.model_copy(update={"unit_cell": stiffer})
    share = fabric.stabilisation
    assert hourglass_coefficients(changed, share) == hourglass_coefficients(fabric, share)
    shear = fabric.with_linear_shear(1.0e6), fabric.with_linear_shear(2.0e6)
    in_plane = [hourglass_coefficients(each, share)[0] for each in shear]
    assert in_plane[1] == pytest.approx(2.0 * in_plane[0])
    none = Stabilisation(in_plane=0.0, warping=0.0, director=0.0)
    assert hourglass_coefficients(fabric, none) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("given", [0.1, 1.0, 1.5])
def test_a_sheet_that_may_touch_itself_has_the_whole_stiffness_of_its_directors(given):
    fabric = glass_polypropylene()
    fabric = fabric.model_copy(update={"stabilisation": Stabilisation(in_plane=0.2, warping=0.3, director=given)})
    blank = Blank.rectangle((0.0, 0.0), (0.1, 0.1), 0.05)
    assert Sheet(blank, fabric).stabilisation == fabric.stabilisation
    folds = Sheet(blank, fabric, self_contact=SelfContact()).stabilisation
    assert folds == Stabilisation(in_plane=0.2, warping=0.3, director=max(given, 1.0))
