"""The film of a run: one USD file that usdview, Omniverse, Blender or Houdini play."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError
from ..measures.angles import smoothed, smoothing_weights
from ..run.frame import Frame, Outcome, RunInfo
from .colours import shear_colours
from .files import temporary_name

if TYPE_CHECKING:
    from ..tools.shapes import Triangles
    from ..tools.tool import Tool

FRAMES_PER_SECOND = 24
# Frames between two writes to disk: what is written leaves the memory, and survives a killed process.
_FRAMES_PER_FLUSH = 40
# Tools above the sheet would hide it from the camera, so they are drawn like glass.
_OPACITY_ABOVE, _OPACITY_BELOW = 0.22, 1.0
_LARGEST_SMOOTH_ANGLE = 35.0
# Per element; those that the frames have are written.
_FIELDS = ("shear_angle", "warp_stretch", "weft_stretch", "thickness", "fibre_volume_fraction")


class Film:
    """Observer that writes a USD film: sheet, tools that move, materials, camera and light.

    Frame i is at time code i. Positions are in metres, Z up. The sheet is the mesh ``/World/sheet``; with symmetry,
    mirrored copies refer to it, so that the whole part is seen and stored once. It carries ``displayColor`` by the
    absolute shear angle (nodal means, 0 to 60 degrees) and, per element and frame, ``shear_angle`` (absolute,
    degrees), ``warp_stretch``, ``weft_stretch``, ``thickness`` (metres) and, where the fabric tells its fibres,
    ``fibre_volume_fraction``. Tools are drawn as their ``display_triangles`` are and not mirrored.

    Raises:
        InputError: the path does not end in .usdc, .usda or .usd.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        if self.path.suffix not in (".usdc", ".usda", ".usd"):
            raise InputError(f"film {self.path}: the name must end in .usdc, .usda or .usd")
        self._stage: Any = None

    @staticmethod
    def load() -> None:
        """Load USD and its schemas, which takes longer than a small film; else that is done when the run starts."""
        from pxr import Gf, Kind, Sdf, Tf, Usd, UsdGeom, UsdLux, UsdShade, Vt  # noqa: F401

        UsdGeom.Mesh.Define(Usd.Stage.CreateInMemory(), "/sheet")

    def start(self, info: RunInfo) -> None:
        from pxr import Gf, Kind, Sdf, Usd, UsdGeom

        self._blank, self._symmetry = info.sheet.blank, info.sheet.symmetry
        self._smoothing_weights = smoothing_weights(self._blank, self._symmetry)
        self._tools = info.tools
        temporary = temporary_name(self.path)
        temporary.unlink(missing_ok=True)
        with _usd_errors():
            self._stage = stage = Usd.Stage.CreateNew(str(temporary))
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        stage.SetTimeCodesPerSecond(FRAMES_PER_SECOND)
        stage.SetFramesPerSecond(FRAMES_PER_SECOND)
        world = UsdGeom.Xform.Define(stage, "/World").GetPrim()
        Usd.ModelAPI(world).SetKind(Kind.Tokens.component)
        stage.SetDefaultPrim(world)
        stage.GetRootLayer().comment = f"weavesim: {info.name}, {info.sheet.fabric.name}"

        mesh = _define_mesh(stage, "/World/sheet", self._blank.quads)
        self._sheet = mesh
        primvars = UsdGeom.PrimvarsAPI(mesh)
        self._colour = primvars.CreatePrimvar(
            "displayColor", Sdf.ValueTypeNames.Color3fArray, UsdGeom.Tokens.vertex
        ).GetAttr()
        self._normals = mesh.CreateNormalsAttr()
        mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        self._fields: dict[str, Any] = {}
        _bind(mesh, _sheet_material(stage))
        for sign in self._symmetry.mirror_factors[1:]:
            names = "".join(f"_{axis}" for axis, factor in zip("xy", sign, strict=True) if factor < 0)
            copy = UsdGeom.Mesh.Define(stage, f"/World/sheet_mirrored{names}")
            copy.GetPrim().GetReferences().AddInternalReference("/World/sheet")
            copy.AddScaleOp().Set(Gf.Vec3f(*sign, 1.0))

        self._moves = []
        rest = float(self._blank.node_position[:, 2].mean())
        for tool in self._tools:
            triangles = tool.display_triangles()
            height = triangles[0][:, 2]
            above = 0.5 * float(height.min() + height.max()) > rest
            prim = _define_tool(stage, tool, triangles, _OPACITY_ABOVE if above else _OPACITY_BELOW)
            self._moves.append(prim.AddTranslateOp())
        self._extent_of_all = np.array([np.full(3, np.inf), np.full(3, -np.inf)])
        self._frames: list[int] = []

    def frame(self, frame: Frame) -> None:
        from pxr import Gf, Vt

        time, blank = float(frame.index), self._blank
        points = frame.position.astype(np.float32)
        nodal = np.rad2deg(smoothed(blank, self._smoothing_weights, frame.fields["shear_angle"]))
        extent = np.array([points.min(axis=0), points.max(axis=0)])
        self._sheet.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points), time)
        self._sheet.GetExtentAttr().Set(Vt.Vec3fArray.FromNumpy(extent), time)
        self._normals.Set(Vt.Vec3fArray.FromNumpy(_node_normals(frame.position, blank.quads)), time)
        self._colour.Set(Vt.Vec3fArray.FromNumpy(shear_colours(nodal).astype(np.float32)), time)
        if not self._fields:
            self._fields = _define_fields(self._sheet, [name for name in _FIELDS if name in frame.fields])
        for name, attribute in self._fields.items():
            values = frame.fields[name]
            values = np.abs(np.rad2deg(values)) if name == "shear_angle" else values
            attribute.Set(Vt.FloatArray.FromNumpy(values.astype(np.float32)), time)
        for tool, move, distance in zip(self._tools, self._moves, frame.tool_displacement, strict=True):
            move.Set(Gf.Vec3d(*(float(distance) * np.asarray(tool.axis, dtype=float)).tolist()), time)
        self._extent_of_all = np.array(
            [np.minimum(self._extent_of_all[0], extent[0]), np.maximum(self._extent_of_all[1], extent[1])]
        )
        self._frames.append(frame.index)
        if len(self._frames) % _FRAMES_PER_FLUSH == 0:
            with _usd_errors():
                self._stage.Save()

    def finish(self, outcome: Outcome) -> None:
        if self._stage is None or not self._frames:
            self.discard()
            return
        stage, temporary = self._stage, temporary_name(self.path)
        stage.SetStartTimeCode(float(self._frames[0]))
        stage.SetEndTimeCode(float(self._frames[-1]))
        lower, upper = self._extent_of_all
        reach = np.abs(self._extent_of_all).max(axis=0)
        for axis, name in enumerate("xy"):
            if name in self._symmetry.planes:
                lower[axis], upper[axis] = -reach[axis], reach[axis]
        _define_camera(stage, lower, upper)
        _define_light(stage)
        with _usd_errors():
            stage.Save()
        self._release()
        os.replace(temporary, self.path)

    def discard(self) -> None:
        """Give up the film and remove what was written of it."""
        self._release()
        temporary_name(self.path).unlink(missing_ok=True)

    def _release(self) -> None:
        self._stage = self._sheet = self._colour = self._normals = None
        self._fields, self._moves = {}, []


