"""OBJ: relative indices, quadrilaterals and polygons, several objects, and what is no surface."""

import numpy as np
import pytest

from tests.support.mesh_files import area_of, die, obj_text, split, written
from weavesim.errors import InputError
from weavesim.meshes import read_mesh
from weavesim.tools import MeshShape

NODES, QUADS = die()
TEXT = obj_text(NODES, QUADS.tolist())
# An L: its fourth corner is re-entrant.
CONCAVE = np.array([(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)], dtype=float)


def relative(text: str) -> str:
    """Every face counts back from the last vertex."""
    return "\n".join(
        "f " + " ".join(str(int(word) - 82) for word in line.split()[1:]) if line.startswith("f ") else line
        for line in text.split("\n")
    )


@pytest.mark.parametrize(
    "content",
    [
        TEXT,
        relative(TEXT),
        TEXT.replace("f ", "g half\nf ", 40).replace("f ", "o other\nusemtl steel\ns off\nf ", 1),
        "# Größe in mm, Oberfläche\n".encode("latin-1") + TEXT.encode(),
        TEXT.replace("\n", "\r\n"),
        "\n".join(line + " # a remark" for line in TEXT.split("\n")),
        "vt 0 0\nvn 0 0 1\n" + "\n".join(
            "f " + " ".join(f"{word}/1/1" for word in line.split()[1:]) if line[:2] == "f " else line
            for line in TEXT.split("\n")
        ),
        TEXT.replace("f 1 10 11 2", "f 1 10 \\\n11 2"),
        "\n".join(line + " 0.5 nan 0.5" if line[:2] == "v " else line for line in TEXT.split("\n")),
    ],
    ids=["plain", "relative", "groups", "Latin-1", "CRLF", "remarks", "textures", "continued", "colours"],
)  # fmt: skip
def test_all_quadrilaterals_are_read(tmp_path, content):
    mesh = read_mesh(written(tmp_path, "die.obj", content))
    assert mesh.vertices == pytest.approx(NODES)
    assert np.array_equal(mesh.quads()[0], QUADS)
    triangles, notes = mesh.triangles()
    assert len(triangles) == 128 and "64 quadrilaterals split into 128 triangles" in notes


def test_relative_indices_count_from_where_they_stand(tmp_path):
    """Two bodies, each behind its own vertices."""
    one = "v 0 0 {z}\nv 1 0 {z}\nv 0 1 {z}\nf -3 -2 -1\n"
    mesh = read_mesh(written(tmp_path, "two.obj", one.format(z=0) + one.format(z=5)))
    assert mesh.triangles()[0].tolist() == [[0, 1, 2], [3, 4, 5]]


def test_a_bent_polygon_is_noted(tmp_path):
    """Its surface is not defined by its corners."""
    bent = CONCAVE + np.outer(CONCAVE[:, 0] * CONCAVE[:, 1], (0.0, 0.0, 0.1))
    notes = read_mesh(written(tmp_path, "l.obj", obj_text(bent, [[0, 1, 2, 3, 4, 5]]))).triangles()[1]
    assert "1 polygons of 6 corners are not flat, by up to" in notes[0]


@pytest.mark.parametrize("turn", range(6))
@pytest.mark.parametrize("backwards", [False, True])
def test_a_concave_polygon_covers_what_it_should(tmp_path, turn, backwards):
    order = np.roll(np.arange(6), turn)[:: -1 if backwards else 1]
    path = written(tmp_path, "l.obj", obj_text(CONCAVE, [order.tolist()]))
    mesh = read_mesh(path)
    triangles, notes = mesh.triangles()
    area = area_of(mesh.vertices, triangles)
    assert area[:, 2].sum() == pytest.approx(-3.0 if backwards else 3.0)
    assert np.abs(area[:, 2]).sum() == pytest.approx(3.0)
    assert notes == ("1 polygons of 6 corners split into 4 triangles",)


def test_cells_of_all_numbers_of_corners_are_taken(tmp_path):
    """Rows of a plate as triangles, quadrilaterals, polygons; the tool covers the plate."""
    x = np.linspace(0.0, 100.0, 11)
    nodes = np.array([(a, b, 0.0) for b in (0.0, 50.0, 100.0) for a in x])
    lower = split(np.array([(k, k + 1, k + 12, k + 11) for k in range(10)])).tolist()
    upper = [[*range(11, 22), *range(32, 21, -1)]]
    path = written(tmp_path, "plate.obj", obj_text(nodes, lower + upper))
    shape = MeshShape.from_file(path, unit_scale=0.001, side=(0, 0, 1))
    surface = shape.surface
    assert area_of(surface.vertices, surface.faces)[:, 2].sum() == pytest.approx(0.01)
    assert surface.open_edge_count == 24


def test_lines_and_points_are_counted(tmp_path):
    notes = read_mesh(written(tmp_path, "die.obj", TEXT + "l 1 2 3\nl 2 3\np 1\n")).notes
    assert notes == ("2 lines and 1 points left out: they bound no surface",)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (TEXT + "f 1 2 90\n", "line 146: a face uses a vertex that is not there"),
        (TEXT + "f 1 2 -90\n", "line 146: a face uses a vertex that is not there"),
        (TEXT + "f 1 2 0\n", "line 146: a face needs three or more corners, counted from 1 or -1"),
        (TEXT + "f 1 2\n", "line 146: a face needs three or more corners"),
        (TEXT + "f 1 two 3\n", "line 146: finite numbers"),
        (TEXT + "f 1 2 1_1\n", "line 146: finite numbers"),
        (TEXT.replace("v -100 -100 0", "v -100 nan 0"), "line 1: finite numbers"),
        (TEXT.replace("v -100 -100 0", "v -100,0 -100,0 0"), "line 1: finite numbers.*decimal points"),
        (TEXT.replace("v -100 -100 0", "v -100 -100"), "line 1: a vertex needs three"),
        (TEXT.replace("v -100 -100 0", "v -100 -100 0 0.7"), "line 1: a vertex has a weight"),
        (TEXT + "cstype bspline\ncurv2 1 2\n", r"line 146: curved surfaces \(cstype\)"),
        (TEXT + "surf 0 1 0 1 1 2 3 4\n", r"curved surfaces \(surf\)"),
        (TEXT + "call secret.obj\n", "line 146: other files are not read; copy them"),
        (TEXT + "csh -rm secret\n", "line 146: other files are not read"),
        (TEXT + "circle 1 2\n", "line 146: not a statement of OBJ"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "no triangles"),
        (obj_text(np.array([(0, 0, 0), (2, 2, 0), (2, 0, 0), (0, 2, 0.0)]), [[0, 1, 2, 3]]), "crosses itself"),
        (obj_text(CONCAVE, [[0, 2, 1, 3, 4, 5]]), "the outline of line 7 .* crosses itself"),
    ],
)
def test_what_cannot_be_taken_is_named(tmp_path, content, message):
    with pytest.raises(InputError, match=message):
        read_mesh(written(tmp_path, "die.obj", content)).triangles()
