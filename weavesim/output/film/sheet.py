"""A sheet in a film: its mesh, its mirrored copies, and what changes with time."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...measures.angles import smoothed, smoothing_weights
from ...measures.border import outline
from ...run.fields import FIELDS, Field
from ...run.frame import SheetFrame, SheetInfo
from ...run.staging.part import Part
from ...sheet.topology import node_normals
from ..colours import LARGEST_SHOWN_ANGLE, distinct_colour, shear_colours
from .prims import bind, define_mesh, in_variant, plain_material, set_faces, sheet_material

# Where sheets are in a film, and how the names of mirrored copies go on.
SHEETS = "/World/sheets"
MIRRORED = "_mirrored"
_COLOURS = (
    f"absolute shear angle, averaged to the nodes, from 0 to {LARGEST_SHOWN_ANGLE:g} degrees in the colours of "
    "/World/legend, linear sRGB"
)


class FilmedSheet:
    """One sheet in the film.

    Args:
        stage: of the film.
        name: of the prim.
        info: of the sheet.
        place: among several sheets; None for the only one.

    Attributes:
        path: of its prim.
        bulges_down: whether its border is above its middle at the last frame.
    """

    def __init__(self, stage: Any, name: str, info: SheetInfo, place: int | None) -> None:
        from pxr import Gf, Sdf, UsdGeom

        self._blank, self._symmetry = info.blank, info.symmetry
        self._smoothing_weights = smoothing_weights(self._blank, self._symmetry)
        self.path = f"{SHEETS}/{name}"
        self.bulges_down = False
        UsdGeom.Scope.Define(stage, SHEETS)
        self._mesh = define_mesh(stage, self.path, self._blank.quads)
        self._mesh.GetPrim().SetDocumentation(
            f"sheet {info.name} of {info.fabric.name}, {1.0e3 * info.fabric.thickness:.4g} mm thick; metres, "
            f"{self._symmetry.share:g} of the whole part, of which its mirrored copies are the rest"
        )
        primvars = UsdGeom.PrimvarsAPI(self._mesh)
        self._colour = primvars.CreatePrimvar(
            "displayColor", Sdf.ValueTypeNames.Color3fArray, UsdGeom.Tokens.vertex
        ).GetAttr()
        self._colour.SetDocumentation(_COLOURS)
        self._normals = self._mesh.CreateNormalsAttr()
        self._mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        self._paint(stage, name, place)
        for factors in self._symmetry.mirror_factors[1:]:
            names = "".join(f"_{axis}" for axis, factor in zip("xy", factors, strict=True) if factor < 0)
            copy = UsdGeom.Mesh.Define(stage, f"{self.path}{MIRRORED}{names}")
            copy.GetPrim().GetReferences().AddInternalReference(self.path)
            copy.AddScaleOp().Set(Gf.Vec3f(*factors, 1.0))
        self._border = outline(self._blank, self._symmetry).node
        self._fields: dict[str, Any] = {}
        self._part = Part(info, np.zeros(0, dtype=bool))
        self._whole, self._last_time = info, 0.0
        self._extent = np.array([np.full(3, np.inf), np.full(3, -np.inf)])

    def _paint(self, stage: Any, name: str, place: int | None) -> None:
        """Materials: of the field, and for one of several sheets a colour of its own."""
        if place is None:
            bind(self._mesh, sheet_material(stage))
            return
        self._mesh.AddTranslateOp(opSuffix="exploded")
        own = plain_material(stage, name, distinct_colour(place))
        for colours, material in (("shear_angle", sheet_material(stage)), ("sheets", own)):
            with in_variant(stage, "colours", colours):
                bind(self._mesh, material)

    def add(self, frame: SheetFrame, time: float) -> None:
        """Write the state of a frame at its time code."""
        from pxr import Vt

        if not self._part.holds(frame):
            self._trim(frame.kept, time)
        self._last_time = time
        points = frame.position.astype(np.float32)
        _, shown = self._part.of(frame)
        extent = np.array([shown.position.min(axis=0), shown.position.max(axis=0)]).astype(np.float32)
        self._extent = np.array([np.minimum(self._extent[0], extent[0]), np.maximum(self._extent[1], extent[1])])
        height = shown.position[:, 2]
        self.bulges_down = float(height[self._border].mean()) > float(height.mean()) + 1.0e-3 * float(np.ptp(height))
        angle = smoothed(self._part.info.blank, self._smoothing_weights, shown.fields["shear_angle"])
        colours = np.zeros((len(points), 3))
        colours[self._part.nodes] = shear_colours(np.rad2deg(angle))
        self._mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points), time)
        self._mesh.GetExtentAttr().Set(Vt.Vec3fArray.FromNumpy(extent), time)
        normals = node_normals(frame.position, self._quads).astype(np.float32, order="C")
        self._normals.Set(Vt.Vec3fArray.FromNumpy(normals), time)
        self._colour.Set(Vt.Vec3fArray.FromNumpy(colours.astype(np.float32)), time)
        for field in FIELDS:
            if field.name in shown.fields and not field.diagnostic:
                values = field.in_file(shown.fields[field.name]).astype(np.float32)
                self._attribute(field).Set(Vt.FloatArray.FromNumpy(values), time)

    @property
    def _quads(self) -> np.ndarray:
        """Elements that are there, by the nodes of the whole sheet."""
        return self._blank.quads[self._part.kept] if len(self._part.kept) else self._blank.quads

    def _trim(self, kept: np.ndarray, time: float) -> None:
        """Show only some elements from a time code on; the nodes stay those of the whole sheet."""
        if not self._mesh.GetFaceVertexCountsAttr().GetNumTimeSamples():
            set_faces(self._mesh, self._quads, self._last_time)
        self._part = Part(self._whole, kept)
        set_faces(self._mesh, self._quads, time)
        blank = self._part.info.blank
        self._smoothing_weights = smoothing_weights(blank, self._symmetry)
        self._border = outline(blank, self._symmetry).node

    def _attribute(self, field: Field) -> Any:
        """The attribute of a field, created on first use."""
        name = field.file_name
        if name not in self._fields:
            from pxr import Sdf, UsdGeom

            primvars = UsdGeom.PrimvarsAPI(self._mesh)
            attribute = primvars.CreatePrimvar(name, Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.uniform).GetAttr()
            attribute.SetDocumentation(f"{field.description} [{field.file_unit}]")
            attribute.SetCustomDataByKey("unit", field.file_unit)
            self._fields[name] = attribute
        return self._fields[name]

    def extent_of_all(self) -> np.ndarray:
        """Bounds of the whole part in all frames, (2, 3) [m]."""
        lower, upper = self._extent.copy()
        reach = np.abs(self._extent).max(axis=0)
        for axis, plane in enumerate("xy"):
            if plane in self._symmetry.planes:
                lower[axis], upper[axis] = -reach[axis], reach[axis]
        return np.array([lower, upper])
