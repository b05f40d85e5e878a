"""Symmetry planes: what they hold, which copies they make, and the sign of the shear angle in a mirror."""

import numpy as np
import pytest

from tests.support.flat_blanks import FULL, HALF_IN_X, HALF_IN_Y, QUARTER, blank_of
from weavesim import Dynamics, Sheet, World, YarnBending, glass_polypropylene
from weavesim.errors import InputError
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import Symmetry, nodes_of_odd_angle, on_plane, shear_angle_parity


def all_free(blank):
    return np.ones((blank.node_count, 6), dtype=bool)


@pytest.mark.parametrize(
    ("symmetry", "share", "factors"),
    [
        (FULL, 1.0, ((1, 1),)),
        (HALF_IN_X, 0.5, ((1, 1), (-1, 1))),
        (HALF_IN_Y, 0.5, ((1, 1), (1, -1))),
        (QUARTER, 0.25, ((1, 1), (1, -1), (-1, 1), (-1, -1))),
    ],
)
def test_share_and_copies_of_the_part(symmetry, share, factors):
    assert symmetry.share == share
    assert symmetry.mirror_factors == factors
    copies = symmetry.mirrored(np.array([[1.0, 2.0, 3.0]]))
    assert copies.tolist() == [[x, 2.0 * y, 3.0] for x, y in factors]


def test_the_order_of_the_planes_does_not_order_the_copies():
    assert Symmetry(("y", "x")).mirror_factors == QUARTER.mirror_factors


@pytest.mark.parametrize(("planes", "message"), [(("z",), "symmetry plane 'z'"), (("x", "x"), "list each plane once")])
def test_planes_that_are_refused(planes, message):
    with pytest.raises(InputError, match=message):
        Symmetry(planes)


def test_nodes_stay_in_the_plane_and_their_directors_turn_in_it():
    blank = blank_of(HALF_IN_X)
    on_plane = blank.node_position[:, 0] == 0.0
    free = HALF_IN_X.hold(blank, all_free(blank))
    assert on_plane.any() and np.all(free[~on_plane])
    assert np.all(free[on_plane] == [False, True, True, True, False, False])


def test_what_was_held_before_stays_held_and_the_argument_is_left_alone():
    blank = blank_of(QUARTER)
    given = all_free(blank)
    given[:, 2] = False
    assert not QUARTER.hold(blank, given)[:, 2].any()
    assert given.sum() == 5 * blank.node_count


def test_a_plane_outside_the_blank_is_refused():
    blank = Blank.rectangle((0.1, 0.1), (0.2, 0.2), 0.02)
    with pytest.raises(InputError, match="symmetry plane x = 0: no node of the blank lies on it"):
        HALF_IN_X.hold(blank, all_free(blank))


def shear_angle(warp, weft):
    return np.arcsin(np.dot(warp, weft) / np.linalg.norm(warp) / np.linalg.norm(weft))


@pytest.mark.parametrize("plane", ["x", "y"])
@pytest.mark.parametrize(("yarn_angle", "parity"), [(0.0, -1.0), (90.0, -1.0), (45.0, 1.0), (-45.0, 1.0)])
def test_parity_is_that_of_a_mirrored_deformation(plane, yarn_angle, parity):
    """The reference shears the yarns by a gradient and by its mirror image, and measures both angles."""
    blank = blank_of(FULL, yarn_angle=yarn_angle)
    assert np.all(shear_angle_parity(blank, plane) == parity)
    mirror = np.diag([-1.0, 1.0, 1.0] if plane == "x" else [1.0, -1.0, 1.0])
    # symmetric under the mirror for yarns at 45 degrees, odd under it for yarns along the axes
    gradient = np.array([[1.0, 0.2, 0.0], [0.2, 1.0, 0.0], [0.0, 0.0, 1.0]])
    if yarn_angle % 90.0:
        gradient = np.diag([1.2, 0.9, 1.0])
    warp, weft = blank.warp_direction[0], blank.weft_direction[0]
    angle, image = (shear_angle(g @ warp, g @ weft) for g in (gradient, mirror @ gradient @ mirror))
    assert abs(angle) > 0.1 and image == pytest.approx(parity * angle)


@pytest.mark.parametrize(("yarn_angle", "odd"), [(0.0, True), (90.0, True), (45.0, False)])
def test_nodes_of_odd_angle_lie_on_the_planes(yarn_angle, odd):
    blank = blank_of(QUARTER, yarn_angle=yarn_angle)
    found = nodes_of_odd_angle(blank, QUARTER.hold(blank, all_free(blank)))
    x, y = blank.node_position[:, 0], blank.node_position[:, 1]
    assert np.array_equal(found, odd & ((x == 0.0) != (y == 0.0)))


def test_a_clamped_edge_is_no_symmetry_plane():
    blank = blank_of(HALF_IN_X)
    free = all_free(blank)
    free[blank.node_position[:, 0] == 0.0] = False
    assert not nodes_of_odd_angle(blank, free).any()


@pytest.mark.parametrize("planes", [None, 5, ([],), ("z",)])
def test_planes_that_are_none_are_refused(planes):
    with pytest.raises(InputError, match="symmetry plane"):
        Symmetry(planes)