@contextmanager
def _usd_errors() -> Iterator[None]:
    """USD reports a full disk or a missing folder by errors of its own; here they are what they are."""
    from pxr import Tf

    try:
        yield
    except Tf.ErrorException as error:
        reasons = [getattr(part, "commentary", str(part)) for part in error.args]
        raise OSError("; ".join(reasons)) from error


def _define_mesh(stage: Any, path: str, faces: np.ndarray) -> Any:
    from pxr import UsdGeom, Vt

    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(faces), faces.shape[1], dtype=np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(faces, dtype=np.int32).ravel()))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(True)
    mesh.CreatePointsAttr()
    mesh.CreateExtentAttr()
    return mesh


def _define_fields(sheet: Any, names: list[str]) -> dict[str, Any]:
    """Attributes of one value per element, by name."""
    from pxr import Sdf, UsdGeom

    primvars = UsdGeom.PrimvarsAPI(sheet)
    return {
        name: primvars.CreatePrimvar(name, Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.uniform).GetAttr()
        for name in names
    }


def _define_tool(stage: Any, tool: Tool, triangles: Triangles, opacity: float) -> Any:
    """A tool as /World/tools/NAME, a transform that holds its mesh."""
    from pxr import Gf, Sdf, Tf, UsdGeom, Vt

    name = Tf.MakeValidIdentifier(tool.name)
    vertices, faces = triangles
    bounds = np.array([vertices.min(axis=0), vertices.max(axis=0)], dtype=np.float32)
    UsdGeom.Scope.Define(stage, "/World/tools")
    transform = UsdGeom.Xform.Define(stage, f"/World/tools/{name}")
    mesh = _define_mesh(stage, f"/World/tools/{name}/surface", faces)
    mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(vertices.astype(np.float32)))
    mesh.GetExtentAttr().Set(Vt.Vec3fArray.FromNumpy(bounds))
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(_corner_normals(vertices, faces)))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.faceVarying)
    mesh.CreateDisplayColorAttr([Gf.Vec3f(*tool.colour)])
    shader = _preview_surface(stage, f"/World/materials/{name}", roughness=0.35)
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*tool.colour))
    shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(opacity)
    if opacity < 1.0:
        mesh.CreateDisplayOpacityAttr([opacity])
    _bind(mesh, f"/World/materials/{name}")
    return transform


