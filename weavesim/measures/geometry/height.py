"""How high points lie over a sheet."""

from __future__ import annotations

import numpy as np

# Triangles whose centres are nearest to a point, among which its nearest point is looked for.
CANDIDATE_COUNT = 24
# A nearest point in another direction than about that of the normal is on the border: the point lies beside the sheet.
LEAST_COSINE = 0.7
# Share of the sheet's size below which a distance is rounding, and has no direction.
ROUNDING = 1.0e-12


def heights_over(points: np.ndarray, position: np.ndarray, quads: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Distance of points from a sheet, positive on the side of its directors; NaN beside the sheet, (k,) [m].

    Args:
        points: (k, 3) [m].
        position: nodes of the sheet, (node_count, 3) [m].
        quads: its elements, (element_count, 4); each is taken as two triangles.
        up: its directors, (node_count, 3).
    """
    from scipy.spatial import cKDTree
    from trimesh.triangles import closest_point

    corners = quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)
    triangles = position[corners]
    count = min(CANDIDATE_COUNT, len(triangles))
    _, near = cKDTree(triangles.mean(axis=1)).query(points, count)
    near = np.asarray(near).reshape(len(points), count)
    every = np.repeat(points, count, axis=0)
    foot = closest_point(triangles[near.ravel()], every).reshape(len(points), count, 3)
    apart = points[:, None] - foot
    distance = np.linalg.norm(apart, axis=2)
    best = distance.argmin(axis=1)
    row = np.arange(len(points))
    distance, apart, triangle = distance[row, best], apart[row, best], near[row, best]
    a, b, c = (triangles[triangle][:, corner] for corner in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1.0e-300)[:, None]
    normal *= np.sign(np.einsum("ki,ki->k", normal, up[corners[triangle]].sum(axis=1)))[:, None]
    height = np.einsum("ki,ki->k", apart, normal)
    rounding = ROUNDING * np.ptp(position, axis=0).max()
    beside = (np.abs(height) < LEAST_COSINE * distance) & (distance > rounding)
    return np.where(beside, np.nan, height)
