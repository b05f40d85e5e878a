"""OFF with and without colours."""

import numpy as np
import pytest

from tests.support.mesh_files import die, split, written
from weavesim.errors import InputError
from weavesim.meshes import read_mesh

NODES, QUADS = die()
MIXED = [*QUADS[:32].tolist(), *split(QUADS[32:]).tolist()]


def off(faces: list, head: str = "OFF\n81 {} 0\n", node: str = "", face: str = "") -> str:
    lines = [" ".join(f"{c:.9g}" for c in row) + node for row in NODES]
    lines += [f"{len(f)} {' '.join(map(str, f))}{face}" for f in faces]
    return head.format(len(faces)) + "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    "content",
    [
        off(MIXED),
        off(MIXED, "OFF 81 {} 0\n"),
        off(MIXED, "# from a colleague\nOFF\n\n# counts\n81 {} 0\n"),
        off(MIXED, "COFF\n81 {} 0\n", node=" 255 0 0 255", face=" 3 0.1 0.2 0.3"),
        off(MIXED, "NOFF\n81 {} 0\n", node=" 0 0 1"),
    ],
    ids=["plain", "one line", "remarks", "colours", "normals"],
)
def test_all_faces_are_read(tmp_path, content):
    mesh = read_mesh(written(tmp_path, "die.off", content))
    assert mesh.vertices == pytest.approx(NODES)
    assert [len(cells.nodes) for cells in mesh.cells] == [64, 32]
    assert np.array_equal(mesh.cells[1].nodes, QUADS[:32])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (off(MIXED)[:-12], "promises 81 vertices and 96 faces, one a line, but 17"),
        (off(MIXED) + "3 0 1 2\n", "178 lines follow|but 178"),
        (off(MIXED).replace("81 96", "81 4000000000", 1), "numbers of vertices and faces"),
        (off([[0, 1, 81]]), "line 84 uses a vertex that is not there"),
        (off([[0, 1]]), "line 84: a face of three or more"),
        (off(MIXED).replace("-100 -100 0", "-100 inf 0", 1), "line 3: three finite coordinates"),
        (off(MIXED, "OFF BINARY\n81 {} 0\n"), "in binary"),
        (off(MIXED, "4OFF\n81 {} 0\n"), "another dimension"),
        ("OFF\n", "ends after its first line"),
        ("a letter to a friend\n", "not like OFF"),
    ],
)
def test_what_cannot_be_taken_is_named(tmp_path, content, message):
    with pytest.raises(InputError, match=message):
        read_mesh(written(tmp_path, "die.off", content))
