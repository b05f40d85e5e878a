"""Files of numbers, read by VTK, by h5py and by the standard library."""

import csv

import h5py
import numpy as np
import pytest

from tests.support.stored_runs import stored_run, stored_sheet
from weavesim.output.export.exporting import Export, export_run
from weavesim.sheet.blank import Blank


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Two sheets, written: (sheets, files by name)."""
    blank = Blank.rectangle((0.0, 0.0), (0.03, 0.02), 0.005, yarn_angle=30.0)
    position = np.column_stack([blank.material_coordinates, 5.0 * blank.material_coordinates[:, 0] ** 2])
    stress = np.arange(3.0 * blank.element_count).reshape(-1, 3)
    sheets = tuple(stored_sheet(blank, position, name=name, stress_upper=stress) for name in ("top", "bottom"))
    done = export_run(stored_run(*sheets), Export(["vtkhdf", "hdf5", "csv"], tmp_path_factory.mktemp("files")))
    return sheets, {path.name: path for path in done.files}


def test_every_sheet_has_its_files(exported):
    assert set(exported[1]) == {f"test_{name}.{end}" for name in ("top", "bottom") for end in ("vtkhdf", "h5", "csv")}


def test_vtk_reads_its_own_format(exported):
    vtk = pytest.importorskip("vtk")
    from vtk.util.numpy_support import vtk_to_numpy

    sheets, files = exported
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(files["test_top.vtkhdf"]))
    reader.Update()
    grid = reader.GetOutput()
    assert np.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), sheets[0].position)
    assert grid.GetNumberOfCells() == sheets[0].blank.element_count and grid.GetCellType(0) == vtk.VTK_QUAD
    corners = [[grid.GetCell(e).GetPointId(k) for k in range(4)] for e in range(grid.GetNumberOfCells())]
    assert np.array_equal(corners, sheets[0].blank.quads)
    values = grid.GetCellData()
    for name, ending in (("warp_direction", ""), ("stress_upper", "_pa"), ("thickness", "_m")):
        assert np.array_equal(vtk_to_numpy(values.GetArray(f"{name}{ending}")), sheets[0].values[name].values)


def test_hdf5_is_as_documented(exported):
    sheets, files = exported
    with h5py.File(files["test_bottom.h5"]) as file:
        assert (file.attrs["format"], file.attrs["format_version"], file.attrs["name"]) == (
            "weavesim part",
            1,
            "bottom",
        )
        assert np.array_equal(file["mesh/nodes"], sheets[1].position)
        assert np.array_equal(file["mesh/quad/nodes"], sheets[1].blank.quads)
        ply = file["plies/0"]
        assert (ply.attrs["name"], ply.attrs["initial_thickness"]) == ("bottom", sheets[1].thickness)
        assert np.array_equal(ply["weft_direction"], sheets[1].values["weft_direction"].values)
        assert ply["warp_angle_deg"].attrs["unit"] == "degrees"


def test_csv_has_a_row_for_each_element(exported):
    sheets, files = exported
    with open(files["test_top.csv"], newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sheets[0].blank.element_count
    centre = sheets[0].position[sheets[0].blank.quads].mean(axis=1)
    row = rows[5]
    assert [float(row[f"centre_{axis}_m"]) for axis in "xyz"] == pytest.approx(centre[5], rel=1e-8, abs=1e-12)
    warp = sheets[0].values["warp_direction"].values[5]
    assert [float(row[f"warp_direction_{axis}"]) for axis in "xyz"] == pytest.approx(warp, abs=1e-8)
    assert [float(row[f"stress_upper_{ij}_pa"]) for ij in ("11", "22", "12")] == [15.0, 16.0, 17.0]
    assert (
        float(row["weft_angle_deg"]) - float(row["warp_angle_deg"])
        == pytest.approx(90.0 - float(row["shear_angle_deg"]), abs=1e-6)
        or float(row["weft_angle_deg"]) < 0.0
    )


def test_in_millimetres_only_the_centres_change_and_every_name_tells_its_unit(exported, tmp_path):
    sheets, files = exported
    done = export_run(stored_run(*sheets), Export(["csv"], tmp_path, unit="mm"))
    tables = []
    for path in (files["test_top.csv"], next(path for path in done.files if path.name == "test_top.csv")):
        with open(path, newline="", encoding="utf-8") as file:
            tables.append(list(csv.DictReader(file)))
    metres, millimetres = (table[5] for table in tables)
    assert float(millimetres["centre_x_mm"]) == pytest.approx(1e3 * float(metres["centre_x_m"]))
    centres = {f"centre_{axis}_{unit}" for axis in "xyz" for unit in ("m", "mm")}
    assert {k: v for k, v in metres.items() if k not in centres} == {
        k: v for k, v in millimetres.items() if k not in centres
    }
    assert {"thickness_m", "stress_upper_11_pa", "shear_angle_deg"} <= set(millimetres)
