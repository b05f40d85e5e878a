# ruff: noqa: E501
"""Measured points: known differences in space and on the flat blank; tables that cannot be compared are refused."""

import json

import numpy as np
import pytest

from tests.support.stored_runs import stored_sheet
from tests.support.summary_keys import keys_without_unit
from weavesim.errors import InputError
from weavesim.output.comparison.points import compare_points, read_points, write_point_comparison
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import Symmetry


def bent(lower=(-0.1, -0.05), **given):
    """A sheet on a slope, whose shear angle grows along x."""
    blank = Blank.rectangle(lower, (0.1, 0.05), 0.005)
    x, y = blank.material_coordinates.T
    angle = 20.0 + 100.0 * blank.element_centres()[:, 0]
    return stored_sheet(blank, np.column_stack([0.8 * x, y, 0.6 * x]), shear_angle_deg=angle, **given)


def table(path, header, rows):
    path.write_text(header + "\n" + "\n".join(",".join(f"{value:.9g}" for value in row) for row in rows) + "\n")
    return path


def test_material_points_are_compared_by_place_and_value(tmp_path):
    flat = np.array([(-0.05, 0.0), (0.0, 0.02), (0.06, -0.03)])
    # measured 2 mm above, and 3 degrees more
    rows = np.column_stack(
        [1e3 * flat, 800 * flat[:, 0], 1e3 * flat[:, 1], 600 * flat[:, 0] + 2, 23 + 100 * flat[:, 0]]
    )
    header = "flat_x [mm],flat_y [mm],x [mm],y [mm],z [mm],shear angle [deg]"
    found = compare_points(
        bent(), read_points(table(tmp_path / "m.csv", header.replace("shear angle", "shear_angle"), rows))
    )
    assert found.distance == pytest.approx(0.002)
    numbers = found.numbers()
    assert not keys_without_unit(numbers)
    assert numbers["point_count"] == 3 and numbers["distance_mm"]["mean"] == pytest.approx(2.0)
    assert (
        numbers["shear_angle_deg"]["mean"] == pytest.approx(-3.0) and numbers["shear_angle_deg"]["compared_share"] == 1
    )
    assert numbers["shear_angle_deg"]["root_mean_square"] == pytest.approx(3.0)
    files = write_point_comparison(tmp_path, found)
    assert json.loads(files[0].read_text())["shear_angle_deg"]["mean"] == pytest.approx(-3.0)
    assert (
        files[1]
        .read_text()
        .splitlines()[0]
        .endswith("shear_angle_deg,shear_angle_deg_measured,shear_angle_deg_difference")
    )
    assert files[2].stat().st_size > 10_000


def test_points_in_space_take_the_material_under_them(tmp_path):
    flat = np.array([(-0.05, 0.0), (0.0, 0.02), (0.06, -0.03)])
    normal = np.array([-0.6, 0.0, 0.8])
    space = np.column_stack([0.8 * flat[:, 0], flat[:, 1], 0.6 * flat[:, 0]]) + 0.001 * normal
    path = table(tmp_path / "m.csv", "x,y,z,shear_angle_deg", np.column_stack([1e3 * space, 20 + 100 * flat[:, 0]]))
    found = compare_points(bent(), read_points(path, metres_per_unit=1e-3))
    assert found.distance == pytest.approx(0.001) and found.flat == pytest.approx(flat, abs=1e-9)
    assert found.numbers()["shear_angle_deg"]["largest_absolute"] < 1e-6


def test_points_beyond_a_plane_of_symmetry_are_mirrored(tmp_path):
    half = bent(lower=(0.0, -0.05), symmetry=Symmetry(("x",)))
    path = table(
        tmp_path / "m.csv", "flat_x [m],flat_y [m],shear_angle [deg]", [(-0.05, 0.0, 25.0), (0.05, 0.0, -25.0)]
    )
    assert compare_points(half, read_points(path)).numbers()["shear_angle_deg"]["largest_absolute"] < 1e-6


def test_a_half_may_lie_on_either_side_of_its_plane(tmp_path):
    blank = Blank.rectangle((-0.1, -0.05), (0.0, 0.05), 0.005)
    x, y = blank.material_coordinates.T
    angle = 20.0 - 100.0 * blank.element_centres()[:, 0]
    half = stored_sheet(blank, np.column_stack([0.8 * x, y, 0.6 * x]), shear_angle_deg=angle, symmetry=Symmetry(("x",)))
    rows = [(0.05, 0.0, 25.0, 0.04, 0.0, -0.03), (-0.05, 0.0, 25.0, -0.04, 0.0, -0.03)]
    path = table(tmp_path / "m.csv", "flat_x [m],flat_y [m],shear_angle [deg],x [m],y [m],z [m]", rows)
    numbers = compare_points(half, read_points(path)).numbers()
    assert numbers["shear_angle_deg"]["compared_share"] == 1.0
    assert numbers["shear_angle_deg"]["largest_absolute"] < 1e-6 and numbers["distance_mm"]["largest_absolute"] < 1e-6


