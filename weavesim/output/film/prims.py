"""Prims of a film: meshes, tools, materials and variants in USD."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from ...tools.shapes import Triangles
    from ...tools.tool import Tool

_LARGEST_SMOOTH_ANGLE = 35.0


@contextmanager
def usd_errors() -> Iterator[None]:
    """Turn USD's own errors, for a full disk or a missing folder, into OSError."""
    from pxr import Tf

    try:
        yield
    except Tf.ErrorException as error:
        reasons = [getattr(part, "commentary", str(part)) for part in error.args]
        raise OSError("; ".join(reasons)) from error


def define_mesh(stage: Any, path: str, faces: np.ndarray) -> Any:
    """A mesh without points yet; every face has as many corners as the others."""
    from pxr import UsdGeom, Vt

    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(faces), faces.shape[1], dtype=np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.ascontiguousarray(faces, dtype=np.int32).ravel()))
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDoubleSidedAttr(True)
    mesh.CreatePointsAttr()
    mesh.CreateExtentAttr()
    return mesh


def set_faces(mesh: Any, faces: np.ndarray, time: float) -> None:
    """Other faces from a time code on."""
    from pxr import Vt

    counts = np.full(len(faces), faces.shape[1], dtype=np.int32)
    mesh.GetFaceVertexCountsAttr().Set(Vt.IntArray.FromNumpy(counts), time)
    mesh.GetFaceVertexIndicesAttr().Set(
        Vt.IntArray.FromNumpy(np.ascontiguousarray(faces, dtype=np.int32).ravel()), time
    )


def set_points(mesh: Any, points: np.ndarray) -> None:
    """Points that do not change, (n, 3), with their extent."""
    from pxr import Vt

    bounds = np.array([points.min(axis=0), points.max(axis=0)], dtype=np.float32)
    mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points, dtype=np.float32)))
    mesh.GetExtentAttr().Set(Vt.Vec3fArray.FromNumpy(bounds))


def define_tool(stage: Any, name: str, tool: Tool, triangles: Triangles) -> FilmedTool:
    """A tool as the mesh /World/tools/NAME: one prim, since programs name objects after the prim of the mesh."""
    from pxr import Gf, Sdf, UsdGeom, Vt

    vertices, faces = triangles
    UsdGeom.Scope.Define(stage, "/World/tools")
    path = f"/World/tools/{name}"
    mesh = define_mesh(stage, path, faces)
    set_points(mesh, vertices)
    mesh.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(_corner_normals(vertices, faces)))
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.faceVarying)
    mesh.CreateDisplayColorAttr([Gf.Vec3f(*tool.colour)])
    shader = _preview_surface(stage, f"/World/materials/{name}", roughness=0.45)
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*tool.colour))
    bind(mesh, f"/World/materials/{name}")
    mesh.GetPrim().SetDocumentation(f"tool {tool.name}; metres")
    return FilmedTool(mesh, shader, vertices)


class FilmedTool:
    """One tool in the film.

    Attributes:
        mesh: its prim.
        height: of its middle at the start, along z [m].
    """

    def __init__(self, mesh: Any, shader: Any, vertices: np.ndarray) -> None:
        self.mesh, self._shader = mesh, shader
        self._acted = True
        self.height = 0.5 * float(vertices[:, 2].min() + vertices[:, 2].max())

    @property
    def path(self) -> str:
        """Of its prim."""
        return str(self.mesh.GetPath())

    def show(self, acts: bool, time: float) -> None:
        """Show the tool, or hide one that does not act, from a time code on."""
        from pxr import UsdGeom

        if acts == self._acted:
            return
        self._acted = acts
        attribute = UsdGeom.Imageable(self.mesh).CreateVisibilityAttr()
        if not attribute.GetNumTimeSamples() and time > 0.0:
            attribute.Set(UsdGeom.Tokens.invisible if acts else UsdGeom.Tokens.inherited, 0.0)
        attribute.Set(UsdGeom.Tokens.inherited if acts else UsdGeom.Tokens.invisible, time)

    def set_opacity(self, opacity: float) -> None:
        """From 0 to 1, for programs with materials and for those without."""
        from pxr import Sdf

        self._shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(opacity)
        self.mesh.CreateDisplayOpacityAttr([opacity])


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


