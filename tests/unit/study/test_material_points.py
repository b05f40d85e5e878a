"""Fields at common points: the same points on every mesh, what a linear field says there, and the file."""

import h5py
import numpy as np
import pytest

from tests.support.runs import one_sheet_setup, small_run
from weavesim.fabric.presets import glass_polypropylene
from weavesim.sheet.blank import Blank
from weavesim.study.material_points import SheetPoints, fields_at, points_of, write_fields


def test_points_are_inside_and_about_as_many_as_wanted():
    blank = Blank.rectangle((0.0, 0.0), (0.04, 0.02), 0.005)
    setup = one_sheet_setup(name="s", blank=blank, fabric=glass_polypropylene(), duration=1e-3)
    (points,) = points_of(setup, 200)
    assert 180 <= len(points.flat) <= 220 and points.name == "sheet"
    assert (points.flat > 0.0).all() and (points.flat < [0.04, 0.02]).all()


def test_a_position_is_that_of_the_material_point_on_any_mesh():
    points = SheetPoints("sheet", np.array([[0.003, 0.004], [0.011, 0.017], [0.5, 0.5]]))
    for size in (0.005, 0.004):
        run = small_run(blank=Blank.rectangle((0.0, 0.0), (0.02, 0.02), size))
        found = fields_at(run, [points])
        position = found["sheet/position"]
        assert position.dtype == np.float32
        assert position[:2, :2] == pytest.approx(points.flat[:2], abs=1e-8)
        assert np.isnan(position[2]).all()  # not on this blank
        assert found["sheet/warp_stretch"][:2] == pytest.approx(1.0)


def test_the_file_has_inputs_measures_and_fields_in_one_order(tmp_path):
    points = SheetPoints("sheet", np.zeros((4, 2)))
    runs = [{"sheet/position": np.full((4, 3), k), "sheet/shear_angle": np.full(4, k)} for k in range(3)]
    write_fields(
        tmp_path / "f.h5", [points], {"force": [1.0, 2.0, 3.0], "fabric": ["a", "b", "c"]}, {"force": "N"},
        {"m": [0.1, None, 0.3]}, runs, ["k0", "k1", "k2"],
    )  # fmt: skip
    with h5py.File(tmp_path / "f.h5") as file:
        assert file["inputs/force"][:].tolist() == [1.0, 2.0, 3.0] and file["inputs/force"].attrs["unit"] == "N"
        assert file["inputs/fabric"].asstr()[:].tolist() == ["a", "b", "c"]
        assert np.isnan(file["measures/m"][1]) and file["runs"].asstr()[2] == "k2"
        assert file["sheets/0/position"].shape == (3, 4, 3) and file["sheets/0/shear_angle"][2, 0] == 2.0
        assert file["sheets/0/shear_angle"].attrs["unit"] == "rad" and "thickness" not in file["sheets/0"]
