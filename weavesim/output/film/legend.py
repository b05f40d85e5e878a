"""The colour legend of a film: a mesh, since no scene description has text that every program draws."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..colours import LARGEST_SHOWN_ANGLE, colour_table

PATH = "/World/legend"
TITLE = "absolute shear angle [degrees]"
_TICKS = (0.0, 15.0, 30.0, 45.0, 60.0)
_STRIPS = 60
# In half heights of the legend: half width, sides of the bar, heights of letters.
_HALF_WIDTH, _BAR_HALF_WIDTH, _BAR_LOW, _BAR_HIGH = 6.5, 5.6, -0.18, 0.22
_TITLE_SIZE, _TICK_SIZE = 0.52, 0.46
_PAPER, _INK = (0.015, 0.016, 0.02), (0.9, 0.9, 0.9)
# Between what lies on each other, towards the viewer.
_STEP = 0.01


class Drawing(NamedTuple):
    """Triangles with a colour at each corner: points (n, 3), faces (m, 3), colours (n, 3) in linear sRGB."""

    points: np.ndarray
    faces: np.ndarray
    colours: np.ndarray


@cache
def legend_drawing() -> Drawing:
    """The legend in a frame of its own: x to the right, y up, z to the viewer; it is two units high."""
    parts = [_rectangles(np.array([[-_HALF_WIDTH, -1.0, _HALF_WIDTH, 1.0]]), 0.0, np.array([_PAPER]))]
    edges = np.linspace(-_BAR_HALF_WIDTH, _BAR_HALF_WIDTH, _STRIPS + 1)
    strips = np.stack(
        [edges[:-1], np.full(_STRIPS, _BAR_LOW), edges[1:], np.full(_STRIPS, _BAR_HIGH)], axis=1
    )  # fmt: skip
    shares = (np.arange(_STRIPS) + 0.5) / _STRIPS
    parts.append(_rectangles(strips, _STEP, colour_table()[np.rint(255.0 * shares).astype(int)]))
    parts.append(_text(TITLE, 0.0, 0.42, _TITLE_SIZE))
    for tick in _TICKS:
        x = _BAR_HALF_WIDTH * (2.0 * tick / LARGEST_SHOWN_ANGLE - 1.0)
        mark = np.array([[x - 0.02, _BAR_LOW - 0.08, x + 0.02, _BAR_LOW]])
        parts += [_rectangles(mark, _STEP, np.array([_INK])), _text(f"{tick:g}", x, -0.78, _TICK_SIZE)]
    starts = np.cumsum([0, *(len(part.points) for part in parts[:-1])])
    return Drawing(
        np.concatenate([part.points for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)]),
        np.concatenate([part.colours for part in parts]),
    )


def define_legend(stage: Any) -> None:
    """The legend as the mesh /World/legend, whose place ``place_legend`` sets."""
    from pxr import Sdf, UsdGeom, Vt

    from .prims import bind, define_mesh, legend_material, set_points

    drawing = legend_drawing()
    mesh = define_mesh(stage, PATH, drawing.faces)
    set_points(mesh, drawing.points)
    colours = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "displayColor", Sdf.ValueTypeNames.Color3fArray, UsdGeom.Tokens.vertex
    )
    colours.Set(Vt.Vec3fArray.FromNumpy(drawing.colours.astype(np.float32)))
    bind(mesh, legend_material(stage))
    mesh.AddTransformOp()
    mesh.GetPrim().SetDocumentation(f"colours of the sheets: {TITLE}")


def place_legend(stage: Any, transform: Any) -> None:
    """Put the legend into a view; within the edit target of the stage, which may be a variant."""
    from pxr import UsdGeom

    UsdGeom.Xformable.Get(stage, PATH).GetTransformOp().Set(transform)


def _rectangles(sides: np.ndarray, height: float, colours: np.ndarray) -> Drawing:
    """Rectangles (k, 4): left, bottom, right, top; each in a colour, (k, 3)."""
    left, bottom, right, top = sides.T
    corners = np.stack([[left, bottom], [right, bottom], [right, top], [left, top]]).transpose(2, 0, 1).reshape(-1, 2)
    points = np.column_stack([corners, np.full(len(corners), height)])
    first = 4 * np.arange(len(sides))
    faces = np.concatenate([np.stack([first, first + a, first + a + 1], axis=1) for a in (1, 2)])
    return Drawing(points, faces, np.repeat(colours, 4, axis=0).astype(float))


def _text(text: str, x: float, y: float, size: float) -> Drawing:
    """Letters of a height, centred at ``x`` upon the line ``y``."""
    import mapbox_earcut
    from matplotlib.textpath import TextPath

    path = TextPath((0.0, 0.0), text, size=size)
    rings = [ring[:-1] for ring in map(np.asarray, path.to_polygons()) if len(ring) > 3]
    area = [_area(ring) for ring in rings]
    # letters are filled where their outline turns as that of the largest piece does; inner rings turn the other way
    outward = np.sign(area[int(np.argmax(np.abs(area)))])
    points, faces, count = [], [], 0
    for place, ring in enumerate(rings):
        if np.sign(area[place]) != outward:
            continue
        holes = [
            other for k, other in enumerate(rings) if np.sign(area[k]) != outward and _is_inside(other[0], ring)
        ]  # fmt: skip
        vertices = np.concatenate([ring, *holes])
        ends = np.cumsum([len(ring), *map(len, holes)]).astype(np.uint32)
        faces.append(mapbox_earcut.triangulate_float64(vertices, ends).reshape(-1, 3).astype(int) + count)
        points.append(vertices)
        count += len(vertices)
    flat = np.concatenate(points)
    flat = flat + (x - 0.5 * (flat[:, 0].min() + flat[:, 0].max()), y)
    return Drawing(
        np.column_stack([flat, np.full(len(flat), _STEP)]), np.concatenate(faces), np.tile(_INK, (len(flat), 1))
    )  # fmt: skip


def _area(ring: np.ndarray) -> float:
    """Signed, of a polygon."""
    x, y = ring.T
    return 0.5 * float(x @ np.roll(y, -1) - np.roll(x, -1) @ y)


def _is_inside(point: np.ndarray, ring: np.ndarray) -> bool:
    from matplotlib.path import Path

    return bool(Path(ring).contains_point((float(point[0]), float(point[1]))))
