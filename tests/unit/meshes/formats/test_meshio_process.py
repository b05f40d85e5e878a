"""meshio in its own process: silent, and within bounds of memory and time."""

import io
import os
import struct
import subprocess
import sys

import numpy as np
import pytest

from tests.support.mesh_files import die
from weavesim.errors import InputError
from weavesim.meshes import read_mesh
from weavesim.meshes.formats import by_meshio, meshio_process

from .test_by_meshio import HALVES, gmsh, write

NODES, _ = die()


@pytest.mark.parametrize("name", ["die.vtk", "die.vtu", "text.msh", "die.mesh"])
def test_without_a_word(tmp_path, capfd, monkeypatch, name):
    path = write(tmp_path / name, HALVES)
    capfd.readouterr()
    monkeypatch.chdir(tmp_path)
    mesh = read_mesh(path.name)
    assert mesh.vertices == pytest.approx(NODES) and len(mesh.triangles()[0]) == 128
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(InputError, match="cannot be read"):
        read_mesh(path)
    assert capfd.readouterr() == ("", "")


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not bound the memory of a process")
@pytest.mark.parametrize("tag", [10**10, 3 * 10**9, 2**61])
def test_a_node_with_a_huge_number_takes_no_memory(tmp_path, tag):
    """meshio makes a table as long as the largest number of a node."""
    content = gmsh(HALVES, True).replace(struct.pack("<Q", 181), struct.pack("<Q", tag))
    (tmp_path / "die.msh").write_bytes(content)
    before = os.times()
    with pytest.raises(InputError, match="cannot be read: it needs far more memory|cannot be read: it is damaged"):
        read_mesh(tmp_path / "die.msh")
    after = os.times()
    assert after.children_user + after.children_system - before.children_user - before.children_system < 30.0


def test_it_may_take_only_so_long(tmp_path, monkeypatch):
    monkeypatch.setattr(by_meshio, "_LONGEST", 0.01)
    with pytest.raises(InputError, match="meshio takes longer than 0.01 s"):
        read_mesh(write(tmp_path / "die.vtk", HALVES))


def test_a_python_that_is_gone(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    with pytest.raises(InputError, match="meshio cannot be started"):
        read_mesh(write(tmp_path / "die.vtk", HALVES))


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not bound the memory of a process")
def test_the_bound_holds():
    code = f"import sys; sys.path.insert(0, {str(meshio_process.__file__).rpartition('/')[0]!r})\n"
    code += "import numpy, meshio_process\nmeshio_process.bound(2**28, 60)\nnumpy.ones(2**24)\nnumpy.ones(2**27)"
    done = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True)
    assert done.returncode == 1 and "MemoryError" in done.stderr


def test_what_is_found(tmp_path):
    path = write(tmp_path / "die.vtk", HALVES)
    with np.load(io.BytesIO(meshio_process.found_in(str(path), "vtk"))) as found:
        assert found["kinds"].tolist() == ["quad", "triangle"]
        assert np.array_equal(found["nodes_1"], HALVES[1][1])
