"""The film of a run: one USD file for usdview, Omniverse, Blender or Houdini."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..measures.angles import smoothed, smoothing_weights
from ..run.fields import FIELDS
from ..run.frame import Frame, Outcome, RunInfo, SheetFrame, SheetInfo, unique_names
from ..version import __version__
from .colours import distinct_colour, shear_colours
from .files import note, temporary_name
from .pace import Pace
from .usd import (
    bind,
    define_camera,
    define_light,
    define_mesh,
    define_tool,
    define_views,
    in_variant,
    node_normals,
    plain_material,
    sheet_material,
    usd_errors,
)

FRAMES_PER_SECOND = 24
# Frames between two writes to disk: writing frees memory, and written frames survive a killed process.
_FRAMES_PER_FLUSH = 40
# Tools above the sheet would hide it from the camera, so they are drawn transparent.
_OPACITY_ABOVE, _OPACITY_BELOW = 0.22, 1.0
# Between the sheets of an exploded view, over the height and the width of the part.
_GAP_TO_HEIGHT, _GAP_TO_WIDTH = 0.6, 0.1


class Film:
    """Observer that writes a USD film: sheets, moving tools, materials, camera and light.

    From time to time the film so far is saved under its name, so that a killed run leaves one.

    Frame i is at time code i. Positions are in metres, Z up. The sheet of a run is the mesh ``/World/sheet``, or
    ``/World/sheet_NAME`` if it has its own name. With symmetry, mirrored copies reference it, so that the whole part
    is visible but stored once. It has ``displayColor`` from the absolute shear angle (smoothed to the nodes, 0 to 60
    degrees) and, per element and frame, the fields of ``weavesim.run.fields`` that have a ``film``, with their names
    and units in files; ``shear_angle_deg`` is the absolute value. Tools are drawn as their ``display_triangles``,
    without mirroring.

    With several sheets, ``/World`` has two variant sets. "view" is "stacked", or "exploded": sheets and tools moved
    apart along z, which ``/World/camera_exploded`` sees. "colours" is "shear_angle", or "sheets": each sheet in a
    colour of its own. The visibility of a sheet is that of its prim and its mirrored copies.

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
        """Load USD and its schemas in advance, which takes longer than a small film; otherwise ``start`` does it."""
        from pxr import Gf, Kind, Sdf, Tf, Usd, UsdGeom, UsdLux, UsdShade, Vt  # noqa: F401

        UsdGeom.Mesh.Define(Usd.Stage.CreateInMemory(), "/sheet")

    def start(self, info: RunInfo) -> None:
        from pxr import Kind, Usd, UsdGeom

        note(self.path)
        temporary = temporary_name(self.path)
        temporary.unlink(missing_ok=True)
        self._pace = Pace()
        with usd_errors():
            self._stage = stage = Usd.Stage.CreateNew(str(temporary))
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        stage.SetTimeCodesPerSecond(FRAMES_PER_SECOND)
        stage.SetFramesPerSecond(FRAMES_PER_SECOND)
        world = UsdGeom.Xform.Define(stage, "/World").GetPrim()
        Usd.ModelAPI(world).SetKind(Kind.Tokens.component)
        stage.SetDefaultPrim(world)
        fabrics = dict.fromkeys(sheet.fabric.name for sheet in info.sheets)
        stage.GetRootLayer().comment = f"weavesim: {info.name}, {', '.join(fabrics)}"
        stage.GetRootLayer().customLayerData = {"weavesim": {"run_id": info.run_id, "version": __version__}}
        names = prim_names("sheet" if sheet.name == "sheet" else f"sheet_{sheet.name}" for sheet in info.sheets)
        several, self._levels = len(info.sheets) > 1, info.levels
        places = range(len(info.sheets)) if several else (None,)
        parts = zip(names, info.sheets, places, strict=True)
        self._sheets = [_FilmedSheet(stage, *part) for part in parts]
        self._define_tools(stage, info, several)
        define_light(stage)
        self._frames: list[int] = []

    def _define_tools(self, stage: Any, info: RunInfo, several: bool) -> None:
        self._tools, self._moves = info.tools, []
        self._above: list[str] = []
        self._below: list[str] = []
        rest = float(np.mean(np.concatenate([sheet.blank.node_position[:, 2] for sheet in info.sheets])))
        for name, tool in zip(prim_names(info.tool_names), self._tools, strict=True):
            triangles = tool.display_triangles()
            height = triangles[0][:, 2]
            above = 0.5 * float(height.min() + height.max()) > rest
            prim = define_tool(stage, name, tool, triangles, _OPACITY_ABOVE if above else _OPACITY_BELOW)
            (self._above if above else self._below).append(str(prim.GetPath()))
            if several:
                prim.AddTranslateOp(opSuffix="exploded")
            self._moves.append(prim.AddTranslateOp())

    def frame(self, frame: Frame) -> None:
        from pxr import Gf

        for sheet, state in zip(self._sheets, frame.sheets, strict=True):
            sheet.add(state, float(frame.index))
        for tool, move, distance in zip(self._tools, self._moves, frame.tool_displacement, strict=True):
            move.Set(Gf.Vec3d(*(float(distance) * np.asarray(tool.axis, dtype=float)).tolist()), float(frame.index))
        self._frames.append(frame.index)
        if self._pace.due():
            self._complete()
            # a copy that has no room is no reason to give the film up
            with suppress(OSError):
                self._publish(lambda copy: shutil.copyfile(temporary_name(self.path), copy))
            self._pace.done()
        elif len(self._frames) % _FRAMES_PER_FLUSH == 0:
            with usd_errors():
                self._stage.Save()

    def finish(self, outcome: Outcome) -> None:
        if self._stage is None or not self._frames:
            self.discard()
            return
        self._complete()
        # written anew, the film does not depend on when it was saved, and has no waste of those saves
        try:
            with usd_errors():
                self._publish(lambda copy: self._stage.GetRootLayer().Export(str(copy)))
        except OSError:  # there is room for one only
            self._release()
            os.replace(temporary_name(self.path), self.path)
        self.discard()

    def _publish(self, write: Callable[[Path], object]) -> None:
        """Write a copy, and let it replace the film under its final name."""
        copy = temporary_name(self.path.with_stem(f"{self.path.stem}.saved"))
        try:
            write(copy)
            os.replace(copy, self.path)
        finally:
            copy.unlink(missing_ok=True)

    def _complete(self) -> None:
        """Save what makes the frames so far a film."""
        stage = self._stage
        stage.SetStartTimeCode(float(self._frames[0]))
        stage.SetEndTimeCode(float(self._frames[-1]))
        extents = [sheet.extent_of_all() for sheet in self._sheets]
        lower, upper = np.min([e[0] for e in extents], axis=0), np.max([e[1] for e in extents], axis=0)
        define_camera(stage, lower, upper)
        if len(self._sheets) > 1:
            gap = max(_GAP_TO_HEIGHT * (upper - lower)[2], _GAP_TO_WIDTH * (upper - lower)[:2].max())
            from_bottom = sorted(zip(self._levels, (sheet.path for sheet in self._sheets), strict=True))
            define_views(stage, [path for _, path in from_bottom], self._above, self._below, gap)
            define_camera(stage, lower, upper + (0.0, 0.0, gap * (len(self._sheets) - 1)), "camera_exploded")
        with usd_errors():
            stage.Save()

    def discard(self) -> None:
        """Stop writing; what was saved under the name of the film stays."""
        self._release()
        temporary_name(self.path).unlink(missing_ok=True)

    def _release(self) -> None:
        self._stage, self._sheets, self._moves = None, [], []


