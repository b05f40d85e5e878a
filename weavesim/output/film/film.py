"""The film of a run: one USD file for usdview, Omniverse, Blender or Houdini."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...process.motions.paths import Pose
from ...run.frame import Frame, Outcome, RunInfo, unique_names
from ...version import __version__
from ..files import note, temporary_name
from ..pace import Pace
from .legend import PATH as LEGEND
from .legend import define_legend, legend_drawing, place_legend
from .prims import define_tool, define_views, in_variant, usd_errors
from .sheet import FilmedSheet
from .view import View, define_camera, define_lights

FRAMES_PER_SECOND = 24
# Of the run, at every time code: attributes of /World.
TIME, STROKE = "weavesim:time", "weavesim:stroke"
# Between the first two saves [s]: each copies the film, which a run of seconds replaces soon after.
_FIRST_SAVE = 5.0
# Frames between two writes to disk: writing frees memory, and written frames survive a killed process.
_FRAMES_PER_FLUSH = 40
# Tools on the side of the viewer would hide the sheet, so they are drawn transparent.
_OPACITY_IN_FRONT, _OPACITY_BEHIND = 0.1, 1.0
# Between the sheets of an exploded view, over the height and the width of the part.
_GAP_TO_HEIGHT, _GAP_TO_WIDTH = 0.6, 0.1
# What Omniverse keeps in a file of its settings: exposure by the light in the picture.
_OMNIVERSE = {"rtx:post:histogram:enabled": True}


class Film:
    """Observer that writes a USD film: sheets, moving tools, materials, cameras, lights and a colour legend.

    From time to time the film so far is saved under its name, so that a killed run leaves one.

    Frame i is at time code i. Positions are in metres, Z up. Each sheet is the mesh ``/World/sheets/NAME``; with
    symmetry, mirrored copies reference it, so that the whole part is visible but stored once. It has ``displayColor``
    from the absolute shear angle (averaged to the nodes, 0 to 60 degrees, ``/World/legend``) and, per element and
    frame, the fields of ``weavesim.run.fields`` except those of the solver, with their names and units in files; the
    documentation of each tells what it is, and its unit. What a stage trims away has no faces from its frame on, and a
    tool that does not act is invisible. Each tool is the mesh ``/World/tools/NAME``: its
    ``display_triangles``, without mirroring. ``/World/camera`` looks at the side to which the part bulges,
    ``/World/camera_back`` at the other; tools on the side of the first are transparent.

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
        legend_drawing()

    def start(self, info: RunInfo) -> None:
        from pxr import Kind, Sdf, Usd, UsdGeom

        note(self.path)
        temporary = temporary_name(self.path)
        temporary.unlink(missing_ok=True)
        self._pace = Pace(_FIRST_SAVE)
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
        about = {"run_id": info.run_id, "version": __version__, "name": info.name}
        stage.GetRootLayer().customLayerData = {"weavesim": about, "renderSettings": _OMNIVERSE}
        self._clock = [world.CreateAttribute(name, Sdf.ValueTypeNames.Double) for name in (TIME, STROKE)]
        for attribute, text in zip(self._clock, ("time of the run [s]", "stroke of the leading tool [m]"), strict=True):
            attribute.SetDocumentation(text)
        # of one program's objects, whatever their folders are, no two may have the same name
        names = prim_names([*(sheet.name for sheet in info.sheets), *info.tool_names])
        several, self._levels = len(info.sheets) > 1, info.levels
        places = range(len(info.sheets)) if several else (None,)
        parts = zip(names, info.sheets, places, strict=False)
        self._sheets = [FilmedSheet(stage, *part) for part in parts]
        self._define_tools(stage, info, names[len(info.sheets) :])
        define_legend(stage)
        if several:
            with in_variant(stage, "colours", "sheets"):
                UsdGeom.Imageable.Get(stage, LEGEND).MakeInvisible()
        self._frames: list[int] = []

    def _define_tools(self, stage: Any, info: RunInfo, names: Iterable[str]) -> None:
        rest = float(np.mean(np.concatenate([sheet.blank.node_position[:, 2] for sheet in info.sheets])))
        filmed = [
            define_tool(stage, name, tool, tool.display_triangles())
            for name, tool in zip(names, info.tools, strict=True)
        ]
        self._tools = filmed
        self._axes = [np.asarray(tool.axis, dtype=float) for tool in info.tools]
        self._above = [tool for tool in filmed if tool.height > rest]
        self._below = [tool for tool in filmed if tool.height <= rest]
        self._moves, self._meshes = [], [tool.mesh for tool in filmed]
        self._turns: dict[int, Any] = {}
        self._quaternions: dict[int, Any] = {}
        for tool in filmed:
            if len(info.sheets) > 1:
                tool.mesh.AddTranslateOp(opSuffix="exploded")
            self._moves.append(tool.mesh.AddTranslateOp())

    def frame(self, frame: Frame) -> None:
        from pxr import Gf

        for sheet, state in zip(self._sheets, frame.sheets, strict=True):
            sheet.add(state, float(frame.index))
        for k, move in enumerate(self._moves):
            place = frame.place(k)
            shift = place.shift if isinstance(place, Pose) else (place * self._axes[k]).tolist()
            move.Set(Gf.Vec3d(*shift), float(frame.index))
            if isinstance(place, Pose):
                self._turn(k, place, float(frame.index))
        for k, tool in enumerate(self._tools):
            tool.show(frame.acts(k), float(frame.index))
        for attribute, value in zip(self._clock, (frame.time, frame.stroke), strict=True):
            attribute.Set(float(value), float(frame.index))
        self._frames.append(frame.index)
        if self._pace.due():
            self._complete()
            self._save()
            # a copy that has no room is no reason to give the film up
            with suppress(OSError):
                self._publish(lambda copy: shutil.copyfile(temporary_name(self.path), copy))
            self._pace.done()
        elif len(self._frames) % _FRAMES_PER_FLUSH == 0:
            self._save()

    def _turn(self, tool: int, pose: Pose, code: float) -> None:
        """Rotate a tool at a time code, as a quaternion, between which programs interpolate."""
        from pxr import Gf, UsdGeom

        if tool not in self._turns:
            self._turns[tool] = self._meshes[tool].AddOrientOp(UsdGeom.XformOp.PrecisionDouble)
        # USD's vectors are rows
        turn = Gf.Matrix3d(*pose.matrix.T.ravel().tolist()).ExtractRotation().GetQuat()
        last = self._quaternions.get(tool)
        if last is not None and Gf.Dot(last, turn) < 0.0:  # the same rotation, the short way round
            turn = -turn
        self._quaternions[tool] = turn
        self._turns[tool].Set(turn, code)

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
            self._save()
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
        """Add what makes the frames so far a film."""
        stage = self._stage
        stage.SetStartTimeCode(float(self._frames[0]))
        stage.SetEndTimeCode(float(self._frames[-1]))
        extents = [sheet.extent_of_all() for sheet in self._sheets]
        lower, upper = np.min([e[0] for e in extents], axis=0), np.max([e[1] for e in extents], axis=0)
        side = -1.0 if sum(sheet.bulges_down for sheet in self._sheets) > 0.5 * len(self._sheets) else 1.0
        in_front, behind = (self._above, self._below) if side > 0.0 else (self._below, self._above)
        for tools, opacity in ((in_front, _OPACITY_IN_FRONT), (behind, _OPACITY_BEHIND)):
            for tool in tools:
                tool.set_opacity(opacity)
        view = View.of(lower, upper, side)
        define_camera(stage, view, "camera")
        define_camera(stage, View.of(lower, upper, -side), "camera_back")
        define_lights(stage, view)
        if len(self._sheets) == 1:
            place_legend(stage, view.legend())
        else:
            gap = max(_GAP_TO_HEIGHT * (upper - lower)[2], _GAP_TO_WIDTH * (upper - lower)[:2].max())
            from_bottom = sorted(zip(self._levels, (sheet.path for sheet in self._sheets), strict=True))
            apart = View.of(lower, upper + (0.0, 0.0, gap * (len(self._sheets) - 1)), side)
            above, below = ([tool.path for tool in tools] for tools in (self._above, self._below))
            define_views(stage, [path for _, path in from_bottom], above, below, gap)
            define_camera(stage, apart, "camera_exploded")
            for name, seen in (("stacked", view), ("exploded", apart)):
                with in_variant(stage, "view", name):
                    place_legend(stage, seen.legend())

    def _save(self) -> None:
        """Write what there is to the temporary file."""
        with usd_errors():
            self._stage.Save()

    def discard(self) -> None:
        """Stop writing; what was saved under the name of the film stays."""
        self._release()
        temporary_name(self.path).unlink(missing_ok=True)

    def _release(self) -> None:
        self._stage, self._sheets, self._moves, self._clock = None, [], [], []
        self._tools, self._above, self._below = [], [], []


def prim_names(names: Iterable[str]) -> list[str]:
    """Valid, unique names of prims, each as close to the given one as possible."""
    from pxr import Tf

    return list(unique_names(Tf.MakeValidIdentifier(name) for name in names))
