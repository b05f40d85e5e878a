"""What trims leave of a mesh, and what is refused before a run."""

import numpy as np
import pytest

from weavesim import (
    Coulomb,
    Drive,
    Gripper,
    InputError,
    Interface,
    SelfContact,
    Setup,
    Sheet,
    Stage,
    Stroke,
    Support,
    Trim,
)
from weavesim.engine.model import Model
from weavesim.engine.staging.trimming import cut, depth_inside, waste_nodes
from weavesim.fabric.presets import glass_polypropylene
from weavesim.sheet.blank import Blank

BLANK = Blank.rectangle((0.0, 0.0), (0.1, 0.1), 0.01)
ALL = np.ones(BLANK.element_count, dtype=bool)
CENTRE = BLANK.element_centres()[:, :2]


def box(x0, y0, x1, y1):
    return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]


def test_depth_of_a_ring_is_the_distance_from_the_nearest_curve():
    ring = Trim([box(0.0, 0.0, 1.0, 1.0), box(0.4, 0.4, 0.6, 0.6)])
    points = np.array([(0.5, 0.5), (0.2, 0.5), (0.45, 0.5), (1.5, 0.5)])
    assert depth_inside(ring, points) == pytest.approx([-0.1, 0.2, -0.05, -0.5])
    assert depth_inside(ring.model_copy(update={"keeps": "outside"}), points) == pytest.approx([0.1, -0.2, 0.05, 0.5])


def test_elements_stay_by_their_centres_and_the_border_is_measured():
    found = cut(Trim(box(-1.0, -1.0, 0.046, 1.0)), BLANK, BLANK.material_coordinates, ALL)
    assert np.array_equal(found.kept, CENTRE[:, 0] < 0.046)
    assert found.off == pytest.approx(0.004)
    assert waste_nodes(BLANK, found.kept).sum() == 5 * 11
    again = cut(Trim(box(-1.0, -1.0, 1.0, 0.052)), BLANK, BLANK.material_coordinates, found.kept)
    assert np.array_equal(again.kept, found.kept & (CENTRE[:, 1] < 0.052))
    none = cut(Trim(box(-1.0, -1.0, 1.0, 1.0)), BLANK, BLANK.material_coordinates, ALL)
    assert none.kept.all() and none.off == 0.0


def test_corners_and_scraps_do_not_hang_on():
    """A blank can be made of what stays: in one piece, without hinges."""
    rng = np.random.default_rng(3)
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    for _ in range(20):
        radius = 0.04 * rng.uniform(0.4, 1.2, len(angle))
        curve = 0.05 + np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
        found = cut(Trim(curve), BLANK, BLANK.material_coordinates, ALL)
        part, nodes = BLANK.part(found.kept)
        assert np.array_equal(BLANK.node_position[nodes], part.node_position)
        assert part.element_count == found.kept.sum() > 10


def test_pieces_and_nothing_are_refused():
    with pytest.raises(ValueError, match="2 pieces would stay, one of 2000 mm"):
        cut(Trim(box(0.02, -1.0, 0.04, 1.0), keeps="outside"), BLANK, BLANK.material_coordinates, ALL)
    with pytest.raises(ValueError, match="nothing of the sheet would stay"):
        cut(Trim(box(2.0, 2.0, 3.0, 3.0)), BLANK, BLANK.material_coordinates, ALL)
    with pytest.raises(ValueError, match="sides 0 and 2 of the curve cross"):
        depth_inside(Trim([(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]), CENTRE)


def staged(trims, grippers=None, sheets=None, **given):
    grip = Gripper("grip", np.flatnonzero(BLANK.node_position[:, 0] > 0.099), (1.0, 0.0, 0.0), 1e4)
    own = [Sheet(BLANK, glass_polypropylene(), grippers=(grip,))] if sheets is None else sheets
    stages = Stage("form", 1e-3), Stage("trim", 1e-3, trims=trims, grippers=grippers)
    return Setup("trimmed", sheets=own, stages=stages, **given)


TOUCHING = SelfContact(Coulomb(0.2))
LEFT = box(-1.0, -1.0, 0.05, 1.0)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: staged([Trim(LEFT, "ply")]), "there is no sheet 'ply'; there are sheet"),
        (lambda: staged([Trim(LEFT, view="blank")]), "gripper grip holds what is cut away of sheet sheet; release it"),
        (lambda: staged([Trim(box(2.0, 2.0, 3.0, 3.0), view="blank")]), "nothing of the sheet would stay"),
        (lambda: staged([Trim(box(-1.0, -1.0, 1.0, 1.0), view="blank")]), "all of the blank would stay"),
        (lambda: staged([Trim([(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)])]), "of the curve cross"),
        (
            lambda: staged(
                [Trim(LEFT)], sheets=[Sheet(BLANK, glass_polypropylene(), self_contact=SelfContact(Coulomb(0.2)))]
            ),
            "sheet sheet may touch itself",
        ),
    ],
)
def test_trims_that_cannot_be_are_refused_before_the_run(make, text):
    with pytest.raises(InputError, match=f"stage trim: trim: .*{text}"):
        make()


def test_plies_that_touch_are_not_trimmed():
    upper = Blank.rectangle((0.0, 0.0), (0.1, 0.1), 0.01, height=0.002)
    sheets = [Sheet(BLANK, glass_polypropylene(), name="a"), Sheet(upper, glass_polypropylene(), name="b")]
    with pytest.raises(InputError, match="sheet is required, one of a, b"):
        staged([Trim(LEFT)], sheets=sheets)
    with pytest.raises(InputError, match="sheet a touches another sheet.*weavesim export --trim"):
        staged([Trim(LEFT, "a")], sheets=sheets, interfaces=[Interface("a", "b", Coulomb(0.3))])
    assert staged([Trim(LEFT, "a")], sheets=sheets).trims


def test_waste_has_no_mass_and_nothing_holds_it():
    x = BLANK.node_position[:, 0]
    held = Support("held", np.flatnonzero(x > 0.079), (Drive(Stroke((0.0, 1.0), (0.0, 1.0)), (1.0, 0.0, 0.0)),))
    setup = Setup("held", sheets=[Sheet(BLANK, glass_polypropylene(), supports=[held])], duration=1e-3)
    whole, part = (Model(setup, kept=kept).sheet for kept in ((), (CENTRE[:, 0] < 0.09,)))
    assert not whole.waste.any() and np.array_equal(part.waste, x > 0.095)
    assert part.node_mass.sum() == pytest.approx(0.9 * whole.node_mass.sum())
    assert not part.node_mass[part.waste].any() and not part.free[part.waste].any()
    bits = part.held.numpy().ravel()[: len(x)]
    assert np.array_equal(bits > 0, (x > 0.079) & ~part.waste)
    assert part.reference_step == whole.reference_step  # contact stiffness goes on
