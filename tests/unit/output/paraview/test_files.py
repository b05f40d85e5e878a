"""Files of VTK in XML: any numbers come back as they were, packed or not."""

import zlib

import meshio
import numpy as np
import pytest

from weavesim.output.paraview import files
from weavesim.output.paraview.files import Grid, blocks_text

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.5]])


@pytest.mark.parametrize("faces", [np.array([[0, 1, 2, 3]]), np.array([[0, 1, 2], [0, 2, 3]])])
@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_numbers_come_back(tmp_path, faces, real):
    values = np.arange(3.0 * len(faces)).reshape(-1, 3).astype(real)
    grid = Grid(faces, {"kind": np.full(len(faces), 7, dtype=np.uint8)}, {"flat": POINTS.astype(real)})
    path = tmp_path / "grid.vtu"
    point_data = {"count": np.arange(4, dtype=np.int32)}
    grid.write(path, POINTS.astype(real), point_data, {"vector <1>": values}, "run & more")
    mesh = meshio.read(path)
    assert mesh.points.dtype == real and np.array_equal(mesh.points, POINTS.astype(real))
    assert np.array_equal(mesh.cells[0].data, faces)
    assert np.array_equal(mesh.cell_data["vector <1>"][0], values) and set(mesh.cell_data["kind"][0]) == {7}
    assert np.array_equal(mesh.point_data["count"], np.arange(4)) and np.array_equal(mesh.point_data["flat"], POINTS)


def test_blocks_nest():
    text = blocks_text({"a & b": "a.vtu", "tools": {"punch": "p.vtu"}}, "run")
    assert 'name="a &amp; b" file="a.vtu"' in text
    assert text.index('<Block index="1" name="tools">') < text.index('name="punch"') < text.index("</Block>")


@pytest.mark.parametrize("length", [0, 1, 0xFFFF, 0x10000, 3 * 0xFFFF, 200_000])
def test_zlib_reads_what_is_stored(length):
    data = np.random.default_rng(length).integers(0, 256, length, dtype=np.uint8)
    assert zlib.decompress(b"".join(files._stored(data.data))) == data.tobytes()