def test_columns_that_are_not_compared_are_told(tmp_path):
    path = table(tmp_path / "m.csv", "flat_x [mm],flat_y [mm],shear_angle [deg],shear angel 2", [(1, 2, 3, 4)])
    assert "not compared: shear_angel_2; did you mean 'shear_angle'?" in read_points(path).notes


def test_points_beside_the_sheet_do_not_count(tmp_path):
    path = table(tmp_path / "m.csv", "flat_x [m],flat_y [m],shear_angle [deg]", [(0.05, 0.0, 25.0), (0.5, 0.0, 25.0)])
    entry = compare_points(bent(), read_points(path)).numbers()["shear_angle_deg"]
    assert entry["compared_share"] == 0.5 and entry["largest_absolute"] < 1e-6


def test_points_far_from_the_sheet_in_space_do_not_count_and_are_told(tmp_path):
    sheet = bent()
    place = sheet.position[0]
    rows = [(*place, 25.0), (*(place + [-0.3, 0.0, 0.4]), 25.0)]
    found = compare_points(sheet, read_points(table(tmp_path / "m.csv", "x [m],y [m],z [m],shear_angle [deg]", rows)))
    entries = found.numbers()
    assert entries["distance_mm"]["compared_share"] == entries["shear_angle_deg"]["compared_share"] == 0.5
    assert entries["distance_mm"]["largest_absolute"] < 1e-6
    assert "1 of 2 points are not on sheet, up to 500 mm off" in found.notes[0]
    with pytest.raises(InputError, match="none of its points lies on sheet; the nearest is 500 mm off"):
        compare_points(sheet, read_points(table(tmp_path / "far.csv", "x [m],y [m],z [m]", [rows[1][:3]])))


@pytest.mark.parametrize(("angle", "note_count"), [(25.0, 0), (np.radians(25.0), 1), (5.0, 0)])
def test_measured_angles_that_look_like_radians_are_asked_about(tmp_path, angle, note_count):
    path = table(tmp_path / "m.csv", "flat_x [m],flat_y [m],shear_angle [deg]", [(0.05, 0.0, angle)])
    notes = compare_points(bent(), read_points(path)).notes
    assert len(notes) == note_count and all("are they radians" in note for note in notes)


@pytest.mark.parametrize(
    ("header", "rows", "message"),
    [
        ("angle [deg],place [mm]", [(1, 2)], "it has no places; columns x, y, z .* or flat_x, flat_y .* shear_angle"),
        ("x [mm],y [mm]", [(1, 2)], "it has a column x, but none z"),
        ("flat_x [mm],z [mm]", [(1, 2)], "it has a column flat_x, but none flat_y"),
        ("x,y,z", [(1, 2, 3)], "does not say its unit"),
        ("x [kg],y [kg],z [kg]", [(1, 2, 3)], "cannot be converted to m"),
        (
            "x [m],y [m],z [m]",
            [(50, 2, 3), (60, 2, 3)],
            "reaches 60 m from the origin, the sheet 0.08 m: give the unit",
        ),
        (
            "flat_x [m],flat_y [m],warp_stretch",
            [(0.9, 0.9, 1), (0.8, 0.8, 1)],
            "none of its points lies on the flat blank of sheet",
        ),
        ("x [mm],y [mm],z [mm],shear_angle [mm]", [(1, 2, 3, 4)], "cannot be converted to degrees"),
        ("x [mm],y [mm],z [mm]", [], "no rows below the header"),
        (
            "flat_x [mm],flat_y [mm],shear_angel [deg]",
            [(1, 2, 3)],
            "nothing was measured .* not compared: shear_angel; did you mean 'shear_angle'",
        ),
        ("flat_x [mm],flat_y [mm],thickness", [(1, 2, 1.2)], "column 'thickness' does not say its unit"),
        ("flat_x [mm],flat_y [mm],shear_angle", [(1, 2, 3)], "column 'shear_angle' does not say its unit"),
        ("x [mm],y [mm],z [mm],x [mm]", [(1, 2, 3, 4)], "column x occurs twice"),
    ],
)
def test_a_table_that_cannot_be_compared_is_refused(tmp_path, header, rows, message):
    with pytest.raises(InputError, match=message):
        compare_points(bent(), read_points(table(tmp_path / "m.csv", header, rows)))