class _FilmedSheet:
    """One sheet in the film: its mesh, its mirrored copies, and its time-dependent attributes.

    Args:
        stage: of the film.
        name: of its prim.
        info: about it.
        place: among several sheets; None for the only one.

    Attributes:
        path: of its prim.
    """

    def __init__(self, stage: Any, name: str, info: SheetInfo, place: int | None) -> None:
        from pxr import Gf, Sdf, UsdGeom

        self._blank, self._symmetry = info.blank, info.symmetry
        self._smoothing_weights = smoothing_weights(self._blank, self._symmetry)
        self.path = f"/World/{name}"
        self._mesh = define_mesh(stage, self.path, self._blank.quads)
        primvars = UsdGeom.PrimvarsAPI(self._mesh)
        self._colour = primvars.CreatePrimvar(
            "displayColor", Sdf.ValueTypeNames.Color3fArray, UsdGeom.Tokens.vertex
        ).GetAttr()
        self._normals = self._mesh.CreateNormalsAttr()
        self._mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        if place is None:
            bind(self._mesh, sheet_material(stage))
        else:
            self._mesh.AddTranslateOp(opSuffix="exploded")
            own = plain_material(stage, name, distinct_colour(place))
            for colours, material in (("shear_angle", sheet_material(stage)), ("sheets", own)):
                with in_variant(stage, "colours", colours):
                    bind(self._mesh, material)
        for factors in self._symmetry.mirror_factors[1:]:
            names = "".join(f"_{axis}" for axis, factor in zip("xy", factors, strict=True) if factor < 0)
            copy = UsdGeom.Mesh.Define(stage, f"{self.path}_mirrored{names}")
            copy.GetPrim().GetReferences().AddInternalReference(self.path)
            copy.AddScaleOp().Set(Gf.Vec3f(*factors, 1.0))
        self._fields: dict[str, Any] = {}
        self._extent = np.array([np.full(3, np.inf), np.full(3, -np.inf)])

    def add(self, frame: SheetFrame, time: float) -> None:
        """Write the state of a frame at its time code."""
        from pxr import Vt

        points = frame.position.astype(np.float32)
        extent = np.array([points.min(axis=0), points.max(axis=0)])
        self._extent = np.array([np.minimum(self._extent[0], extent[0]), np.maximum(self._extent[1], extent[1])])
        colours = shear_colours(np.rad2deg(smoothed(self._blank, self._smoothing_weights, frame.fields["shear_angle"])))
        self._mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points), time)
        self._mesh.GetExtentAttr().Set(Vt.Vec3fArray.FromNumpy(extent), time)
        self._normals.Set(Vt.Vec3fArray.FromNumpy(node_normals(frame.position, self._blank.quads)), time)
        self._colour.Set(Vt.Vec3fArray.FromNumpy(colours.astype(np.float32)), time)
        for field in FIELDS:
            if field.film and field.name in frame.fields:
                values = field.film(field.in_file(frame.fields[field.name]))
                self._attribute(field.file_name).Set(Vt.FloatArray.FromNumpy(values.astype(np.float32)), time)

    def _attribute(self, name: str) -> Any:
        """The attribute of a field, created on first use."""
        from pxr import Sdf, UsdGeom

        if name not in self._fields:
            primvars = UsdGeom.PrimvarsAPI(self._mesh)
            primvar = primvars.CreatePrimvar(name, Sdf.ValueTypeNames.FloatArray, UsdGeom.Tokens.uniform)
            self._fields[name] = primvar.GetAttr()
        return self._fields[name]

    def extent_of_all(self) -> np.ndarray:
        """Bounds of the whole part in all frames, (2, 3) [m]."""
        lower, upper = self._extent.copy()
        reach = np.abs(self._extent).max(axis=0)
        for axis, plane in enumerate("xy"):
            if plane in self._symmetry.planes:
                lower[axis], upper[axis] = -reach[axis], reach[axis]
        return np.array([lower, upper])


def prim_names(names: Iterable[str]) -> list[str]:
    """Valid, unique names of prims, each as close to the given one as possible."""
    from pxr import Tf

    return list(unique_names(Tf.MakeValidIdentifier(name) for name in names))
