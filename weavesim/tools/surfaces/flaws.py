"""What a user should look at in the mesh of a tool: holes, turned triangles, radii that elements do not follow."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..mesh_features import convex_radii, face_normals
from ..mesh_repair import diagonal
from ..mesh_tool import MeshSurface
from ..mesh_topology import directed_edges, labels
from ..shapes import Shape

# A hole that is wider than this share of its surface is an opening that is meant.
OPENING = 0.25


class Hole(NamedTuple):
    """A closed border inside a sheet.

    Attributes:
        edges: of the border, places of both ends, (k, 2, 3) [m].
        place: its middle, (3,) [m].
        width: diagonal of the box around it [m].
        is_opening: whether it is so large that it is probably meant.
    """

    edges: np.ndarray
    place: np.ndarray
    width: float
    is_opening: bool


def holes_of(surface: MeshSurface) -> list[Hole]:
    """The holes of an open sheet, the smallest first: of each connected patch all borders but the longest one."""
    if surface.closed or not len(surface.border):
        return []
    sheet = surface.parts[-1]
    patch = labels(len(surface.vertices), directed_edges(sheet))
    loop = labels(len(surface.vertices), surface.border)[surface.border[:, 0]]
    found: dict[int, list[np.ndarray]] = {}
    for number in np.unique(loop):
        edges = surface.border[loop == number]
        found.setdefault(int(patch[edges[0, 0]]), []).append(surface.vertices[edges])
    size, holes = diagonal(surface.vertices[sheet]), []
    for loops in found.values():
        widths = [diagonal(edges) for edges in loops]
        for k in np.argsort(widths, kind="stable")[:-1].tolist():
            middle = 0.5 * (loops[k].min(axis=(0, 1)) + loops[k].max(axis=(0, 1)))
            holes.append(Hole(loops[k], middle, widths[k], widths[k] > OPENING * size))
    return sorted(holes, key=lambda hole: hole.width)


def forgotten_holes(shape: Shape) -> list[Hole]:
    """Holes in a mesh of a file that are no openings, the smallest first; what is made from another tool has none."""
    mesh = getattr(shape, "mesh", None)
    if mesh is None or mesh.path is None:
        return []
    return [hole for hole in holes_of(mesh.surface) if not hole.is_opening]


class SharpPart(NamedTuple):
    """Where the convex radii of a surface are below some radius.

    Attributes:
        share: of the area.
        place: the sharpest of it, (3,) [m].
    """

    share: float
    place: np.ndarray


def sharper_than(surface: MeshSurface, radius: float) -> SharpPart | None:
    """Where convex radii are below ``radius`` [m]; None if nowhere."""
    found = convex_radii(surface.vertices, surface.faces)
    below = found < radius
    if not np.any(below):
        return None
    area = face_normals(surface.vertices, surface.faces)[1]
    return SharpPart(
        float(area[below].sum() / area.sum()), surface.vertices[surface.faces[int(np.argmin(found))]].mean(axis=0)
    )
