"""Program that triangulates a STEP or IGES file with Open CASCADE, within bounds, and writes the triangles as ``.npz``.

    python cad_process.py PATH step|iges DEFLECTION ANGLE BYTES SECONDS

Open CASCADE throws, prints and breaks memory at damaged files; a process of its own holds that. Exit codes: 0 done, 1
the file cannot be read, 3 not enough memory, 4 no shapes, 5 no faces, 6 Open CASCADE cannot be loaded. Nothing else of
weavesim is imported here.
"""

from __future__ import annotations

import io
import math
import os
import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np

NO_MEMORY, NO_SHAPES, NO_FACES, NO_LIBRARY = 3, 4, 5, 6


def found_in(path: str, kind: str, deflection: float, angle: float) -> bytes | int:
    """Vertices (n, 3) [mm], triangles (m, 3), and the numbers of faces, of those left out, and the tolerance [mm].

    Args:
        path: of the file.
        kind: "step" or "iges".
        deflection: distance of the triangles from the surface, over the size of the body.
        angle: largest angle between triangles [rad].

    Returns:
        An array file, or an exit code.
    """
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.IGESControl import IGESControl_Reader
    from OCP.STEPControl import STEPControl_Reader

    reader: Any = STEPControl_Reader() if kind == "step" else IGESControl_Reader()
    if reader.ReadFile(path) != IFSelect_ReturnStatus.IFSelect_RetDone:
        return 1
    reader.TransferRoots()
    shape = reader.OneShape()
    if shape.IsNull():
        return NO_SHAPES
    size = _size(shape)
    if not 0.0 < size < math.inf:
        return NO_FACES
    BRepMesh_IncrementalMesh(shape, deflection * size, False, angle, False)
    vertices, triangles, face_count, empty = _triangles(shape)
    if not len(triangles):
        return NO_FACES
    content = io.BytesIO()
    counts = np.array([face_count, empty, deflection * size])
    np.savez(content, allow_pickle=False, vertices=vertices, triangles=triangles, counts=counts)
    return content.getvalue()


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


def main() -> int:
    path, kind, deflection, angle, memory, seconds = sys.argv[1:]
    result = os.dup(1)
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    try:
        import OCP.STEPControl  # noqa: F401  # what it takes by itself is not bounded
    except ImportError:
        return NO_LIBRARY
    try:
        bound = runpy.run_path(str(Path(__file__).parent / "formats" / "meshio_process.py"))["bound"]
        bound(int(memory), int(seconds))
        content = found_in(path, kind, float(deflection), float(angle))
    except MemoryError:
        return NO_MEMORY
    except BaseException:  # whatever a damaged file makes of it
        return 1
    if isinstance(content, int):
        return content
    with open(result, "wb") as out:
        out.write(content)
        out.flush()
    os._exit(0)  # what a damaged shape leaves behind may not survive its end


if __name__ == "__main__":
    sys.exit(main())
