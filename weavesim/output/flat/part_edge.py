"""The edge of a part: closed curves in space or in plan, from files, or the opening of a tool."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...errors import InputError
from ...input_files import path_of, shown
from ...meshes.drawing import JOINED, joined, read_lines
from ...meshes.reading import read_mesh
from ...process.motions.paths import Place
from ...tables.table import Wanted, read_table
from ...tools.surfaces.rim import facing_up, rim_faces
from ...tools.tool import Tool

# Vertices of a mesh nearer than this over its size are one: an STL has three for each triangle.
WELDED = 1.0e-6
TABLES = (".csv", ".txt", ".tsv", ".dat")
_COLUMNS = "x", "y", "z"


class PartEdge(NamedTuple):
    """What bounds a part.

    Attributes:
        name: where it comes from, for messages.
        outline: points of the closed curve, (k, 3) [m]; (k, 2) for one that is seen from above.
        holes: points of further closed curves, inside the first.
        notes: what was left out.
    """

    name: str
    outline: np.ndarray
    holes: tuple[np.ndarray, ...] = ()
    notes: tuple[str, ...] = ()


def read_part_edge(path: str | Path, *, metres_per_unit: float | None = None, layer: str | None = None) -> PartEdge:
    """The edge of a part from a file, in the place of the tools.

    A DXF drawing has closed lines: the longest is the outline, others are holes. One that is flat at z = 0 is seen from
    above. A table has the columns x, y and, unless the curve is seen from above, z, point by point. Of a mesh of an
    open surface the border is taken.

    Args:
        path: of the file.
        metres_per_unit: of it; None takes what it says itself.
        layer: of a drawing; None takes all.

    Raises:
        InputError: a file that cannot be read, has no unit, or no closed curve.
    """
    path = path_of(path, "edge of the part")
    suffix = path.suffix.lower()
    if layer is not None and suffix != ".dxf":
        raise InputError(f"layer = {layer!r}: only a DXF drawing has layers, the edge of the part is {shown(path)}")
    if suffix == ".dxf":
        return _of_drawing(path, metres_per_unit, layer)
    if suffix in TABLES:
        return _of_table(path, metres_per_unit)
    return _of_mesh(path, metres_per_unit)


def _of_drawing(path: Path, unit: float | None, layer: str | None) -> PartEdge:
    drawing = read_lines(path, layer=layer, metres_per_unit=unit)
    if not drawing.lines:
        raise InputError(f"{drawing.name}: it has no lines; a closed curve is needed")
    size = float(np.ptp(np.concatenate(drawing.lines), axis=0).max())
    lines = list(joined(drawing.lines, JOINED * size))
    closed = [line[:-1] for line in lines if len(line) > 3 and np.linalg.norm(line[0] - line[-1]) <= JOINED * size]
    if not closed:
        gap = min(lines, key=lambda line: float(np.linalg.norm(line[0] - line[-1])))
        raise InputError(
            f"{drawing.name}: no line is closed; the nearest ends are {1e3 * np.linalg.norm(gap[0] - gap[-1]):.4g} mm "
            f"apart, at {told(gap[-1])}"
        )
    notes = list(drawing.notes)
    if len(closed) < len(lines):
        notes.append(f"{path.name}: {len(lines) - len(closed)} open lines left out")
    if not any(np.any(line[:, 2]) for line in closed):
        closed = [line[:, :2] for line in closed]
    return _largest_first(drawing.name, closed, notes)


def _of_table(path: Path, unit: float | None) -> PartEdge:
    table = read_table(path, "edge of the part")
    # two columns: seen from above
    names = _COLUMNS if table.has("z") else _COLUMNS[:2]
    wanted = (Wanted(name, "m", scale=unit, needs_unit=unit is None) for name in names)
    columns = table.columns(*wanted)
    points = np.column_stack(columns.values)
    if len(points) > 1 and np.allclose(
        points[0], points[-1], rtol=0.0, atol=JOINED * float(np.ptp(points, axis=0).max())
    ):
        points = points[:-1]
    if len(points) < 3:
        raise InputError(
            f"edge of the part {shown(path)}: it has {len(points)} points; a closed curve has three or more"
        )
    return PartEdge(f"edge of the part {shown(path)}", points, notes=columns.notes)


def _of_mesh(path: Path, unit: float | None) -> PartEdge:
    mesh = read_mesh(path, "edge of the part")
    faces, _ = mesh.triangles()
    scale = mesh.metres_per_unit if unit is None else unit
    if scale is None:
        raise InputError(f"unit: is required with {path.name}, whose format does not say it: mm, inch, ...")
    mesh.check_unit(scale)
    loops = border_loops(scale * mesh.vertices, faces)
    if not loops:
        raise InputError(
            f"{mesh.name}: its surface is closed, so that it has no border; give the trimmed surface of the part, open"
        )
    return _largest_first(mesh.name, loops, [])


def opening_of(tool: Tool, place: Place) -> PartEdge:
    """The opening of a tool: the inner border of its flat rim, where the tool stands.

    Raises:
        InputError: a tool that is no mesh, has no flat rim, or several openings.
    """
    name = f"opening of {tool.name}"
    shape = tool.shape
    if shape.surface is None:
        raise InputError(f"{name}: only a tool from a mesh has one; give the edge of the part as a file")
    drawn = shape.display_mesh()
    vertices, faces = np.asarray(drawn.vertices), np.asarray(drawn.faces)
    for flip in (np.array([1.0, 1.0, 1.0]), np.array([1.0, -1.0, -1.0])):
        part = facing_up(vertices * flip, faces)
        rim = rim_faces(part.vertices, part.faces) if len(part.faces) else np.zeros(0, dtype=bool)
        if not np.any(rim):
            continue
        loops = border_loops(tool.moved(part.vertices * flip, place), part.faces[rim])
        loops.sort(key=lambda loop: -abs(plan_area(loop)))
        if len(loops) < 2:
            continue
        if len(loops) > 2:
            raise InputError(f"{name}: its rim has {len(loops) - 1} openings; give the edge of the part as a file")
        return PartEdge(name, loops[1])
    raise InputError(f"{name}: it has no flat rim around an opening; give the edge of the part as a file")


def border_loops(vertices: np.ndarray, faces: np.ndarray) -> list[np.ndarray]:
    """Closed borders of a surface of triangles, each in order, (k, 3) [m]."""
    from scipy.spatial import cKDTree

    size = float(np.ptp(vertices, axis=0).max())
    same = cKDTree(vertices).query_pairs(WELDED * size, output_type="ndarray")
    first = np.arange(len(vertices))
    for a, b in same[np.argsort(same[:, 0], kind="stable")]:
        first[b] = min(first[b], first[a])
    faces = first[faces]
    edges = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    edges = edges[edges[:, 0] != edges[:, 1]]
    _, index, count = np.unique(np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True)
    pieces = [vertices[edge] for edge in edges[index[count == 1]]]
    lines = joined(pieces, 0.5 * WELDED * size) if pieces else iter(())
    return [line[:-1] for line in lines if len(line) > 3 and np.allclose(line[0], line[-1], rtol=0, atol=WELDED * size)]


def _largest_first(name: str, loops: list[np.ndarray], notes: list[str]) -> PartEdge:
    loops = sorted(loops, key=lambda loop: -float(np.linalg.norm(np.ptp(loop, axis=0))))
    return PartEdge(name, loops[0], tuple(loops[1:]), tuple(notes))


def plan_area(loop: np.ndarray) -> float:
    """Area inside a closed line, seen from above, positive counter-clockwise [m^2]."""
    x, y = loop[:, 0], loop[:, 1]
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def told(point: np.ndarray) -> str:
    """A point for readers, in millimetres."""
    return f"({', '.join(f'{1e3 * value:.4g}' for value in point)}) mm"
