"""STL as CAD programs write it, and as copies leave it."""

import time

import numpy as np
import pytest

from tests.support.mesh_files import ascii_solid, binary_stl, die, split, written
from weavesim.errors import InputError
from weavesim.meshes import read_mesh
from weavesim.tools import MeshShape

NODES, QUADS = die()
TRIANGLES = split(QUADS)
FIRST, SECOND = TRIANGLES[:64], TRIANGLES[64:]
ONE = ascii_solid(NODES, TRIANGLES)
TWO = ascii_solid(NODES, FIRST, "left") + ascii_solid(NODES, SECOND, "right")


def corners(mesh) -> np.ndarray:
    return mesh.vertices[mesh.triangles()[0]]


@pytest.mark.parametrize(
    "content",
    [
        ONE,
        TWO,
        ascii_solid(NODES, FIRST, "left", end=False) + ascii_solid(NODES, SECOND, "right"),
        ascii_solid(NODES, FIRST, "") + "\n" + ascii_solid(NODES, SECOND[:0], "no") + ascii_solid(NODES, SECOND, ""),
        TWO.replace("\n", "\r\n"),
        TWO.replace("\n", "\r"),
        TWO.upper(),
        "\ufeff" + TWO,
        "\n  " + TWO,
        TWO + "\n" + "\0" * 300,
        ONE.replace("solid die", "solid Stempel Größe 3").encode("latin-1"),
        ONE.replace("solid die", "solid facet vertex"),
        ONE.replace("normal 0 0 1", "normal nan -nan(ind) 1.#QNAN"),
        binary_stl(NODES, TRIANGLES),
        binary_stl(NODES, TRIANGLES, b"solid die exported by a program that does not know better"),
        binary_stl(NODES, TRIANGLES, b"solid\n facet normal"),
    ],
    ids=[
        "one", "two", "no endsolid between", "empty solid", "CRLF", "CR", "capitals", "BOM", "blanks", "filled up",
        "Latin-1", "name of keywords", "no normals", "binary", "binary solid", "binary facet",
    ],
)  # fmt: skip
def test_all_triangles_are_read(tmp_path, content):
    mesh = read_mesh(written(tmp_path, "die.STL", content))
    assert corners(mesh) == pytest.approx(NODES[TRIANGLES], abs=1e-5)


def test_several_solids_are_noted(tmp_path):
    unended = ascii_solid(NODES, FIRST, "left", end=False) + ascii_solid(NODES, SECOND, "right")
    notes = read_mesh(written(tmp_path, "die.stl", unended)).notes
    assert notes == ("the triangles of all 2 solids are taken", "1 solid without endsolid before the next begins")


@pytest.mark.parametrize("share", [0.999, 0.9, 0.75, 0.5, 0.3])
@pytest.mark.parametrize("text", [ONE, TWO], ids=["one", "two"])
def test_a_text_that_was_cut_off_is_refused(tmp_path, text, share):
    """At half of two solids nothing is missing from the first, and nothing of the second is there."""
    content = text.removesuffix("endsolid right\n").removesuffix("endsolid die\n")
    for cut in (content, content[: int(share * len(content))]):
        with pytest.raises(InputError, match=r"ends before endsolid of solid \d.*line \d+.*cut off"):
            read_mesh(written(tmp_path, "die.stl", cut))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (binary_stl(NODES, TRIANGLES)[:-1], "promises 128 triangles, which take 6484 bytes, but the file has 6483"),
        (binary_stl(NODES, TRIANGLES)[:-50], "cut off"),
        (binary_stl(NODES, TRIANGLES, count=2**32 - 1), "promises 4294967295 triangles.*214748364834 bytes"),
        (binary_stl(NODES, TRIANGLES, count=0), "longer than that"),
        (2 * binary_stl(NODES, TRIANGLES), "longer than that"),
        (binary_stl(NODES, TRIANGLES)[:83], "ends after 83 bytes"),
        (binary_stl(NODES * np.nan, TRIANGLES), "128 triangles have corners that are not finite, the first is"),
        (ONE.replace("endloop", "vertex 0 0 0\n  endloop", 1), "line 7 gives a fourth corner"),
        (ONE.replace("vertex", "vertx", 1), "line 4: vertex is expected"),
        (ONE.replace("    vertex -100 -100 0\n", "    vertex -100 -100\n", 1), "line 5: a finite number"),
        (ONE.replace("-100 -100 0", "-100,5 -100 0", 1), "line 4: a finite number is expected, with a decimal point"),
        (ONE.replace("-100 -100 0", "-100 nan 0", 1), "line 4: a finite number"),
        (ONE.replace("-100 -100 0", "-100 1_0 0", 1), "line 4: a finite number"),
        (ONE.replace("-100 -100 0", "-100 1e999 0", 1), "line 4: a finite number"),
        (ONE.replace("solid die\nfacet", "solid die facet", 1), "line 1 has triangles behind the name"),
        (ONE + ONE.replace("solid die", "die", 1), "outside the solids, at line 899"),
        ("endsolid x\n" + ONE, "does not begin with solid"),
        (ONE + "endsolid die\n", "line 899 ends a solid that was not begun"),
        ("solid a\nendsolid a\n", "no triangles"),
        ("solidify\n" + ONE[9:].replace("endsolid", "end"), "ends before endsolid"),
        ("a text\nof no kind\n", "text, but does not begin with solid"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_named(tmp_path, content, message):
    with pytest.raises(InputError, match=message):
        read_mesh(written(tmp_path, "die.stl", content)).triangles()


@pytest.mark.parametrize("more", [1, 2, 49])
def test_a_few_bytes_after_a_binary_file_are_noted(tmp_path, more):
    mesh = read_mesh(written(tmp_path, "die.stl", binary_stl(NODES, TRIANGLES) + b"\0" * more))
    assert len(mesh.triangles()[0]) == 128
    assert mesh.notes == (f"{more} bytes after the last of 128 triangles ignored",)


def test_a_tool_has_both_solids(tmp_path):
    shape = MeshShape.from_file(written(tmp_path, "die.stl", TWO), unit_scale=0.001, side=(0, 0, 1))
    assert len(shape.surface.faces) == 128
    assert any("all 2 solids" in note for note in shape.surface.notes())


def test_text_and_bytes_are_read_fast(tmp_path):
    """The limits are ten times what it takes."""
    nodes, quads = die(224)
    triangles = split(quads)
    assert len(triangles) > 100_000
    text = written(tmp_path, "text.stl", ascii_solid(nodes, triangles))
    binary = written(tmp_path, "binary.stl", binary_stl(nodes, np.tile(triangles, (5, 1))))
    for path, count, limit in ((text, 1, 10.0), (binary, 5, 2.0)):
        started = time.process_time()
        mesh = read_mesh(path)
        assert time.process_time() - started < limit
        assert len(mesh.cells[0].nodes) == count * len(triangles)
