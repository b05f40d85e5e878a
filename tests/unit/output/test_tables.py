"""Tables of a formed sheet."""

import csv

import numpy as np
import pytest

from tests.support.made_run import formed
from weavesim.measures.angles import shear_angle_at, ten_points
from weavesim.measures.border import outline
from weavesim.output.tables import write_draw_in, write_shear_angles


def read(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_shear_angle_table(tmp_path, coarse_run):
    info, frames = coarse_run
    points = ten_points(0.235, 0.135)
    angle = frames[-1].fields["shear_angle"]
    write_shear_angles(tmp_path / "t.csv", formed(info, frames[-1], points))
    rows = read(tmp_path / "t.csv")
    assert [int(row["point"]) for row in rows] == list(range(1, 11))
    assert [float(rows[0][name]) for name in ("material_x_mm", "material_y_mm")] == [235.0, 0.0]
    values = [float(row["shear_angle_deg"]) for row in rows]
    assert values == pytest.approx(shear_angle_at(info.sheet.blank, angle, points, info.sheet.symmetry))
    assert values[0] < 1e-9 and values[-1] < 1e-9 and max(values) > 10.0


def test_draw_in_table_holds_the_free_border_in_order(tmp_path, coarse_run):
    info, frames = coarse_run
    blank, position = info.sheet.blank, frames[-1].position
    write_draw_in(tmp_path / "t.csv", formed(info, frames[-1]))
    rows = read(tmp_path / "t.csv")
    nodes = outline(blank, info.sheet.symmetry).node
    assert [int(row["node"]) for row in rows] == nodes.tolist()
    flat = np.array([[float(row["flat_x_mm"]), float(row["flat_y_mm"])] for row in rows])
    drawn = np.array([[float(row[f"formed_{axis}_mm"]) for axis in "xyz"] for row in rows])
    assert flat == pytest.approx(1e3 * blank.material_coordinates[nodes])
    assert drawn == pytest.approx(1e3 * position[nodes], rel=1e-6, abs=1e-6)
    assert float(rows[0]["draw_in_mm"]) == pytest.approx(flat[0, 0] - drawn[0, 0], abs=1e-6)