def test_a_plane_holds_nodes_that_are_on_it_to_the_rounding_of_a_mesh_file():
    blank = Blank.rectangle((2e-8, 0.0), (0.1, 0.1), 0.01)
    np.testing.assert_array_equal(Symmetry(("x",)).held_nodes(blank, "x"), on_plane(blank, "x"))
    assert on_plane(blank, "x").sum() == 11


def test_directors_of_a_curved_part_stand_in_the_planes_that_cut_it():
    """Those of the whole do; from the elements on one side of a plane alone they would lean."""

    def bent(low: float) -> Blank:
        flat = Blank.rectangle((low, 0.0), (0.03, 0.02), 0.005)
        position = flat.node_position - np.outer(8.0 * flat.node_position[:, 0] ** 2, (0.0, 0.0, 1.0))
        return Blank.from_mesh(position, flat.quads)

    half, whole = bent(0.0), bent(-0.03)
    upright = HALF_IN_X.upright(half)
    kept = whole.node_position[:, 0] > -1e-9
    np.testing.assert_allclose(upright.initial_director, whole.initial_director[kept], atol=1e-12)
    assert half.initial_director[0, 0] != 0.0
    assert HALF_IN_X.upright(upright) is upright and FULL.upright(half) is half
    flat = blank_of(HALF_IN_X)
    assert HALF_IN_X.upright(flat) is flat


WOVEN = glass_polypropylene()
UNEQUAL = WOVEN.model_copy(update={"bending": YarnBending(warp=2e-3, weft=1e-3, twist=1e-4)})


@pytest.mark.parametrize("plane", ["x", "y"])
@pytest.mark.parametrize(
    ("angle", "fabric", "good"),
    [(0.0, UNEQUAL, True), (90.0, UNEQUAL, True), (180.0, UNEQUAL, True), (45.0, WOVEN, True), (-45.0, WOVEN, True),
     (45.0, UNEQUAL, False), (30.0, WOVEN, False), (-1.0, WOVEN, False), (46.0, WOVEN, False), (91.0, WOVEN, False)],
)  # fmt: skip
def test_yarns_go_on_in_their_mirror_image_or_are_refused(plane, angle, fabric, good):
    for orientation in (0.0, angle):  # of the blank, or of the sheet on it
        blank = Blank.rectangle((0.0, 0.0), (0.1, 0.1), 0.02, yarn_angle=angle - orientation)
        sheet = Sheet(blank, fabric, orientation=orientation)
        if good:
            sheet.check_symmetry(Symmetry((plane,)))
        else:
            with pytest.raises(ValueError, match="a plane needs yarns along it or across it"):
                sheet.check_symmetry(Symmetry((plane,)))


@pytest.mark.parametrize(("warp", "weft", "good"), [(0, 60, False), (60, 90, False), (30, -30, True), (40, -20, False)])
def test_both_families_go_on_in_their_mirror_image(warp, weft, good):
    blank = Blank.rectangle((0.0, 0.0), (0.1, 0.1), 0.02)
    yarns = (np.tile((np.cos(a), np.sin(a), 0.0), (blank.element_count, 1)) for a in np.radians((warp, weft)))
    sheet = Sheet(blank.model_copy(update=dict(zip(("warp_direction", "weft_direction"), yarns, strict=True))), WOVEN)
    if good:
        sheet.check_symmetry(Symmetry(("y",)))
    else:
        with pytest.raises(ValueError, match="a plane needs yarns along it or across it"):
            sheet.check_symmetry(Symmetry(("y",)))


def test_yarns_that_curve_need_to_be_right_at_the_plane():
    blank = Blank.rectangle((0.0, 0.0), (0.1, 0.1), 0.01)
    around = np.column_stack([-blank.element_centres()[:, 1], blank.element_centres()[:, 0] + 1.0, np.zeros(100)])
    around /= np.linalg.norm(around, axis=1, keepdims=True)
    weft = np.cross([0.0, 0.0, 1.0], around)
    curved = blank.model_copy(update={"warp_direction": around, "weft_direction": weft})
    Sheet(curved, WOVEN).check_symmetry(Symmetry(("y",)))
    leaning = around.copy()
    leaning[np.argmin(blank.element_centres()[:, 1])] = (np.cos(1.2), np.sin(1.2), 0.0)
    there = {"warp_direction": leaning, "weft_direction": np.cross([0.0, 0.0, 1.0], leaning)}
    with pytest.raises(ValueError, match="a plane needs yarns along it or across it"):
        Sheet(curved.model_copy(update=there), WOVEN).check_symmetry(Symmetry(("y",)))


def test_gravity_acts_within_a_plane_of_symmetry():
    sheet = Sheet(Blank.rectangle((0.0, 0.0), (0.1, 0.1), 0.02), WOVEN)
    World([sheet], symmetry=("x",), dynamics=Dynamics(gravity=(0.0, 1.0, -9.81)))
    with pytest.raises(InputError, match="it pulls across the plane of symmetry x = 0"):
        World([sheet], symmetry=("x",), dynamics=Dynamics(gravity=(1.0, 0.0, -9.81)))
