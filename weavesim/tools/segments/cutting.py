"""Sectors of a surface: what lies between two half planes that begin at an axis along z."""

from __future__ import annotations

import math

import numpy as np

from ..drawing import Triangles


def sector_normals(begin: float, end: float) -> np.ndarray:
    """Outward unit normals in plan (2, 2) of the sector from ``begin`` counter-clockwise to ``end`` [rad].

    The sector, of at most half a turn, is where no normal times the point is positive.
    """
    return np.array([[math.sin(begin), -math.cos(begin)], [-math.sin(end), math.cos(end)]])


def sector_of(triangles: Triangles, centre: tuple[float, float], begin: float, end: float) -> Triangles:
    """The part of triangles in a sector, cut along its sides; what is left may be nothing.

    Args:
        triangles: vertices (n, 3) [m] and faces (m, 3).
        centre: of the sector in plan [m].
        begin, end: angles from x, counter-clockwise, at most half a turn apart [rad].
    """
    vertices, faces = triangles
    for normal in sector_normals(begin, end):
        height = (vertices[:, :2] - np.array(centre)) @ normal
        vertices, faces = _below(vertices, faces, height)
    used, index = np.unique(faces, return_inverse=True)
    return vertices[used], index.reshape(-1, 3)


def _below(vertices: np.ndarray, faces: np.ndarray, height: np.ndarray) -> Triangles:
    """The part of triangles where ``height`` at their vertices (n,), and between them, is not positive."""
    # a vertex on the side belongs to both sectors, within rounding
    above = height > 1.0e-12
    count = above[faces].sum(axis=1)
    kept = [faces[count == 0]]
    points, number = [vertices], len(vertices)
    between: dict[tuple[int, int], int] = {}

    def crossing(a: int, b: int) -> int:
        nonlocal number
        key = (min(a, b), max(a, b))
        if key not in between:
            share = height[key[0]] / (height[key[0]] - height[key[1]])
            points.append((vertices[key[0]] + share * (vertices[key[1]] - vertices[key[0]]))[None])
            between[key], number = number, number + 1
        return between[key]

    found = []
    for face in faces[(count == 1) | (count == 2)]:
        alone = above[face].sum() == 1
        turned = np.roll(face, -int(np.argmax(above[face] == alone)))
        a, b, c = turned.tolist()  # a is alone on its side
        ab, ac = crossing(a, b), crossing(a, c)
        found += [[a, ab, ac]] if not above[a] else [[ab, b, c], [ab, c, ac]]
    kept.append(np.array(found, dtype=faces.dtype).reshape(-1, 3))
    return np.concatenate(points), np.concatenate(kept)