def _connect_colours(stage: Any, path: str, shader: Any, name: str) -> None:
    """Let an input of a shader read the primvar ``displayColor``."""
    from pxr import Gf, Sdf, UsdShade

    reader = UsdShade.Shader.Define(stage, f"{path}/colour")
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("displayColor")
    reader.CreateInput("fallback", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(0.5))
    reader.CreateOutput("result", Sdf.ValueTypeNames.Float3)
    shader.CreateInput(name, Sdf.ValueTypeNames.Color3f).ConnectToSource(reader.ConnectableAPI(), "result")


def sheet_material(stage: Any) -> str:
    """The material of sheets, in the colours of the field."""
    path = "/World/materials/sheet"
    _connect_colours(stage, path, _preview_surface(stage, path, roughness=0.8), "diffuseColor")
    return path


def legend_material(stage: Any) -> str:
    """A material that shines in the colours of its mesh, whatever the lights are."""
    from pxr import Gf, Sdf

    path = "/World/materials/legend"
    shader = _preview_surface(stage, path, roughness=1.0)
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(0.0))
    shader.CreateInput("useSpecularWorkflow", Sdf.ValueTypeNames.Int).Set(1)
    shader.CreateInput("specularColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(0.0))
    _connect_colours(stage, path, shader, "emissiveColor")
    return path


def plain_material(stage: Any, name: str, colour: tuple[float, float, float]) -> str:
    """A material of one colour, linear sRGB."""
    from pxr import Gf, Sdf

    path = f"/World/materials/{name}"
    shader = _preview_surface(stage, path, roughness=0.8)
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*colour))
    return path


@contextmanager
def in_variant(stage: Any, set_name: str, variant: str) -> Iterator[None]:
    """What is written inside this context belongs to a variant of /World; the first of a set is chosen by default."""
    variants = stage.GetPrimAtPath("/World").GetVariantSets().AddVariantSet(set_name)
    first = variants.GetVariantNames() == []
    variants.AddVariant(variant)
    chosen = variant if first else variants.GetVariantSelection()
    variants.SetVariantSelection(variant)
    try:
        with variants.GetVariantEditContext():
            yield
    finally:
        variants.SetVariantSelection(chosen)


def bind(mesh: Any, material_path: str) -> None:
    """Give a mesh a material."""
    from pxr import UsdShade

    material = UsdShade.Material.Get(mesh.GetPrim().GetStage(), material_path)
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)


def define_views(stage: Any, sheets: Sequence[str], above: Sequence[str], below: Sequence[str], gap: float) -> None:
    """The variant set "view" of /World: "stacked" is the part as it is, "exploded" moves its sheets ``gap`` apart [m].

    Args:
        stage: of the film.
        sheets: paths of the sheets, from the bottom to the top; the lowest stays.
        above, below: paths of the tools above and below them, which move out of the way.
        gap: between two sheets, and to the tools.
    """
    from pxr import Gf, UsdGeom

    height = dict(zip(sheets, gap * np.arange(len(sheets)), strict=True))
    height |= dict.fromkeys(above, gap * len(sheets)) | dict.fromkeys(below, -gap)
    for view, factor in (("stacked", 0.0), ("exploded", 1.0)):
        with in_variant(stage, "view", view):
            for path, up in height.items():
                move = UsdGeom.Xformable.Get(stage, path).GetTranslateOp("exploded")
                move.Set(Gf.Vec3d(0.0, 0.0, factor * float(up)))


def _corner_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Normals of the corners of each triangle, (3 face_count, 3): smooth except at sharp edges."""
    corner = vertices[faces]
    side = np.roll(corner, -1, axis=1) - corner
    side /= np.maximum(np.linalg.norm(side, axis=2, keepdims=True), 1.0e-300)
    normal = np.cross(side[:, 0], side[:, 1])
    face = np.repeat(normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1.0e-300), 3, axis=0)
    # weighted by the corner angles, so that the triangulation of a flat face does not matter
    cosine = -np.einsum("fci,fci->fc", side, np.roll(side, 1, axis=1))
    weighted = face * np.arccos(np.clip(cosine, -1.0, 1.0)).reshape(-1, 1)
    corners = faces.ravel()
    total = np.stack([np.bincount(corners, weighted[:, axis], len(vertices)) for axis in range(3)], axis=1)
    node = (total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1.0e-300))[corners]
    smooth = np.einsum("ki,ki->k", face, node) > np.cos(np.deg2rad(_LARGEST_SMOOTH_ANGLE))
    return np.where(smooth[:, None], node, face).astype(np.float32)
