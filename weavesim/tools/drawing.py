"""Triangles for drawing tools."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

Triangles = tuple[np.ndarray, np.ndarray]

# Facets of a drawn full circle; divisible by four, so that the quarter points are vertices.
CIRCLE_COUNT = 96
# Cells along the longest side of a tool into which vertices are gathered for a coarser one, first, and how many of them
# are left each time that this leaves too many triangles.
_FINEST, _LEFT = 400, 0.8


def stadium_rings(out: Sequence[float] | np.ndarray, z: Sequence[float] | np.ndarray, half_length: float) -> np.ndarray:
    """Stadium-shaped rings at distance ``out`` from the segment along x and height ``z``; (rings, points, 3)."""
    right = np.linspace(-0.5, 0.5, CIRCLE_COUNT // 2 + 1) * np.pi
    left = (right if half_length > 0.0 else right[1:-1]) + np.pi
    angle = np.concatenate([right, left])
    shift = np.concatenate([np.full(len(right), half_length), np.full(len(left), -half_length)])
    plan = np.array(out)[:, None, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    plan[:, :, 0] += shift
    return np.concatenate([plan, np.broadcast_to(np.array(z)[:, None, None], (*plan.shape[:2], 1))], axis=2)


def ring_triangles(rings: np.ndarray, capped: bool = False) -> Triangles:
    """Triangles between neighbouring closed rings; outward for rings that run upwards around a solid."""
    ring_count, point_count = rings.shape[:2]
    index = np.arange(ring_count * point_count).reshape(ring_count, point_count)
    a, b = index[:-1], np.roll(index[:-1], -1, axis=1)
    c, d = np.roll(index[1:], -1, axis=1), index[1:]
    faces = np.concatenate([np.stack([a, b, c], axis=-1).reshape(-1, 3), np.stack([a, c, d], axis=-1).reshape(-1, 3)])
    vertices = rings.reshape(-1, 3)
    if capped:  # separate vertices, so that shading stays sharp at the rim
        first = len(vertices)
        fan = np.arange(1, point_count - 1)
        cap = np.column_stack([np.full(len(fan), first), first + fan, first + fan + 1])
        vertices, faces = np.concatenate([vertices, rings[-1]]), np.concatenate([faces, cap])
    # poles and the ends of a ridge are rings of coincident points: drop their empty triangles
    p, q, r = (vertices[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(q - p, r - p), axis=1)
    return vertices, faces[area > 1e-9 * area.max()]


def swept(out: np.ndarray, z: np.ndarray, half_length: float, capped: bool = False) -> Triangles:
    """A profile, ``out`` and ``z`` [m], swept around a segment along x; with a ``half_length`` of zero, around z."""
    return ring_triangles(stadium_rings(out, z, half_length), capped)


def coarser(triangles: Triangles, most: int) -> Triangles:
    """Triangles to draw: at most ``most``, if they are more, by gathering their vertices in the cells of a grid."""
    vertices, faces = np.asarray(triangles[0], dtype=float), np.asarray(triangles[1])
    size, cells = float(np.ptp(vertices, axis=0).max()), float(_FINEST)
    left = vertices, faces
    while len(left[1]) > most and cells > 1.0:
        left = gathered(vertices, faces, size / cells)
        cells *= _LEFT
    return left


def gathered(vertices: np.ndarray, faces: np.ndarray, size: float) -> Triangles:
    """Vertices of each cell of a grid as one, at their mean, and the triangles that are left.

    Args:
        vertices: (n, 3) [m].
        faces: (m, 3).
        size: of the cells [m].
    """
    cell = np.floor((vertices - vertices.min(axis=0)) / size).astype(int)
    _, own, count = np.unique(cell, axis=0, return_inverse=True, return_counts=True)
    own = own.ravel()
    means = np.stack([np.bincount(own, vertices[:, axis]) for axis in range(3)], axis=1) / count[:, None]
    corners = own[faces]
    a, b, c = corners.T
    left = corners[(a != b) & (b != c) & (c != a)]
    # of several with the same corners one is enough
    _, first = np.unique(np.sort(left, axis=1), axis=0, return_index=True)
    return means, left[np.sort(first)]
