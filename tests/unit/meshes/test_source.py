"""Opening mesh files: only regular ones, of bounded size; numbers as they are written in them."""

import os
import socket

import pytest

from tests.support.mesh_files import ascii_solid, die, split, written
from weavesim.errors import InputError
from weavesim.meshes import read_mesh, source
from weavesim.meshes.source import number, numbers, opened, whole
from weavesim.sheet.blank import Blank
from weavesim.tools import MeshShape

READ = [lambda path: MeshShape.from_file(path), lambda path: Blank.from_file(path)]


@pytest.mark.parametrize("read", READ, ids=["tool", "blank"])
class TestWhatIsNoFile:
    def test_missing(self, tmp_path, read):
        with pytest.raises(InputError, match=r"nothing.stl does not exist, so it cannot be read"):
            read(tmp_path / "nothing.stl")

    @pytest.mark.parametrize("path", ["/dev/zero", "/dev/full"])
    def test_device(self, read, path):
        with pytest.raises(InputError, match="it is a device"):
            read(path)

    def test_pipe(self, tmp_path, read):
        """Nobody writes to it: opening it would wait for ever."""
        os.mkfifo(tmp_path / "pipe.stl")
        with pytest.raises(InputError, match="it is a pipe"):
            read(tmp_path / "pipe.stl")

    def test_folder(self, tmp_path, read):
        (tmp_path / "folder.stl").mkdir()
        with pytest.raises(InputError, match="it is a folder"):
            read(tmp_path / "folder.stl")

    def test_socket(self, tmp_path, read, monkeypatch):
        monkeypatch.chdir(tmp_path)
        with socket.socket(socket.AF_UNIX) as server:
            server.bind("socket.stl")
            with pytest.raises(InputError, match="it is a socket"):
                read("socket.stl")

    def test_link_to_nothing(self, tmp_path, read):
        (tmp_path / "link.stl").symlink_to(tmp_path / "nothing")
        with pytest.raises(InputError, match="cannot be read"):
            read(tmp_path / "link.stl")

    @pytest.mark.parametrize("path", ["a\0b.stl", 5, None, b"\xff"])
    def test_no_path(self, read, path):
        with pytest.raises(InputError):
            read(path)

    @pytest.mark.parametrize("content", [b"", b"\n \n", b"\0" * 100])
    def test_empty(self, tmp_path, read, content):
        with pytest.raises(InputError, match="it is empty"):
            read(written(tmp_path, "empty.stl", content))

    def test_too_large(self, tmp_path, read, monkeypatch):
        """The limits are 2 GiB and 512 MiB; here 1000 and 500 bytes."""
        assert (source.LARGEST_FILE, source.LARGEST_TEXT) == (2**31, 2**29)
        monkeypatch.setattr(source, "LARGEST_FILE", 1000)
        monkeypatch.setattr(source, "LARGEST_TEXT", 500)
        for name, size in (("large.stl", 1000), ("large.obj", 500), ("large.inp", 500), ("large.vtk", 500)):
            with pytest.raises(InputError, match="at most .* MiB are read"):
                read(written(tmp_path, name, b"solid\n" + b" " * size))

    def test_sparse_file_of_a_terabyte(self, tmp_path, read):
        with open(tmp_path / "sparse.stl", "wb") as file:
            file.truncate(2**40)
        with pytest.raises(InputError, match="at most 2048 MiB are read"):
            read(tmp_path / "sparse.stl")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read all files")
def test_no_permission(tmp_path):
    path = written(tmp_path, "secret.stl", "solid")
    path.chmod(0)
    with pytest.raises(InputError, match="Permission denied"):
        read_mesh(path)


@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "off", "inp", "3mf", "glb", "vtk", "vtu", "msh", "mesh"])
def test_foreign_text_is_never_quoted(tmp_path, ending):
    for text in ("root:x:0:0:hunter2:/root:/bin/bash\n", "solid hunter2\nhunter2\nendsolid\n", "*hunter2\nhunter2\n"):
        with pytest.raises(InputError) as error:
            read_mesh(written(tmp_path, f"a.{ending}", text))
        assert "hunter2" not in str(error.value)


def test_a_name_cannot_forge_a_line(tmp_path):
    with pytest.raises(InputError) as error:
        read_mesh(written(tmp_path, "a\nERROR: all is lost.stl", "text"))
    assert "\n" not in str(error.value)


def test_the_mark_of_utf8_is_no_content(tmp_path):
    nodes, quads = die(2)
    path = written(tmp_path, "a.stl", "\ufeff" + ascii_solid(nodes, split(quads)))
    assert opened(path, "mesh").data.startswith(b"solid") and len(read_mesh(path).triangles()[0]) == 8


def test_numbers():
    assert numbers([b"1", b"-2.5e3", b"1.5D-3", b".5", b"+7."]) == [1.0, -2500.0, 0.0015, 0.5, 7.0]
    for wrong in (b"", b"x", b"nan", b"inf", b"1e999", b"1_0", b"1,5", b"0x10", b"1.0.0", "١".encode()):
        with pytest.raises(ValueError):
            number(wrong)
        with pytest.raises(ValueError):
            numbers([b"1", wrong])
    assert whole(b"-12") == -12
    for wrong in (b"", b"1.0", b"1_0", b"9" * 5000, b"9223372036854775807", b"x"):
        with pytest.raises(ValueError):
            whole(wrong)
