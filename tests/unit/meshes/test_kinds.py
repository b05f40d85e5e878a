"""A file under the wrong name is told what it looks like."""

import pytest

from tests.support.mesh_files import ascii_solid, binary_stl, die, obj_text, split, written
from weavesim.errors import InputError
from weavesim.meshes import READERS, read_mesh
from weavesim.meshes.kinds import is_text, looks_like

NODES, QUADS = die(2)
CONTENTS = {
    "a binary STL file": binary_stl(NODES, split(QUADS)),
    "an ASCII STL file": ascii_solid(NODES, split(QUADS)).encode(),
    "an OBJ file": obj_text(NODES, QUADS.tolist()).encode(),
    "a web page": b"\n<!DOCTYPE html>\n<html><body>Sign in to go on</body></html>",
    "a ZIP archive": b"PK\x03\x04" + bytes(100),
    "a gzip archive": b"\x1f\x8b\x08" + bytes(100),
    "a STEP model": b"ISO-10303-21;\nHEADER;\n",
    "an IGES model": b" " * 72 + b"S      1\n",
    "a DXF drawing": b"  0\nSECTION\n  2\nHEADER\n",
    "a pointer of git-lfs": b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
    "text in UTF-16": "solid die".encode("utf-16"),
    "an Abaqus or CalculiX deck": b"** by hand\n*NODE\n1, 0, 0, 0\n",
    "an LS-DYNA deck": b"*KEYWORD\n*NODE\n",
    "a Nastran deck": b"$ by hand\nBEGIN BULK\nGRID,1,,0.,0.,0.\n",
    "a VTK file in XML": b'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid">',
    "a COLLADA scene": b'<?xml version="1.0"?>\n<COLLADA>',
    "an HDF5 file": b"\x89HDF\r\n\x1a\n" + bytes(100),
    "a document of a CAD": b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(100),
    "JSON": b'{"asset": {"version": "2.0"}}',
}


@pytest.mark.parametrize(("kind", "content"), CONTENTS.items(), ids=CONTENTS)
def test_a_kind_is_recognised(kind, content):
    assert looks_like(content).startswith(kind)


@pytest.mark.parametrize("ending", [".stl", ".obj", ".ply", ".off", ".inp", ".3mf", ".glb", ".vtk", ".vtu", ".msh"])
@pytest.mark.parametrize("kind", ["a web page", "a binary STL file", "a STEP model", "a gzip archive", "JSON"])
def test_a_wrong_name_is_refused_with_what_it_looks_like(tmp_path, ending, kind):
    if ending in (".stl",) and "STL" in kind:
        return
    with pytest.raises(InputError, match=f"it looks like {kind}"):
        read_mesh(written(tmp_path, "part" + ending, CONTENTS[kind]))


def test_an_unknown_ending_names_the_known_ones(tmp_path):
    with pytest.raises(
        InputError, match=r"ends in '.x_t'.*looks like a STEP model.*convert it to one of .stl, .obj, .ply, .off"
    ) as e:
        read_mesh(written(tmp_path, "part.x_t", CONTENTS["a STEP model"]))
    assert all(ending in str(e.value) for ending in READERS)
    with pytest.raises(InputError, match="its name has no ending"):
        read_mesh(written(tmp_path, "part", b"1 2 3"))


def test_text_in_any_encoding_is_text():
    assert is_text("Größe".encode("latin-1")) and is_text(b"plain") and not is_text(b"a\0b")
    assert looks_like(b"a letter to a friend") is None