def _preview_surface(stage: Any, path: str, roughness: float) -> Any:
    from pxr import Sdf, UsdGeom, UsdShade

    UsdGeom.Scope.Define(stage, "/World/materials")
    material = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).Set(roughness)
    shader.CreateInput("metallic", Sdf.ValueTypeNames.Float).Set(0.0)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return shader


def _sheet_material(stage: Any) -> str:
    from pxr import Gf, Sdf, UsdShade

    path = "/World/materials/sheet"
    shader = _preview_surface(stage, path, roughness=0.7)
    reader = UsdShade.Shader.Define(stage, f"{path}/colour")
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("displayColor")
    reader.CreateInput("fallback", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(0.5))
    reader.CreateOutput("result", Sdf.ValueTypeNames.Float3)
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(reader.ConnectableAPI(), "result")
    return path


def _bind(mesh: Any, material_path: str) -> None:
    from pxr import UsdShade

    material = UsdShade.Material.Get(mesh.GetPrim().GetStage(), material_path)
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)


def _define_camera(stage: Any, lower: np.ndarray, upper: np.ndarray) -> None:
    """A camera above one corner that sees the sphere around ``lower`` and ``upper``."""
    from pxr import Gf, UsdGeom

    camera = UsdGeom.Camera.Define(stage, "/World/camera")
    focal_length, aperture = 50.0, (36.0, 24.0)  # tenths of a stage unit, as USD has it; only the ratio counts
    centre, radius = 0.5 * (lower + upper), 0.5 * float(np.linalg.norm(upper - lower))
    distance = 1.05 * radius / np.sin(np.arctan(0.5 * min(aperture) / focal_length))
    azimuth, elevation = np.deg2rad((-60.0, 38.0))
    outward = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    eye = centre + distance * outward
    view = Gf.Matrix4d().SetLookAt(Gf.Vec3d(*eye.tolist()), Gf.Vec3d(*centre.tolist()), Gf.Vec3d(0, 0, 1))
    camera.ClearXformOpOrder()
    camera.AddTransformOp().Set(view.GetInverse())
    camera.CreateFocalLengthAttr(focal_length)
    camera.CreateHorizontalApertureAttr(aperture[0])
    camera.CreateVerticalApertureAttr(aperture[1])
    camera.CreateFocusDistanceAttr(float(distance))
    camera.CreateClippingRangeAttr(Gf.Vec2f(0.01 * distance, 10.0 * distance))


def _define_light(stage: Any) -> None:
    from pxr import Gf, UsdGeom, UsdLux

    UsdGeom.Scope.Define(stage, "/World/lights")
    UsdLux.DomeLight.Define(stage, "/World/lights/sky").CreateIntensityAttr(0.7)
    sun = UsdLux.DistantLight.Define(stage, "/World/lights/sun")
    sun.CreateIntensityAttr(2.0)
    sun.CreateAngleAttr(3.0)
    sun.AddRotateXYZOp().Set(Gf.Vec3f(-35.0, 20.0, 0.0))


def _node_normals(position: np.ndarray, quads: np.ndarray) -> np.ndarray:
    a, b, c, d = (position[corner].T for corner in quads.T)
    (x1, y1, z1), (x2, y2, z2) = c - a, d - b
    corners = quads.T.ravel()
    total = np.stack(
        [
            np.bincount(corners, np.tile(component, 4), len(position))
            for component in (y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2)
        ]
    )
    return (total / np.maximum(np.sqrt((total * total).sum(axis=0)), 1.0e-300)).T.astype(np.float32, order="C")


def _corner_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Normals of the corners of each triangle, (3 face_count, 3): smooth, but for sharp edges."""
    corner = vertices[faces]
    side = np.roll(corner, -1, axis=1) - corner
    side /= np.maximum(np.linalg.norm(side, axis=2, keepdims=True), 1.0e-300)
    normal = np.cross(side[:, 0], side[:, 1])
    face = np.repeat(normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1.0e-300), 3, axis=0)
    # weighted by the angles of the corners, so that it does not matter how a flat face is cut into triangles
    cosine = -np.einsum("fci,fci->fc", side, np.roll(side, 1, axis=1))
    weighted = face * np.arccos(np.clip(cosine, -1.0, 1.0)).reshape(-1, 1)
    corners = faces.ravel()
    total = np.stack([np.bincount(corners, weighted[:, axis], len(vertices)) for axis in range(3)], axis=1)
    node = (total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1.0e-300))[corners]
    smooth = np.einsum("ki,ki->k", face, node) > np.cos(np.deg2rad(_LARGEST_SMOOTH_ANGLE))
    return np.where(smooth[:, None], node, face).astype(np.float32)
