"""Files that were once read in part, or not at all, for reasons that had nothing to do with them."""

import numpy as np
import pytest

from tests.support.mesh_files import binary_stl, die, split, written
from tests.support.paths import ROOT
from weavesim.errors import InputError
from weavesim.meshes import READERS, read_mesh
from weavesim.sheet.blank import Blank
from weavesim.tools import MeshShape, Tool

FILES = ROOT / "tests" / "data" / "meshes"
# Beside the bowl, 2 mm above the plate, on both sides.
BESIDE = np.array([[0.09, 0.0, 0.002], [-0.09, 0.0, 0.002]])


@pytest.mark.parametrize(
    "name",
    ["die_quads_and_triangles.inp", "die_quads_and_triangles.vtk", "die_quads_and_triangles.msh", "latin1_name.stl",
     "latin1_comment.obj", "one_byte_more.stl"],
)  # fmt: skip
def test_a_die_is_whole(name):
    shape = MeshShape.from_file(FILES / name, unit_scale=0.001, side=(0, 0, 1))
    assert len(shape.surface.faces) == 128
    assert Tool("die", shape).distance(BESIDE)[0] == pytest.approx([0.002, 0.002], abs=1e-5)


@pytest.mark.parametrize("name", ["die_cut_short.stl", "die_cut_in_second.stl"])
def test_a_die_that_was_cut_off_is_refused(name):
    with pytest.raises(InputError, match="the file ends before endsolid of solid 2, which begins at line 451"):
        MeshShape.from_file(FILES / name, unit_scale=0.001, side=(0, 0, 1))


@pytest.mark.parametrize(("name", "count"), [("mould_r3d3.inp", 18), ("sheet_reference_node.inp", 18)])
def test_decks_with_a_reference_node(name, count):
    shape = MeshShape.from_file(FILES / name, unit_scale=0.001, side=(0, 0, 1))
    assert len(shape.surface.faces) == count


def test_blanks_from_decks():
    assert Blank.from_file(FILES / "sheet_reference_node.inp", unit_scale=0.001).element_count == 9
    with pytest.raises(InputError, match=r"4 R3D3 elements \(elements 24, 25, 26, 27\), beside 23 quadrilaterals"):
        Blank.from_file(FILES / "sheet_with_triangles.inp", unit_scale=0.001)
    with pytest.raises(InputError, match=r"18 R3D3 elements .* beside 0 quadrilaterals"):
        Blank.from_file(FILES / "mould_r3d3.inp", unit_scale=0.001)


@pytest.mark.parametrize("ending", ["stl", "STL", "Stl"])
def test_the_ending_is_read_in_any_case(tmp_path, ending):
    nodes, quads = die(2)
    assert len(read_mesh(written(tmp_path, f"a.{ending}", binary_stl(nodes, split(quads)))).triangles()[0]) == 8


def test_too_little_memory_is_said(tmp_path, monkeypatch):
    def full(source):
        raise MemoryError

    monkeypatch.setitem(READERS, ".stl", full)
    with pytest.raises(InputError, match="not enough memory"):
        read_mesh(written(tmp_path, "a.stl", b"solid"))


@pytest.mark.parametrize("far", [1e16, -1e30])
def test_coordinates_that_no_unit_explains_are_refused(tmp_path, far):
    nodes, quads = die(2)
    nodes[0, 1] = far
    with pytest.raises(InputError, match="vertices lie farther than 1e.15 from the origin"):
        read_mesh(written(tmp_path, "a.stl", binary_stl(nodes, split(quads))))
