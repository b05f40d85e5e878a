"""Comparisons: known shifts and fields on another mesh, and a scan at a known distance."""

import csv
import json

import numpy as np
import pytest
import trimesh

from tests.support.stored_runs import stored_sheet
from tests.support.summary_keys import keys_without_unit
from weavesim.errors import InputError
from weavesim.output.comparison.runs import compare_scan, compare_sheets, write_comparison
from weavesim.sheet.blank import Blank


def bent(size, shift=0.0, lower=(-0.1, -0.05)):
    """A sheet whose place and angle are linear in its material coordinates, on a mesh of any size."""
    blank = Blank.rectangle(lower, (0.1, 0.05), size)
    x, y = blank.material_coordinates.T
    centre = blank.element_centres()
    return stored_sheet(
        blank,
        np.column_stack([0.9 * x, y, 0.5 * x + shift]),
        shear_angle_deg=20.0 + 100.0 * centre[:, 0] + 50.0 * shift,
    )


def test_the_same_sheet_does_not_differ():
    found = compare_sheets(bent(0.01), bent(0.01), "b").numbers()
    assert not keys_without_unit(found)
    assert found["distance_mm"]["largest_absolute"] < 1e-6
    assert found["shear_angle_deg"]["largest_absolute"] < 1e-5
    assert found["shear_angle_deg"]["compared_share"] == 1.0


def test_a_shift_is_found_on_another_mesh():
    found = compare_sheets(bent(0.01), bent(0.007, shift=0.02), "b").numbers()
    assert found["distance_mm"]["mean"] == pytest.approx(20.0) and found["distance_mm"]["compared_share"] == 1.0
    # linear but for the outermost half elements
    assert found["shear_angle_deg"]["mean"] == pytest.approx(-1.0, abs=0.02)
    assert found["shear_angle_deg"]["largest_absolute"] == pytest.approx(1.0, abs=0.4)


def test_only_what_both_have_is_compared():
    found = compare_sheets(bent(0.01), bent(0.01, lower=(0.0, -0.05)), "b").numbers()
    assert found["shear_angle_deg"]["compared_share"] == pytest.approx(0.5)
    assert found["distance_mm"]["largest_absolute"] < 1e-6
    with pytest.raises(InputError, match="no point in common"):
        far = Blank.rectangle((1.0, 1.0), (1.1, 1.1), 0.01)
        compare_sheets(bent(0.01), stored_sheet(far, far.node_position), "b")


def test_a_scan_is_compared_by_its_nearest_point(tmp_path):
    blank = Blank.rectangle((-0.05, -0.05), (0.05, 0.05), 0.01)
    sheet = stored_sheet(blank, blank.node_position)
    plate = trimesh.Trimesh([[-200, -200, 3], [200, -200, 3], [200, 200, 3], [-200, 200, 3]], [[0, 1, 2], [0, 2, 3]])
    plate.export(tmp_path / "scan.stl")
    found = compare_scan(sheet, tmp_path / "scan.stl", 1e-3)
    assert found.distance == pytest.approx(0.003, rel=1e-5)
    assert [file.suffix for file in write_comparison(tmp_path, found)] == [".json", ".csv", ".png"]


@pytest.mark.parametrize("half", [0, 1])
def test_a_scan_of_a_part_of_the_sheet_is_compared_there(tmp_path, half):
    blank = Blank.rectangle((-0.05, -0.05), (0.05, 0.05), 0.005)
    sheet = stored_sheet(blank, blank.node_position)
    x = np.array([[-60, 1], [-1, 60]])[half]
    corners = [[x[0], -60, 3], [x[1], -60, 3], [x[1], 60, 3], [x[0], 60, 3]]
    trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]]).export(tmp_path / "scan.stl")
    found = compare_scan(sheet, tmp_path / "scan.stl", 1e-3).numbers()["distance_mm"]
    assert found["compared_share"] == pytest.approx(11 / 21)
    assert found["largest_absolute"] == pytest.approx(3.0, rel=1e-5)


def test_the_border_of_a_scan_of_the_sheet_itself_counts(tmp_path):
    sheet = bent(0.01)
    quads = sheet.blank.quads
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    trimesh.Trimesh(1e3 * sheet.position + [0, 0, 2.0], triangles, process=False).export(tmp_path / "scan.stl")
    found = compare_scan(sheet, tmp_path / "scan.stl", 1e-3).numbers()["distance_mm"]
    assert found["compared_share"] == 1.0 and found["largest_absolute"] <= 2.0 + 1e-4


def test_a_scan_in_another_place_is_refused(tmp_path):
    blank = Blank.rectangle((-0.05, -0.05), (0.05, 0.05), 0.01)
    sheet = stored_sheet(blank, blank.node_position)
    plate = trimesh.Trimesh([[940, -60, 0], [1060, -60, 0], [1060, 60, 0], [940, 60, 0]], [[0, 1, 2], [0, 2, 3]])
    plate.export(tmp_path / "scan.stl")
    with pytest.raises(InputError, match=r"it is 890 mm away from the sheet sheet, .*; move it to the place"):
        compare_scan(sheet, tmp_path / "scan.stl", 1e-3)


def test_files_tell_the_same(tmp_path):
    files = write_comparison(tmp_path, compare_sheets(bent(0.01), bent(0.01, shift=0.02), "b"))
    told = json.loads(files[0].read_text())
    with open(files[1], newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 200
    difference = [float(row["shear_angle_deg_difference"]) for row in rows]
    assert np.mean(difference) == pytest.approx(told["shear_angle_deg"]["mean"])
    assert float(rows[0]["distance_mm"]) == pytest.approx(20.0)


def test_a_scan_in_another_unit_is_told(tmp_path):
    blank = Blank.rectangle((-0.05, -0.05), (0.05, 0.05), 0.01)
    sheet = stored_sheet(blank, blank.node_position)
    plate = trimesh.Trimesh([[-60, -60, 0], [60, -60, 0], [60, 60, 0], [-60, 60, 0]], [[0, 1, 2], [0, 2, 3]])
    plate.export(tmp_path / "scan.stl")
    with pytest.raises(InputError, match=r"it is 1.2e\+03 times as large as the sheet sheet; check its unit"):
        compare_scan(sheet, tmp_path / "scan.stl", 1.0)
    with pytest.raises(InputError, match="unit: is required with scan.stl"):
        compare_scan(sheet, tmp_path / "scan.stl", None)
