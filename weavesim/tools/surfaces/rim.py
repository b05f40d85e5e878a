"""The side of a tool that faces the sheet, and the flat rim around its opening."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...errors import InputError
from ..mesh_features import face_normals
from ..mesh_repair import diagonal, without_unused
from ..mesh_topology import labels, neighbours

# A face is level within this angle, and walls are steeper than this [sine of the angle to the vertical].
LEVEL = 1.0 - 1.0e-5
WALL = 0.02
# Faces at one height, over the size of the surface.
SAME_HEIGHT = 2.0e-4
# Pixels of the plan, along its longer side.
PLAN_PIXELS = 800
# What lies above a face by more than this share of the size covers it.
COVERED = 2.0e-3


class Facing(NamedTuple):
    """Triangles that face up (vertices (n, 3) [m], faces (m, 3))."""

    vertices: np.ndarray
    faces: np.ndarray


def facing_up(vertices: np.ndarray, faces: np.ndarray) -> Facing:
    """The part of a surface that a sheet above it can meet: without its underside, outer walls and what is covered."""
    normal, _ = face_normals(vertices, faces)
    up, wall = normal[:, 2] > WALL, np.abs(normal[:, 2]) <= WALL
    keep = up.copy()
    if np.any(up):
        if np.any(wall):
            keep |= wall & _over_the_plan(vertices, faces, up, normal)
        keep[keep] = ~_covered(vertices, faces[up], faces[keep])
    vertices, (faces,) = without_unused(vertices, [faces[keep]])
    return Facing(vertices, faces)


def _covered(vertices: np.ndarray, faces: np.ndarray, asked: np.ndarray) -> np.ndarray:
    """Whether ``faces`` that face up lie above each face of ``asked``, (k,) bool.

    They are painted in plan, the highest last, and looked at around the middle of each.
    """
    from PIL import Image, ImageDraw

    corner = vertices[faces]
    low, size = vertices[faces][:, :, :2].min(axis=(0, 1)), np.ptp(corner[:, :, :2], axis=(0, 1))
    pixel = float(size.max()) / PLAN_PIXELS
    columns, rows = (int(length / pixel) + 5 for length in size)
    picture = Image.new("I", (columns, rows), 0)
    draw = ImageDraw.Draw(picture)
    places = (corner[:, :, :2] - low) / pixel + 2.0
    for index in np.argsort(corner[:, :, 2].max(axis=1), kind="stable"):
        draw.polygon(places[index].ravel().tolist(), fill=int(index) + 1, outline=int(index) + 1)
    above = np.array(picture)
    middle, bottom = vertices[asked].mean(axis=1), np.append(np.inf, corner[:, :, 2].min(axis=1))
    column, row = np.rint((middle[:, :2] - low) / pixel + 2.0).astype(int).T
    around = [(i, j) for i in (-2, 0, 2) for j in (-2, 0, 2)]
    row, column = np.clip(row, 2, rows - 3), np.clip(column, 2, columns - 3)
    # a wall has its own foot, or what lies in front of it, at one of these
    lowest = np.min([bottom[above[row + i, column + j]] for i, j in around], axis=0)
    return lowest > middle[:, 2] + COVERED * float(np.linalg.norm(np.ptp(corner, axis=(0, 1))))


def _over_the_plan(vertices: np.ndarray, faces: np.ndarray, up: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Whether the ground in front of each face is in the plan of the faces ``up``, (m,) bool: outer walls are not."""
    from PIL import Image, ImageDraw

    plan = vertices[:, :2]
    low, size = plan.min(axis=0), np.ptp(plan, axis=0)
    pixel = float(size.max()) / PLAN_PIXELS
    columns, rows = (int(length / pixel) + 5 for length in size)
    picture = Image.new("1", (columns, rows))
    draw = ImageDraw.Draw(picture)
    for triangle in ((plan[faces[up]] - low) / pixel + 2.0).reshape(-1, 6).tolist():
        draw.polygon(triangle, fill=1, outline=1)
    filled = np.array(picture)
    ahead = (vertices[faces].mean(axis=1)[:, :2] - low) / pixel + 2.0 + 2.0 * normal[:, :2]
    column, row = (np.clip(np.rint(ahead[:, k]).astype(int), 0, count - 1) for k, count in enumerate((columns, rows)))
    return filled[row, column]


def rim_faces(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Which faces are the flat rim of a surface that faces up, (m,) bool: level, at one height, out to its border.

    All False without one.
    """
    normal, area = face_normals(vertices, faces)
    level = normal[:, 2] > LEVEL
    if not np.any(level):
        return level
    size = diagonal(vertices)
    pairs = neighbours(faces) // 3
    height = vertices[faces].mean(axis=1)[:, 2]
    joined = level[pairs].all(axis=1) & (np.abs(np.diff(height[pairs], axis=1)[:, 0]) < SAME_HEIGHT * size)
    part = labels(len(faces), pairs[joined])
    low, high = vertices[:, :2].min(axis=0), vertices[:, :2].max(axis=0)
    reach = vertices[faces][:, :, :2]
    near = 0.01 * size
    at_border = ((reach - low < near) | (high - reach < near)).any(axis=(1, 2)) & level
    best, largest = np.zeros(len(faces), dtype=bool), 0.0
    for index in np.unique(part[at_border]):
        found = (part == index) & level
        # parts that a mesh cuts apart, at the same height
        same = level & (np.abs(height - np.average(height[found], weights=area[found])) < SAME_HEIGHT * size)
        total = float(area[same & at_border].sum())
        if total > largest:
            best, largest = same, total
    return best


def ring_over_rim(name: str, vertices: np.ndarray, faces: np.ndarray, height: float) -> Facing:
    """A ring that faces down, over the flat rim of a surface that faces up, ``height`` [m] above it.

    Raises:
        InputError: the surface has no flat rim.
    """
    rim = rim_faces(vertices, faces)
    if not np.any(rim):
        raise InputError(
            f"{name}: it has no flat rim around an opening that a ring could cover: give the ring as a file"
        )
    vertices, (found,) = without_unused(vertices, [faces[rim]])
    vertices = vertices + (0.0, 0.0, height)
    vertices[:, 2] = np.mean(vertices[:, 2])
    return Facing(vertices, found[:, ::-1])
