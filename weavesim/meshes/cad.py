"""Surfaces of STEP and IGES files, as triangles, by Open CASCADE (package cadquery-ocp-novtk).

The kernel reads in millimetres whatever the file's unit is, and triangulates each face within ``DEFLECTION`` of its
size. Curves, points and sketches bound no surface and are left out.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .mesh_file import MeshFile, cells_of
from .source import Source

SUFFIXES = (".step", ".stp", ".iges", ".igs")
# Distance of the triangles from the surface, over the size of the body, and largest angle between them [rad].
DEFLECTION, ANGLE = 1.0e-4, math.radians(6.0)
MILLIMETRE = 1.0e-3


def read_cad(source: Source) -> MeshFile:
    """All faces of a STEP or IGES file, triangulated, in millimetres.

    Raises:
        InputError: the package is not installed, or the file cannot be read or has no faces.
    """
    try:
        from OCP.BRepMesh import BRepMesh_IncrementalMesh
        from OCP.IFSelect import IFSelect_ReturnStatus
        from OCP.IGESControl import IGESControl_Reader
        from OCP.STEPControl import STEPControl_Reader
    except ImportError:
        raise source.error(
            "STEP and IGES need the package cadquery-ocp-novtk",
            "install it with pip install 'weavesim[cad]', or export the surface as STL",
        ) from None
    is_step = source.suffix in (".step", ".stp")
    _check_header(source, is_step)
    reader: Any = STEPControl_Reader() if is_step else IGESControl_Reader()
    if reader.ReadFile(str(source.path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise source.error("it is damaged, or no such file")
    reader.TransferRoots()
    shape = reader.OneShape()
    if shape.IsNull():
        raise source.error("it has no shapes")
    size = _size(shape)
    if not size > 0.0:
        raise source.error("it has no faces")
    BRepMesh_IncrementalMesh(shape, DEFLECTION * size, False, ANGLE, False)
    vertices, triangles, face_count, empty = _triangles(shape)
    if not len(triangles):
        raise source.error("it has no faces")
    notes = [f"{face_count} faces triangulated to {DEFLECTION * size:.3g} mm"]
    if empty:
        notes.append(f"{empty} faces left out: they cannot be triangulated")
    cells = cells_of(source, triangles, np.arange(1, len(triangles) + 1))
    return MeshFile(
        source.name, source.suffix[1:].upper(), vertices, (cells,), tuple(notes), "triangle",
        metres_per_unit=MILLIMETRE,
    )  # fmt: skip


def _check_header(source: Source, is_step: bool) -> None:
    """The kernel prints about files that are something else, and may take long."""
    start = source.data[:4096].lstrip()
    if is_step and not start.startswith(b"ISO-10303-21"):
        raise source.misnamed("STEP")
    if not is_step and (len(source.data) < 73 or source.data.split(b"\n", 1)[0].rstrip()[72:73] not in b"SCB"):
        raise source.misnamed("IGES")


def _size(shape: Any) -> float:
    """Diagonal of the box around a shape [mm]."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box, False)
    if box.IsVoid():
        return 0.0
    return math.sqrt(box.SquareExtent())


def _triangles(shape: Any) -> tuple[np.ndarray, np.ndarray, int, int]:
    """Vertices (n, 3) [mm], triangles (m, 3), number of faces, and of those without triangles."""
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    count = empty = 0
    explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_FACE)
    cast = getattr(TopoDS, "Face_s", None) or TopoDS.Face
    while explorer.More():
        face, place = cast(explorer.Current()), TopLoc_Location()
        explorer.Next()
        count += 1
        mesh = BRep_Tool.Triangulation_s(face, place)
        if mesh is None:
            empty += 1
            continue
        first, move = len(vertices), place.Transformation()
        for k in range(1, mesh.NbNodes() + 1):
            point = mesh.Node(k).Transformed(move)
            vertices.append([point.X(), point.Y(), point.Z()])
        is_reversed = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
        for k in range(1, mesh.NbTriangles() + 1):
            a, b, c = mesh.Triangle(k).Get()
            corners = (a, c, b) if is_reversed else (a, b, c)
            triangles.append((first + corners[0] - 1, first + corners[1] - 1, first + corners[2] - 1))
    return np.array(vertices).reshape(-1, 3), np.array(triangles, dtype=np.int64).reshape(-1, 3), count, empty
