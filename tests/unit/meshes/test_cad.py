"""STEP and IGES files, written by the kernel itself, become the triangles of their surfaces."""

import subprocess
from subprocess import CompletedProcess

import numpy as np
import pytest

from weavesim import InputError
from weavesim.meshes import cad, read_mesh
from weavesim.meshes.cad_process import NO_MEMORY

pytest.importorskip("OCP", reason="needs cadquery-ocp-novtk")


def box(radius=0.0):
    """200 x 100 x 30 mm, with a rounded edge."""
    from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    shape = BRepPrimAPI_MakeBox(200.0, 100.0, 30.0).Shape()
    if radius:
        fillet = BRepFilletAPI_MakeFillet(shape)
        cast = getattr(TopoDS, "Edge_s", None) or TopoDS.Edge
        fillet.Add(radius, cast(TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_EDGE).Current()))
        shape = fillet.Shape()
    return shape


def write(path, shape):
    if path.suffix == ".step":
        from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

        writer = STEPControl_Writer()
        writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    else:
        from OCP.IGESControl import IGESControl_Writer

        writer = IGESControl_Writer()
        writer.AddShape(shape)
    writer.Write(str(path))
    return path


@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_a_box_has_its_size_and_area(tmp_path, suffix):
    mesh = read_mesh(write(tmp_path / f"box{suffix}", box()))
    faces, notes = mesh.triangles()
    assert np.allclose(np.ptp(mesh.vertices, axis=0), [200.0, 100.0, 30.0])
    corner = mesh.vertices[faces]
    area = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    assert np.isclose(area.sum(), 2 * (200 * 100 + 200 * 30 + 100 * 30))
    assert mesh.metres_per_unit == 1e-3
    assert "6 faces triangulated" in notes[0]


def test_the_triangles_face_outwards(tmp_path):
    mesh = read_mesh(write(tmp_path / "box.step", box()))
    corner = mesh.vertices[mesh.triangles()[0]]
    volume = np.einsum("ij,ij->i", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])).sum() / 6.0
    assert np.isclose(volume, 200 * 100 * 30)


def test_a_fillet_is_followed(tmp_path):
    mesh = read_mesh(write(tmp_path / "box.step", box(8.0)))
    corner = mesh.vertices[mesh.triangles()[0]]
    volume = np.einsum("ij,ij->i", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])).sum() / 6.0
    lost = (1.0 - np.pi / 4.0) * 8.0**2 * 30.0
    assert np.isclose(200 * 100 * 30 - volume, lost, rtol=0.02)


def test_it_is_a_tool_of_a_job(tmp_path):
    from weavesim.job.draft.survey import survey

    found = survey(write(tmp_path / "box.step", box(8.0)), up="+z")
    assert (found.unit, found.unit_reason) == ("mm", "as the file says")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.step", b"solid tray\n", "not like STEP"),
        ("a.step", b"ISO-10303-21;\nHEADER;\n", "damaged|no shapes"),
        ("a.igs", b"solid tray\n", "not like IGES"),
    ],
)
def test_what_is_none_is_refused(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_mesh(tmp_path / name)


def test_without_the_package_the_message_says_what_to_install(tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "OCP", None)
    path = tmp_path / "a.step"
    path.write_bytes(b"ISO-10303-21;\n")
    with pytest.raises(InputError, match=r"pip install 'weavesim\[cad\]', or export the surface as STL"):
        read_mesh(path)


@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_a_damaged_file_is_refused_without_a_word(tmp_path, capfd, suffix):
    path = write(tmp_path / f"box{suffix}", box(8.0))
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    capfd.readouterr()
    with pytest.raises(InputError, match="cannot be read: it .*; export it again, or as STL"):
        read_mesh(path)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("code", "message"), [(-11, "it is damaged, or cut off"), (1, "it is damaged"), (NO_MEMORY, "far more memory")]
)
def test_however_its_reader_ends_it_is_told(tmp_path, monkeypatch, code, message):
    path = write(tmp_path / "box.step", box())
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: CompletedProcess([], code, b"", b""))
    with pytest.raises(InputError, match=message):
        read_mesh(path)


def test_it_may_take_only_so_long(tmp_path, monkeypatch):
    path = write(tmp_path / "box.step", box())
    monkeypatch.setattr(cad, "_LONGEST", 0.01)
    with pytest.raises(InputError, match="Open CASCADE takes longer than 0.01 s"):
        read_mesh(path)
