"""Lay-ups: angles, heights and meshes of their plies, and what is refused."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.sheet.stack import LayUp, Ply

FABRIC = glass_polypropylene()
SQUARE = (-0.05, -0.05), (0.05, 0.05)


def yarn_angle(sheet) -> np.ndarray:
    """From the x axis to the warp of each element [degrees]."""
    warp = sheet.oriented_blank.warp_direction
    return np.degrees(np.arctan2(warp[:, 1], warp[:, 0]))


def test_plies_of_a_code_have_its_angles_from_the_bottom():
    lay_up = LayUp.rectangle("[0/45]s", FABRIC, *SQUARE)
    sheets = lay_up.sheets(0.01)
    assert [sheet.name for sheet in sheets] == ["ply_1", "ply_2", "ply_3", "ply_4"] == list(lay_up.names)
    for sheet, angle in zip(sheets, (0.0, 45.0, 45.0, 0.0), strict=True):
        assert np.allclose(yarn_angle(sheet), angle)
    assert lay_up.code == "[0/45]s"


def test_plies_rest_on_each_other():
    """Of different thicknesses: distances are the sums of half thicknesses, the lowest face is where it is wanted."""
    plies = (Ply(0.0, thickness=1.0e-3), Ply(90.0, FABRIC.model_copy(update={"thickness": 0.4e-3})), Ply(0.0))
    lay_up = LayUp(plies, FABRIC, LayUp.rectangle("0", FABRIC, *SQUARE).outline)
    t = FABRIC.thickness
    wanted = (0.02 + 0.5e-3, 0.02 + 1.2e-3, 0.02 + 1.4e-3 + 0.5 * t)
    assert lay_up.heights(0.02) == pytest.approx(wanted, rel=1e-12)
    assert lay_up.thickness == pytest.approx(1.4e-3 + t)
    sheets = lay_up.sheets(0.01, bottom=0.02)
    assert [sheet.fabric.thickness for sheet in sheets] == [1.0e-3, 0.4e-3, t]
    for sheet, height in zip(sheets, wanted, strict=True):
        assert sheet.blank.node_position[:, 2] == pytest.approx(height, rel=1e-12)


def sides(sheet) -> np.ndarray:
    """Directions of all sides of all elements modulo a right angle, from -45 to 45 degrees."""
    corner = sheet.blank.node_position[sheet.blank.quads]
    side = np.roll(corner, -1, axis=1) - corner
    return (np.degrees(np.arctan2(side[..., 1], side[..., 0])).ravel() + 45.0) % 90.0 - 45.0


@pytest.mark.parametrize(("angle", "turned"), [(0.0, 0.0), (90.0, 0.0), (-180.0, 0.0), (30.0, 30.0), (-20.0, -20.0)])
def test_elements_follow_the_yarns_but_for_a_layer_at_the_outline(angle, turned):
    (sheet,) = LayUp.rectangle(f"{angle:g}", FABRIC, *SQUARE).sheets(0.0025)
    along = np.abs(sides(sheet) - turned) < 0.01
    assert along.all() if turned == 0.0 else along.mean() > 0.5
    assert sheet.blank.node_position[:, :2].max() == pytest.approx(0.05) and sheet.orientation == 0.0
    assert np.allclose(np.cos(np.radians(yarn_angle(sheet) - angle)), 1.0)


def test_all_plies_can_have_one_mesh_that_their_yarns_cross():
    sheets = LayUp.rectangle("0/30/45", FABRIC, *SQUARE).sheets(0.005, mesh_along="outline")
    first, *others = (sheet.blank for sheet in sheets)
    for blank in others:
        assert np.array_equal(blank.quads, first.quads)
        assert np.array_equal(blank.node_position[:, :2], first.node_position[:, :2])
    assert [float(yarn_angle(sheet)[0]) for sheet in sheets] == pytest.approx([0.0, 30.0, 45.0])


def test_a_ply_may_have_its_own_outline_and_name():
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    disc = 0.04 * np.column_stack([np.cos(angle), np.sin(angle)])
    lay_up = LayUp(
        (Ply(0.0), Ply(0.0, outline=disc, name="patch")), FABRIC, LayUp.rectangle("0", FABRIC, *SQUARE).outline
    )
    base, patch = lay_up.sheets(0.01)
    assert patch.name == "patch" and np.hypot(*patch.blank.material_coordinates.T).max() == pytest.approx(
        0.04, abs=1e-4
    )
    assert base.blank.element_count == 100


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (lambda: LayUp.parse("0/90", FABRIC).sheets(0.01), "ply_1 has no outline"),
        (lambda: LayUp.parse("0/90").sheets(0.01), "ply_1 has no fabric"),
        (lambda: LayUp((), FABRIC), "1 to 500 plies are allowed, here are 0"),
        (lambda: LayUp((Ply(0.0, name="a"), Ply(0.0, name="a"))), "both named 'a'"),
        (lambda: LayUp((Ply(0.0), Ply(0.0, name="ply_1"))), "both named 'ply_1'"),
        (lambda: Ply(float("nan")), "angle"),
        (lambda: Ply(0.0, thickness=0.0), "thickness"),
        (lambda: LayUp.parse(45), "a text such as"),
        (lambda: LayUp.rectangle("0.785398", FABRIC, *SQUARE).sheets(0.01), "45 degrees in radians"),
        (lambda: LayUp.rectangle("0.45/0", FABRIC, *SQUARE).sheets(0.01), "write 45 for 45 degrees"),
        (lambda: LayUp.rectangle("400", FABRIC, *SQUARE).sheets(0.01), "usual are 0 to 180"),
        (lambda: LayUp.rectangle("[0/90]40", FABRIC, *SQUARE).sheets(0.01), "80 plies; usual are up to 64"),
        (lambda: LayUp.rectangle("0", FABRIC, *SQUARE).sheets(5.0), "at most 0.5 m"),
        (lambda: LayUp.rectangle("0/45", FABRIC, *SQUARE).sheets(0.3), "ply_1: blank from"),
        (lambda: LayUp.rectangle("0", FABRIC, *SQUARE).sheets(0.01, mesh_along="warp"), "yarns or outline is allowed"),
        (lambda: LayUp.rectangle("0", FABRIC, *SQUARE).sheets(0.01, bottom=float("inf")), "bottom"),
    ],
)  # fmt: skip
def test_what_makes_no_stack_is_refused(make, problem):
    with pytest.raises(InputError, match=problem):
        make()


def test_what_is_unusual_can_be_meant():
    sheets = LayUp.rectangle("0.785398/0.45", FABRIC, *SQUARE).sheets(0.01, accept_unusual=True)
    assert [float(yarn_angle(sheet)[0]) for sheet in sheets] == pytest.approx([0.785398, 0.45])


def test_a_lay_up_is_a_value():
    lay_up = LayUp.rectangle("[0/45]s", FABRIC, *SQUARE)
    assert LayUp.from_json(lay_up.to_json()) == lay_up
