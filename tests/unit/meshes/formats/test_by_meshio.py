"""VTK, Gmsh and Medit: all that meshio reads, and what it forgets."""

import struct

import meshio
import numpy as np
import pytest

from tests.support.mesh_files import die, meshio_within_this_process, split, written
from weavesim.errors import InputError
from weavesim.meshes import read_mesh
from weavesim.meshes.formats import by_meshio
from weavesim.sheet.blank import Blank

NODES, QUADS = die()
HALVES = [("quad", QUADS[:32]), ("triangle", split(QUADS[32:]))]
LINE = ("line", np.array([(0, 1), (1, 2)]))
VERTEX = ("vertex", np.array([[0]]))
WRITERS = {
    "die.vtk": {}, "text.vtk": {"binary": False}, "old.vtk": {"file_format": "vtk42"}, "die.vtu": {},
    "text.vtu": {"binary": False}, "whole.vtu": {"compression": None}, "die.msh": {"file_format": "gmsh"},
    "text.msh": {"file_format": "gmsh", "binary": False}, "old.msh": {"file_format": "gmsh22", "binary": False},
    "oldest.msh": {"file_format": "gmsh22"}, "die.mesh": {}, "DIE.VTK": {},
}  # fmt: skip


@pytest.fixture(autouse=True)
def quickly(monkeypatch):
    monkeypatch.setattr(by_meshio, "_read_apart", meshio_within_this_process)


@pytest.fixture(params=WRITERS)
def path(tmp_path, request):
    return tmp_path / request.param


def write(path, cells):
    options = WRITERS[path.name]
    if options.get("file_format") == "gmsh":
        path.write_bytes(gmsh(cells, options.get("binary", True)))
    else:
        meshio.Mesh(NODES, cells).write(path, **options)
    return path


GMSH = {"vertex": (0, 15), "line": (1, 1), "triangle": (2, 2), "quad": (2, 3), "triangle6": (2, 9), "quad8": (2, 16)}
GMSH |= {"quad9": (2, 10), "tetra": (3, 4), "hexahedron": (3, 5)}


def gmsh(cells, binary: bool) -> bytes:
    """Format 4.1, with nodes numbered from 101 in two blocks."""

    def row(*values, kinds="") -> bytes:
        return struct.pack("<" + kinds, *values) if binary else " ".join(map(str, values)).encode() + b"\n"

    content = f"$MeshFormat\n4.1 {int(binary)} 8\n".encode() + (struct.pack("<i", 1) + b"\n" if binary else b"")
    content += b"$EndMeshFormat\n$Nodes\n" + row(2, len(NODES), 101, 100 + len(NODES), kinds="4Q")
    for tag, part in ((1, range(40)), (2, range(40, len(NODES)))):
        content += row(2, tag, 0, len(part), kinds="3iQ") + b"".join(row(101 + k, kinds="Q") for k in part)
        content += b"".join(row(*NODES[k].tolist(), kinds="3d") for k in part)
    count = sum(len(nodes) for _, nodes in cells)
    content += (b"\n" if binary else b"") + b"$EndNodes\n$Elements\n" + row(len(cells), count, 1, count, kinds="4Q")
    first = 1
    for tag, (kind, nodes) in enumerate(cells, 1):
        dimension, number = GMSH[kind]
        content += row(dimension, tag, number, len(nodes), kinds="3iQ")
        for k, element in enumerate(nodes.tolist()):
            content += row(first + k, *(101 + n for n in element), kinds=f"{1 + len(element)}Q")
        first += len(nodes)
    return content + (b"\n" if binary else b"") + b"$EndElements\n"


def test_triangles_and_quadrilaterals_are_read(path):
    mesh = read_mesh(write(path, HALVES))
    assert mesh.vertices == pytest.approx(NODES)
    assert {c.called: len(c.nodes) for c in mesh.cells} == {"quadrilaterals": 32, "triangles": 64}
    triangles, notes = mesh.triangles()
    assert len(triangles) == 128 and notes == ("32 quadrilaterals split into 64 triangles",)


