"""A surface at a distance from a triangle mesh: each corner moves so that the planes around it keep their distance.

Planes, sharp edges and corners keep their form, so that a fillet of radius r becomes one of r + d or r - d. Where the
surface is hollow with a radius below the distance, the offset would cross itself: that is refused.
"""

from __future__ import annotations

import numpy as np

from ...errors import InputError
from ..mesh_features import face_normals
from ..mesh_topology import place

# Directions in which the planes around a corner differ by less than this share of the largest are one.
SAME_PLANE = 1.0e-3
# A corner moves no further than this many distances, however sharp it is.
LONGEST_MOVE = 3.0
# An offset surface may come nearer than the distance by this share, from its facets and from how it is measured.
NEARER = 0.15
# Faces of less altitude than this share of the distance may turn over.
NEEDLE = 0.1
# Points on the surface that its distance is measured from.
SAMPLE_COUNT = 400_000


def offset_surface(name: str, vertices: np.ndarray, faces: np.ndarray, distance: float) -> np.ndarray:
    """Vertices (n, 3) [m] of the surface at ``distance`` [m] from the given one, on the side of its normals.

    Args:
        name: of the surface, for messages.
        vertices: (n, 3) [m].
        faces: (m, 3), oriented consistently.
        distance: negative for the other side.

    Raises:
        InputError: the surface is hollow with a radius below the distance.
    """
    if distance == 0.0:
        return vertices.copy()
    normal, _ = face_normals(vertices, faces)
    moved = vertices + distance * _moves(vertices, faces, normal)
    turned = np.einsum("ij,ij->i", face_normals(moved, faces)[0], normal)
    # of a needle the two ends of its short side may change places
    turned[_altitude(vertices, faces) < NEEDLE * abs(distance)] = 1.0
    _check(name, vertices, faces, moved, turned, abs(distance))
    return moved


def _altitude(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Smallest altitude of each face, (m,) [m]."""
    corner = vertices[faces]
    longest = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max(axis=1)
    return 2.0 * face_normals(vertices, faces)[1] / np.maximum(longest, 1e-300)


def _moves(vertices: np.ndarray, faces: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Where each vertex goes for a distance of one, (n, 3): by least squares, all planes around it move by one."""
    matrix, right = np.zeros((len(vertices), 3, 3)), np.zeros((len(vertices), 3))
    for k in range(3):
        corner = vertices[faces[:, k]]
        u, v = vertices[faces[:, (k + 1) % 3]] - corner, vertices[faces[:, (k + 2) % 3]] - corner
        angle = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.einsum("ij,ij->i", u, v))
        np.add.at(matrix, faces[:, k], angle[:, None, None] * normal[:, :, None] * normal[:, None, :])
        np.add.at(right, faces[:, k], angle[:, None] * normal)
    value, vector = np.linalg.eigh(matrix)
    largest = np.maximum(value[:, -1:], 1e-300)
    inverse = np.where(value > SAME_PLANE * largest, 1.0 / np.maximum(value, 1e-300), 0.0)
    move = np.einsum("nij,nj,nkj,nk->ni", vector, inverse, vector, right)
    length = np.linalg.norm(move, axis=1)
    return move * np.minimum(1.0, LONGEST_MOVE / np.maximum(length, 1e-300))[:, None]


def _check(
    name: str, vertices: np.ndarray, faces: np.ndarray, moved: np.ndarray, turned: np.ndarray, distance: float
) -> None:
    from scipy.spatial import cKDTree

    used = np.unique(faces)
    points, spacing = _spread(vertices, faces)
    found = cKDTree(points).query(moved[used])[0]
    # the nearest sample is off the nearest point by up to its spacing, along the surface
    nearest = np.sqrt(np.maximum(found**2 - (0.71 * spacing) ** 2, 0.0))
    near = found < (1.0 - NEARER) * distance
    if np.any(turned <= 0.0) or np.any(near):
        worst = moved[used][np.argmin(nearest)] if np.any(near) else moved[faces[np.argmin(turned)]].mean(axis=0)
        raise InputError(
            f"{name}: its offset by {1e3 * distance:.4g} mm crosses itself at {place(worst)}: the surface is hollow "
            "there with a radius, or a width, below the offset. Give both tools as files, or a smaller gap, or round it"
        )


def _spread(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, float]:
    """Points evenly over the surface, vertices among them, and their mean distance [m]."""
    area = face_normals(vertices, faces)[1]
    total = float(area.sum())
    random = np.random.default_rng(0)
    face = faces[random.choice(len(area), size=SAMPLE_COUNT, p=area / total)]
    weight = random.dirichlet([1.0, 1.0, 1.0], size=SAMPLE_COUNT)
    points = np.einsum("ij,ijk->ik", weight, vertices[face])
    return np.concatenate([points, vertices[np.unique(faces)]]), (total / SAMPLE_COUNT) ** 0.5
