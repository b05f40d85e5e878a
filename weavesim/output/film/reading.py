"""The film of a run, read back: every frame with its fields, sheets and tools."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from .film import STROKE, TIME
from .sheet import MIRRORED, SHEETS

_SCREEN = ("displayColor", "displayOpacity")


@dataclass(frozen=True)
class FilmedField:
    """A field of the elements in a film.

    Attributes:
        name: in files.
        unit: of its values.
        description: for readers.
    """

    name: str
    unit: str
    description: str


@dataclass(frozen=True, eq=False)
class FilmedMesh:
    """A mesh of a film.

    Attributes:
        name: of its prim.
        faces: of the first frame, (face_count, 3) or (face_count, 4).
        mirrors: factors of (x, y, z) for it and for each of its mirrored copies.
        colour: linear red, green and blue; None for a sheet.
        opacity: from 0 to 1.
    """

    name: str
    faces: np.ndarray
    mirrors: tuple[tuple[float, float, float], ...] = ((1.0, 1.0, 1.0),)
    colour: tuple[float, float, float] | None = None
    opacity: float = 1.0


@dataclass(frozen=True, eq=False)
class FilmedView:
    """A camera of a film: eye and point that it looks at, upwards, and the angle of view in height [degrees]."""

    eye: np.ndarray
    target: np.ndarray
    up: np.ndarray
    angle: float


class StoredFilm:
    """A film as ``Film`` writes it.

    Args:
        path: of the file.

    Attributes:
        name: of the run.
        frames: time codes.
        times, strokes: of the run at each frame [s], [m].
        sheets, tools: meshes.
        fields: of the elements, by name in files.

    Raises:
        InputError: there is none, or it is no film of weavesim.
    """

    def __init__(self, path: Path) -> None:
        from pxr import Tf, Usd, UsdGeom

        if not path.is_file():
            raise InputError(f"film {path}: it does not exist; the writer film makes it during a run")
        try:
            self._stage = Usd.Stage.Open(str(path))
        except Tf.ErrorException:
            raise InputError(f"film {path}: damaged, or no USD file") from None
        about = self._stage.GetRootLayer().customLayerData.get("weavesim", {})
        world = self._stage.GetPrimAtPath("/World")
        sheets = self._stage.GetPrimAtPath(SHEETS)
        if not world or not sheets or not world.HasAttribute(TIME):
            raise InputError(f"film {path}: it is no film of this version of weavesim; run it again")
        self.name = str(about.get("name", path.stem))
        self.frames = list(world.GetAttribute(TIME).GetTimeSamples())
        if not self.frames:
            raise InputError(f"film {path}: it has no frames")
        self.times, self.strokes = (
            np.array([world.GetAttribute(name).Get(frame) for frame in self.frames]) for name in (TIME, STROKE)
        )
        prims = {prim.GetName(): prim for prim in sheets.GetChildren()}
        first = self.frames[0]
        self.sheets = tuple(_sheet(name, prims, first) for name in prims if MIRRORED not in name)
        tools = self._stage.GetPrimAtPath("/World/tools")
        self.tools = tuple(_tool(UsdGeom.Mesh(prim), first) for prim in tools.GetChildren()) if tools else ()
        self.fields = {
            found.name: found for mesh in self.sheets for found in self._fields_of(mesh)
        }  # sheets may have different fabrics, and so different fields

    def _prim(self, mesh: FilmedMesh) -> Any:
        folder = SHEETS if mesh.colour is None else "/World/tools"
        return self._stage.GetPrimAtPath(f"{folder}/{mesh.name}")

    def _fields_of(self, mesh: FilmedMesh) -> list[FilmedField]:
        from pxr import UsdGeom

        found = []
        for primvar in UsdGeom.PrimvarsAPI(self._prim(mesh)).GetPrimvars():
            attribute, name = primvar.GetAttr(), str(primvar.GetPrimvarName())
            if name not in _SCREEN:
                unit = str(attribute.GetCustomDataByKey("unit"))
                found.append(FilmedField(name, unit, attribute.GetDocumentation().rsplit(" [", 1)[0]))
        return found

    def points(self, mesh: FilmedMesh, frame: float) -> np.ndarray:
        """Of a mesh at a time code, where they are in the scene, (n, 3) [m]; without mirrored copies."""
        from pxr import UsdGeom

        prim = self._prim(mesh)
        points = np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get(frame), dtype=float)
        transform = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(frame)
        move, turn = np.array(transform.ExtractTranslation()), np.array(transform.ExtractRotationMatrix())
        # USD's vectors are rows
        return (points if np.array_equal(turn, np.eye(3)) else points @ turn) + move

    def faces(self, mesh: FilmedMesh, frame: float) -> np.ndarray:
        """Of a mesh at a time code, (face_count, 3) or (face_count, 4): a sheet that is trimmed loses some."""
        from pxr import UsdGeom

        return _faces(UsdGeom.Mesh(self._prim(mesh)), frame)

    def is_trimmed(self, mesh: FilmedMesh) -> bool:
        """Whether its faces change."""
        from pxr import UsdGeom

        return UsdGeom.Mesh(self._prim(mesh)).GetFaceVertexCountsAttr().GetNumTimeSamples() > 0

    def is_shown(self, mesh: FilmedMesh, frame: float) -> bool:
        """Whether a mesh is visible at a time code: a tool that does not act is not."""
        from pxr import UsdGeom

        return UsdGeom.Imageable(self._prim(mesh)).ComputeVisibility(frame) != UsdGeom.Tokens.invisible

    def values(self, mesh: FilmedMesh, field: str, frame: float) -> np.ndarray | None:
        """Of the elements of a sheet at a time code, (m,); None if it has no such field."""
        from pxr import UsdGeom

        primvar = UsdGeom.PrimvarsAPI(self._prim(mesh)).GetPrimvar(field)
        return np.array(primvar.Get(frame), dtype=float) if primvar.HasValue() else None

    def view(self, camera: str = "camera") -> FilmedView:
        """A camera by name."""
        from pxr import UsdGeom

        seen = UsdGeom.Camera.Get(self._stage, f"/World/{camera}").GetCamera(self.frames[0])
        rows = np.array(seen.transform)
        eye, up, to_eye = rows[3, :3], rows[1, :3], rows[2, :3]
        angle = float(seen.GetFieldOfView(seen.FOVVertical))
        return FilmedView(eye, eye - seen.focusDistance * to_eye, up, angle)


def _faces(mesh: Any, frame: float) -> np.ndarray:
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get(frame))
    return np.array(mesh.GetFaceVertexIndicesAttr().Get(frame)).reshape(len(counts), -1)


def _sheet(name: str, prims: dict[str, Any], first: float) -> FilmedMesh:
    from pxr import UsdGeom

    mirrors = [(1.0, 1.0, 1.0)]
    for other, prim in prims.items():
        if other.startswith(f"{name}{MIRRORED}_"):
            scale = UsdGeom.Xformable(prim).GetScaleOp().Get()
            mirrors.append((float(scale[0]), float(scale[1]), float(scale[2])))
    return FilmedMesh(name, _faces(UsdGeom.Mesh(prims[name]), first), tuple(mirrors))


def _tool(mesh: Any, first: float) -> FilmedMesh:
    red, green, blue = map(float, mesh.GetDisplayColorAttr().Get()[0])
    opacity = mesh.GetDisplayOpacityAttr().Get()
    name, faces = mesh.GetPrim().GetName(), _faces(mesh, first)
    return FilmedMesh(name, faces, colour=(red, green, blue), opacity=float(opacity[0]) if opacity else 1.0)