def test_lines_and_vertices_are_counted(path):
    cells = [LINE, *HALVES] if path.suffix == ".mesh" else [LINE, VERTEX, *HALVES]
    notes = read_mesh(write(path, cells)).notes
    left = "2 line" if path.suffix == ".mesh" else "2 line, 1 vertex"
    assert notes == (f"cells that bound no surface left out: {left}",)


@pytest.mark.parametrize("kind", ["tetra", "hexahedron"])
def test_volumes_are_refused(path, kind):
    cells = [(kind, np.arange(4 if kind == "tetra" else 8)[None])]
    with pytest.raises(InputError, match=f"1 cell of kind {kind}, which fill a volume"):
        read_mesh(write(path, cells + HALVES))


@pytest.mark.parametrize("name", ["die.vtk", "die.vtu", "die.msh"])
@pytest.mark.parametrize(("kind", "count", "pieces"), [("triangle6", 6, 4), ("quad8", 8, 6), ("quad9", 9, 8)])
def test_cells_of_second_order_follow_all_their_nodes(tmp_path, name, kind, count, pieces):
    path = write(tmp_path / name, [(kind, np.arange(count)[None])])
    triangles, notes = read_mesh(path).triangles()
    assert len(triangles) == pieces and set(triangles.ravel()) == set(range(count))
    assert notes == (f"1 {kind} of second order split into {pieces} triangles",)
    with pytest.raises(InputError, match=f"1 {kind} "):
        Blank.from_file(path)


def legacy(types: str, cells: str, count: int) -> str:
    size = len(cells.split())
    nodes = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 0\n2 1 0"
    return (
        f"# vtk DataFile Version 3.0\nby hand\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 float\n{nodes}\n"
        f"CELLS {count} {size}\n{cells}\nCELL_TYPES {count}\n{types}\n"
    )


def newer(types: str, offsets: str, connectivity: str) -> str:
    """The layout of version 5.1, in which meshio leaves out cells that it does not know."""
    count = len(types.split())
    head = legacy("", "", 0).replace("3.0", "5.1").partition("CELLS")[0]
    return (
        f"{head}CELLS {count + 1} {len(connectivity.split())}\nOFFSETS vtktypeint64\n{offsets}\n"
        f"CONNECTIVITY vtktypeint64\n{connectivity}\nCELL_TYPES {count}\n{types}\n"
    )


@pytest.mark.parametrize(
    "content",
    [
        legacy("9\n7\n7", "4 0 1 2 3\n4 1 4 5 2\n5 0 1 4 5 2", 3),
        newer("9 7 7", "0 4 8 13", "0 1 2 3 1 4 5 2 0 1 4 5 2"),
    ],
)
def test_polygons_are_read(tmp_path, content):
    mesh = read_mesh(written(tmp_path, "a.vtk", content))
    assert [c.nodes.tolist() for c in mesh.cells] == [[[0, 1, 2, 3], [1, 4, 5, 2]], [[0, 1, 4, 5, 2]]]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (legacy("6\n9", "4 0 1 2 3\n4 1 4 5 2", 2), "like strips or pixels"),
        (legacy("8\n9", "4 0 1 2 3\n4 1 4 5 2", 2), "like strips or pixels"),
        (newer("6 9", "0 4 8", "0 1 2 3 1 4 5 2"), "promises 2 cells, but meshio can read 1 of them"),
        (newer("9 62", "0 4 8", "0 1 2 3 1 4 5 2"), "promises 2 cells, but meshio can read 1 of them"),
        (newer("69 9", "0 3 7", "0 1 2 1 4 5 2"), "cannot be read"),
        (legacy("9", "4 0 1 2 7", 1), "cell 1 uses a vertex that is not there"),
        (legacy("9\n7", "4 0 1 2 3\n2 1 4", 2), "cell 2 has 2 corners; at least three are needed"),
        (legacy("9", "4 0 1 2 3", 1).replace("0 1 0", "0 nan 0"), "not finite"),
        (legacy("9", "4 0 1 2 3", 1).replace("POINTS 6", "POINTS 4000000000"), "promises 4000000000 points"),
        (legacy("9", "4 0 1 2 3", 1).replace("TYPES 1", "TYPES 4000000000"), "but the types of 4000000000"),
        (legacy("9", "4 0 1 2 3", 1).replace("S 1", "S 4000000000"), "promises 4000000000 cells"),
        (legacy("9", "4 0 1 2 3", 1).replace("UNSTRUCTURED_GRID", "POLYDATA"), "its dataset is POLYDATA"),
        (legacy("9", "4 0 1 2 3", 1)[:120], "cannot be read"),
        (legacy("3", "2 0 1", 1), "no triangles or quadrilaterals.*1 line"),
        ("this is no mesh", "not like legacy VTK"),
    ],
)  # fmt: skip
def test_what_cannot_be_taken_is_named(tmp_path, content, message):
    with pytest.raises(InputError, match=message):
        read_mesh(written(tmp_path, "a.vtk", content))


