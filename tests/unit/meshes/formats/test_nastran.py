"""Bulk data in free, small and large fields."""

import meshio
import numpy as np
import pytest

from tests.support.mesh_files import die, split, written
from weavesim.errors import InputError
from weavesim.meshes import read_mesh
from weavesim.sheet.blank import Blank

NODES, QUADS = die()
NODES = NODES.round(3)
SHELLS = [("CQUAD4", QUADS[:32]), ("CTRIA3", split(QUADS[32:]))]


def free() -> str:
    lines = [f"GRID,{101 + k},,{x},{y},{z}" for k, (x, y, z) in enumerate(NODES.tolist())]
    first = 1
    for name, nodes in SHELLS:
        lines += [f"{name},{first + k},1,{','.join(str(n + 101) for n in row)}" for k, row in enumerate(nodes.tolist())]
        first += len(nodes)
    return "\n".join(["SOL 101", "CEND", "BEGIN BULK", "$ by hand", *lines, "ENDDATA", "after, the, end"]) + "\n"


def small(more: str = "") -> str:
    lines = [f"{'GRID':<8}{101 + k:>8}{'':8}{x:>8.2f}{y:>8.2f}{z:>8.3f}" for k, (x, y, z) in enumerate(NODES.tolist())]
    first = 1
    for name, nodes in SHELLS:
        for k, row in enumerate(nodes.tolist()):
            lines.append(f"{name:<8}{first + k:<8}{1:<8}" + "".join(f"{n + 101:<8}" for n in row) + more)
        first += len(nodes)
    return "\n".join(["BEGIN BULK", *lines, "ENDDATA"]) + "\n"


def large() -> str:
    lines = []
    for k, (x, y, z) in enumerate(NODES.tolist()):
        lines += [f"{'GRID*':<8}{101 + k:>16}{'':16}{x:>16.9E}{y:>16.9E}*G{k}", f"{f'*G{k}':<8}{z:>16.9E}"]
    first = 1
    for name, nodes in SHELLS:
        for k, row in enumerate(nodes.tolist()):
            fields = [first + k, 1, *(n + 101 for n in row)]
            lines.append(f"{name + '*':<8}" + "".join(f"{v:>16}" for v in fields[:4]))
            lines.append(f"{'*':<8}" + "".join(f"{v:>16}" for v in fields[4:]))
        first += len(nodes)
    return "\n".join(lines) + "\n"


def read(folder, content, name="die.bdf"):
    return read_mesh(written(folder, name, content))


@pytest.mark.parametrize(
    "content",
    [
        free(), small(), large(), small("0.0     0.5"), free().lower(), free().replace("\n", "\r\n"),
        free().replace(",-100.0,", ",-1.0+2,"),
        free().replace(",1,101,", ",1,101 ,").replace("GRID,101,,", "GRID,101,0,"),
    ],
    ids=["free", "small", "large", "offsets", "small letters", "CRLF", "exponent", "blanks"],
)  # fmt: skip
@pytest.mark.parametrize("ending", ["bdf", "nas", "fem"])
def test_all_shells_are_read(tmp_path, content, ending):
    mesh = read(tmp_path, content, f"die.{ending}")
    assert mesh.vertices == pytest.approx(NODES, abs=0.006)
    assert {c.called: len(c.nodes) for c in mesh.cells} == {"CQUAD4 elements": 32, "CTRIA3 elements": 64}
    assert np.array_equal(mesh.cells[0].nodes, QUADS[:32])
    assert mesh.node_labels.tolist() == list(range(101, 182))


def test_fields_may_be_full_and_tabs_may_lead_to_them(tmp_path):
    cards = ["GRID    1               -12.3456-98.76541.2345-3", "GRID\t2\t\t-12.345\t0.5\t2.0", "GRID,3,,1.,0.,0."]
    mesh = read(tmp_path, "\n".join([*cards, "CTRIA3,1,1,1,2,3"]))
    assert mesh.vertices.tolist() == [[-12.3456, -98.7654, 1.2345e-3], [-12.345, 0.5, 2.0], [1.0, 0.0, 0.0]]
    # a full z, and after it the system of the displacements, which is the basic one
    cards[0] = "GRID    1       0       0.0     0.0     -12.34560"
    mesh = read(tmp_path, "\n".join([*cards, "CTRIA3,1,1,1,2,3"]))
    assert mesh.vertices[0].tolist() == [0.0, 0.0, -12.3456]


