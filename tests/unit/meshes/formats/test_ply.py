"""PLY in its three encodings, with faces of any number of corners."""

import struct

import numpy as np
import pytest

from tests.support.mesh_files import die, split, written
from weavesim.errors import InputError
from weavesim.meshes import read_mesh

NODES, QUADS = die()
MIXED = [*QUADS[:32].tolist(), *split(QUADS[32:]).tolist()]


def header(kind: str, faces: int, more: str = "", vertex: str = "", face: str = "", count: int = 81) -> bytes:
    return (
        f"ply\nformat {kind} 1.0\ncomment made by hand\nelement vertex {count}\nproperty double x\nproperty double y\n"
        f"property double z\n{vertex}element face {faces}\n{face}property list uchar int vertex_indices\n"
        f"{more}end_header\n"
    ).encode()


def as_text(faces: list, **words: str) -> bytes:
    lines = [" ".join(f"{c:.17g}" for c in node) for node in NODES] + [
        f"{len(f)} {' '.join(map(str, f))}" for f in faces
    ]
    return header("ascii", len(faces), **words) + "\n".join(lines).encode() + b"\n"


def as_bytes(faces: list, order: str = "<", **words: str) -> bytes:
    kind = "binary_little_endian" if order == "<" else "binary_big_endian"
    content = header(kind, len(faces), **words) + NODES.astype(order + "f8").tobytes()
    return content + b"".join(struct.pack(f"{order}B{len(f)}i", len(f), *f) for f in faces)


@pytest.mark.parametrize("write", [as_text, as_bytes, lambda f: as_bytes(f, ">")], ids=["text", "little", "big"])
@pytest.mark.parametrize("faces", [QUADS.tolist(), split(QUADS).tolist(), MIXED], ids=["quads", "triangles", "mixed"])
def test_all_faces_are_read(tmp_path, write, faces):
    mesh = read_mesh(written(tmp_path, "die.ply", write(faces)))
    assert mesh.vertices == pytest.approx(NODES, abs=1e-12)
    assert sorted(map(tuple, faces)) == sorted(tuple(row) for cells in mesh.cells for row in cells.nodes.tolist())
    assert len(mesh.triangles()[0]) == 128


@pytest.mark.parametrize("write", [as_text, as_bytes], ids=["text", "bytes"])
def test_polygons_are_split(tmp_path, write):
    ring = [[0, 9, 18, 19, 20, 11, 2, 1]]
    triangles, notes = read_mesh(written(tmp_path, "die.ply", write(ring))).triangles()
    assert len(triangles) == 6 and set(triangles.ravel()) == set(ring[0])
    assert notes[-1] == "1 polygons of 8 corners split into 6 triangles"


def test_other_records_are_passed_over_and_noted(tmp_path):
    """Colours, a number per face, edges."""
    faces = split(QUADS).tolist()
    content = header(
        "binary_little_endian", len(faces), "element edge 2\nproperty int a\nproperty int b\n", "property uchar red\n",
        "property float quality\n",
    )  # fmt: skip
    content += b"".join(struct.pack("<3dB", *node, 7) for node in NODES)
    content += b"".join(struct.pack("<fB3i", 0.5, 3, *face) for face in faces) + struct.pack("<4i", 1, 2, 3, 4)
    mesh = read_mesh(written(tmp_path, "die.ply", content))
    assert mesh.vertices == pytest.approx(NODES) and np.array_equal(mesh.cells[0].nodes, faces)
    assert mesh.notes == ("2 records of edge left out: no surface",)


def test_what_follows_the_corners_of_a_face_may_be_wrong(tmp_path):
    """A known writer announces colours as numbers and writes a list."""
    content = as_text(MIXED, more="property uchar red\n")
    lines = content.decode().split("\n")
    first = lines.index("end_header") + 1 + len(NODES)
    lines[first:-1] = [line + " 9 1 1 1 1 1 1 1 1 1" for line in lines[first:-1]]
    assert len(read_mesh(written(tmp_path, "die.ply", "\n".join(lines))).triangles()[0]) == 128


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (as_text(MIXED)[:-30], "promises 177 records, one on each line, but"),
        (as_text(MIXED) + b"3 1 2 3\n", "promises 177 records.*178 lines follow"),
        (as_text(MIXED).replace(b"element face 96", b"element face 4000000000"), "promises 4000000000 records of face"),
        (as_bytes(MIXED).replace(b"element face 96", b"element face 99000000"), "the file ends before"),
        (as_bytes(MIXED).replace(b"element vertex 81", b"element vertex 99000000"), "the file ends before"),
        (as_bytes(MIXED)[:-1], "the file ends"),
        (as_bytes(QUADS.tolist())[:-1], "the file ends"),
        (as_bytes(MIXED) + b"\0", "1 bytes follow the last record"),
        (as_text(MIXED).replace(b"\n3 ", b"\n2 ", 1), "a face of three or more whole numbers"),
        (as_text(MIXED).replace(b"\n4 ", b"\n3 ", 1), "a face of three or more whole numbers"),
        (as_text([[0, 1, 81]]), "face 1 uses a vertex that is not there"),
        (as_bytes([[0, 1, -1]]), "face 1 uses a vertex that is not there"),
        (as_text([[0, 1]]), "a face of three or more whole numbers"),
        (as_bytes([[0, 1]]), "face 1 has 2 corners"),
        (as_bytes([[0, 1], [0, 1, 2]]), "face 1 has 2 corners"),
        (as_text(MIXED).replace(b"-100 -100", b"-100 nan", 1), "line 11: 3 finite numbers"),
        (as_text([]), "no triangles, only points"),
        (as_text(MIXED).replace(b"vertex_indices", b"corners"), "no list of vertex_indices"),
        (as_text(MIXED).replace(b"double x", b"quadruple x"), "line 5 of its header"),
        (as_text(MIXED).replace(b" 1.0", b" 2.0"), "line 2 of its header"),
        (as_text(MIXED).replace(b"property double z\n", b""), "no vertices with x, y and z"),
        (as_text(MIXED).replace(b"element face", b"element tristrips"), "96 strips of triangles"),
        (as_text(MIXED)[:60], "no end_header"),
        (b"ply me with drinks", "no end_header"),
        (b"PLY?", "not like PLY"),
    ],
)
def test_what_cannot_be_taken_is_named(tmp_path, content, message):
    with pytest.raises(InputError, match=message):
        read_mesh(written(tmp_path, "die.ply", content))