def test_two_pieces_are_refused(tmp_path):
    """meshio keeps the cells of the last piece only."""
    text = write(tmp_path / "text.vtu", HALVES).read_text()
    start, end = text.index("<Piece"), text.index("</Piece>") + len("</Piece>")
    path = written(tmp_path, "two.vtu", text[:end] + text[start:end] + text[end:])
    with pytest.raises(InputError, match="promises 192 cells, but meshio can read 96"):
        read_mesh(path)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8, 0.97])
def test_files_that_were_cut_off_are_refused(path, share):
    content = write(path, HALVES).read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(InputError, match="cannot be read"):
        read_mesh(path)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.vtu", "<html><body>Sign in</body></html>"), ("a.vtu", "<VTKFile type='PolyData'></VTKFile>"),
        ("a.msh", "$NOD\n1\n1 0 0 0\n$ENDNOD\n"), ("a.msh", "(0 grid)\n"), ("a.mesh", "<mesh/>"), ("a.vtu", "no XML"),
    ],
)  # fmt: skip
def test_other_files_are_refused(tmp_path, name, content):
    with pytest.raises(InputError, match="cannot be read"):
        read_mesh(written(tmp_path, name, content))


def test_a_structured_grid_is_read(tmp_path):
    points = "\n".join(f"{x} {y} 0" for y in range(3) for x in range(4))
    head = "# vtk DataFile Version 3.0\nplate\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS 4 3 1\nPOINTS 12 float\n"
    assert len(read_mesh(written(tmp_path, "a.vtk", head + points + "\n")).quads()[0]) == 6


@pytest.mark.parametrize("name", ["text.msh", "old.msh"])
@pytest.mark.parametrize("more", [-1, 1, 40])
def test_elements_beyond_those_promised_are_found(tmp_path, name, more):
    """meshio passes over what follows the promised number."""
    path = write(tmp_path / name, HALVES)
    head, mark, rest = path.read_text().partition("$Elements\n")
    first, _, lines = rest.partition("\n")
    if name == "old.msh":
        first = str(96 - more)
    else:
        words = first.split()
        first = " ".join([words[0], str(96 - more), *words[2:]])
    path.write_text(f"{head}{mark}{first}\n{lines}")
    with pytest.raises(InputError, match=r"promises elements on \d+ lines, but has \d+"):
        read_mesh(path)


@pytest.mark.parametrize("count", [0, 1, 3])
def test_types_and_cells_must_be_as_many(tmp_path, count):
    good = legacy("9\n9", "4 0 1 2 3\n4 1 4 5 2", 2)
    assert len(read_mesh(written(tmp_path, "a.vtk", good)).quads()[0]) == 2
    bad = good.replace("CELL_TYPES 2\n9\n9\n", f"CELL_TYPES {count}\n" + count * "9\n")
    with pytest.raises(InputError, match=f"promises 2 cells, but the types of {count}"):
        read_mesh(written(tmp_path, "a.vtk", bad))