def test_what_meshio_writes(tmp_path):
    path = tmp_path / "die.bdf"
    cells = [("quad", QUADS[:32]), ("triangle", split(QUADS[32:])), ("line", np.array([[0, 1]]))]
    meshio.Mesh(NODES, cells).write(path)
    mesh = read_mesh(path)
    assert len(mesh.triangles()[0]) == 128
    assert mesh.notes == ("elements that bound no surface left out: 1 CBAR",)


def test_shells_of_second_order(tmp_path):
    points = "".join(f"GRID,{k},,{x},{y},0.\n" for k, (x, y) in enumerate(
        [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)], 1))  # fmt: skip
    mesh = read(tmp_path, points + "CQUAD8,1,1,1,2,3,4,5,6\n+,7,8\nCTRIA6,2,1,1,2,3,5,6,7\n")
    triangles, notes = mesh.triangles()
    assert len(triangles) == 10 and "1 CQUAD8 elements of second order split into 6 triangles" in notes


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (free().replace("GRID,101,,", "GRID,101,2,"), "line 5: a grid point in another system"),
        (free().replace("$ by hand", "GRDSET,,2"), "line 4: grid points in another system"),
        (free().replace("$ by hand", "INCLUDE '/etc/passwd'"), "line 4: INCLUDE is not followed"),
        (free().replace("$ by hand", "CTETRA,900,1,101,102,103,104"), "line 4: CTETRA fills a volume"),
        (free().replace("$ by hand", "CHEXA,900,1,101,102,103,104,105,106\n+,107,108"), "line 4: CHEXA fills a volume"),
        (free().replace("$ by hand", "CTRIAX6,900,1,101,102,103"), "line 4: elements CTRIAX6 are not read"),
        (free().replace("$ by hand", "CQUAD8,900,1,101,102,103,104,,,\n+,,"), "line 4: the numbers of CQUAD8"),
        (free().replace("$ by hand", "CQUAD4,900,1,101,102,103"), "line 4: the numbers of CQUAD4"),
        (free().replace("$ by hand", "CQUAD4,900,1,101,102,103,999"), "element 900 uses node 999 of the deck"),
        (free().replace("$ by hand", "CQUAD4,1,1,101,102,103,104"), "element 1 of the deck is given twice"),
        (free().replace("$ by hand", "GRID,101,,5.,5.,5."), "node 101 of the deck is given twice, at different places"),
        (free().replace("$ by hand", "GRID,900,,nan,5.,5."), "line 4: the numbers of GRID"),
        (
            free().replace("$ by hand", "GRID,900,,0,1,0,2,0,3"),
            "line 4: whole numbers in place of coordinates, as decimal",
        ),
        (free().replace("$ by hand", "GRID,900,,0.5,1.5,0.2,0.1"), "line 4: the numbers of GRID"),
        (free().replace("$ by hand", "GRID,x,,1.,5.,5."), "line 4: the numbers of GRID"),
        (
            free().replace("$ by hand", "GRID\t900\t\t-12.34567\t1.0\t2.0"),
            "line 4: a coordinate is wider than its field of 8",
        ),
        (
            free().replace("$ by hand", "GRID    900             1.0     2.0     12.345678"),
            "line 4: a coordinate is wider than",
        ),
        (free().replace("$ by hand", "grid points: see below"), "line 4 is no card of bulk data"),
        ("BEGIN BULK\n+,1,2\n", "line 2 continues a card that was not begun"),
        ("BEGIN BULK\nGRID,1,,0.,0.,0.\nCBAR,1,1,1,2\nENDDATA\n", "no CTRIA3 or CQUAD4"),
        ("CQUAD4,1,1,1,2,3,4\n", "has elements but no nodes"),
    ],
)
def test_what_cannot_be_taken_is_named(tmp_path, content, message):
    with pytest.raises(InputError, match=message):
        read(tmp_path, content)


def test_a_blank_from_bulk_data(tmp_path):
    with pytest.raises(InputError, match=r"64 CTRIA3 elements \(elements 33, 34"):
        Blank.from_file(written(tmp_path, "sheet.bdf", free()), unit_scale=0.001)
