"""The film as Blender shows it: bright enough, with its legend, in the colours of the field.

Blender as a Python module (``bpy``, the extra "render") wants an older NumPy, so it may live in an environment of its
own: ``make render`` makes ``.venv-render``, which is used here, or the one whose Python BLENDER_PYTHON names.
"""

import colorsys
import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from pxr import Gf, Usd, UsdGeom

from tests.support import paths
from weavesim.output import Film
from weavesim.output.colours import encoded
from weavesim.output.film.legend import legend_drawing
from weavesim.run.frame import Outcome

SIGNS = ((1, 1), (-1, 1), (1, -1), (-1, -1))


def python_of_blender() -> str | None:
    own = paths.ROOT / ".venv-render" / "bin" / "python"
    if given := os.environ.get("BLENDER_PYTHON"):
        return given
    if own.exists():
        return str(own)
    return sys.executable if importlib.util.find_spec("bpy") else None


BLENDER = python_of_blender()
needs_blender = pytest.mark.skipif(BLENDER is None, reason="Blender is not installed: make render")


@pytest.fixture(scope="module")
def rendered(tmp_path_factory, coarse_run):
    folder = tmp_path_factory.mktemp("rendered")
    info, frames = coarse_run
    film = Film(folder / "film.usdc")
    film.start(info)
    for frame in frames:
        film.frame(frame)
    film.finish(Outcome.FINISHED)
    chosen = [0, len(frames) // 2, len(frames) - 1]
    script = Path(paths.ROOT, "tests", "support", "blender_render.py")
    command = [str(BLENDER), str(script), str(film.path), str(folder), *map(str, chosen)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    pictures = [imread(folder / f"{frame}.png")[..., :3] for frame in chosen]
    return Usd.Stage.Open(str(film.path)), chosen, pictures, json.loads((folder / "objects.json").read_text())


def pixel(stage, point: np.ndarray, picture: np.ndarray) -> np.ndarray:
    """Mean colour of the picture about a point of the scene [m]."""
    frustum = UsdGeom.Camera.Get(stage, "/World/camera").GetCamera(0.0).frustum
    place = (frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()).Transform(Gf.Vec3d(*map(float, point)))
    height, width = picture.shape[:2]
    column, row = int((0.5 + 0.5 * place[0]) * width), int((0.5 - 0.5 * place[1]) * height)
    return picture[row - 1 : row + 2, column - 1 : column + 2].mean(axis=(0, 1))


def through_tools(stage, colours: np.ndarray) -> np.ndarray:
    """Colours in linear light behind the tools that are transparent since they are in front."""
    for prim in stage.GetPrimAtPath("/World/tools").GetChildren():
        tool = UsdGeom.Mesh(prim)
        opacity = float((tool.GetDisplayOpacityAttr().Get() or [1.0])[0])
        if opacity < 1.0:
            colours = (1.0 - opacity) * colours + opacity * np.array(tool.GetDisplayColorAttr().Get()[0])
    return colours


def hue_difference(one, other) -> float:
    """Between two colours, on the circle [degrees]."""
    apart = abs(colorsys.rgb_to_hsv(*one)[0] - colorsys.rgb_to_hsv(*other)[0])
    return 360.0 * min(apart, 1.0 - apart)


@needs_blender
@pytest.mark.slow
def test_blender_shows_the_film_bright_and_in_the_colours_of_its_field(rendered, coarse_run):
    stage, chosen, pictures, objects = rendered
    mesh = UsdGeom.Mesh.Get(stage, "/World/sheets/sheet")
    quads = coarse_run[0].sheet.blank.quads
    for number, picture in zip(chosen, pictures, strict=True):
        assert 0.25 < picture.mean() < 0.85 and np.ptp(picture) > 0.5
        assert (picture > 0.99).all(axis=2).mean() < 0.02
        points = np.array(mesh.GetPointsAttr().Get(number))[quads].mean(axis=1)
        linear = np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("displayColor").Get(number))[quads].mean(axis=1)
        colours = encoded(through_tools(stage, linear))
        shown = np.array([pixel(stage, p * (*sign, 1.0), picture) for sign in SIGNS for p in points])
        expected = np.tile(colours, (len(SIGNS), 1))
        apart = np.array([hue_difference(*pair) for pair in zip(shown, expected, strict=True)])
        # some are hidden by others or in the die, and the view transform of Blender shifts hues
        assert np.median(apart) < 15.0, number
        assert np.median(shown.mean(axis=1)) > 0.25
        greenness = [colour[:, 1] - colour[:, 0] for colour in (shown, expected)]
        if np.ptp(greenness[1]) > 0.1:
            assert np.corrcoef(greenness)[0, 1] > 0.4, number
    own = encoded(linear)
    assert np.ptp(own[:, 1] - own[:, 0]) > 0.5  # from violet to green in the last frame


@needs_blender
@pytest.mark.slow
def test_blender_names_objects_after_sheets_and_tools(rendered, coarse_run):
    objects = rendered[3]
    tools = {tool.name for tool in coarse_run[0].tools}
    meshes = {name for name, kind in objects.items() if kind == "MESH"}
    assert meshes == {"sheet", "sheet_mirrored_x", "sheet_mirrored_y", "sheet_mirrored_x_y", "legend", *tools}
    assert objects["key"] == "LIGHT" and objects["camera"] == objects["camera_back"] == "CAMERA"


@needs_blender
@pytest.mark.slow
def test_blender_shows_the_legend(rendered):
    stage, _, pictures, _ = rendered
    drawing = legend_drawing()
    to_world = UsdGeom.Xformable.Get(stage, "/World/legend").ComputeLocalToWorldTransform(0.0)
    for x, lightest in ((-5.4, False), (5.4, True)):
        nearest = np.abs(drawing.points - (x, 0.0, 0.01)).sum(axis=1).argmin()
        place = np.array(to_world.Transform(Gf.Vec3d(x, 0.0, 0.01)))
        shown = pixel(stage, place, pictures[-1])
        assert hue_difference(shown, encoded(drawing.colours[nearest])) < 30.0
        assert (shown.mean() > 0.4) == lightest
