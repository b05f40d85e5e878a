"""Nearest points of a surface in space."""

from __future__ import annotations

import numpy as np

_FIRST_CANDIDATES = 8
# Pairs of point and triangle that are looked at in one go.
_MOST_PAIRS = 2_000_000


def nearest(triangles: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The nearest point of a surface for each of ``points`` (k, 3), and the triangle it lies in, (k, 3) and (k,).

    Exact: triangles are looked at in the order of their centres' distances until none that is left can be nearer.

    Args:
        triangles: corners, (n, 3, 3) [m].
        points: (k, 3) [m].
    """
    from scipy.spatial import cKDTree
    from trimesh.triangles import closest_point

    centre = triangles.mean(axis=1)
    radius = float(np.linalg.norm(triangles - centre[:, None], axis=2).max())
    tree = cKDTree(centre)
    best, found = np.empty_like(points), np.zeros(len(points), dtype=int)
    open_points, count = np.arange(len(points)), min(_FIRST_CANDIDATES, len(triangles))
    while len(open_points):
        left = []
        for chunk in np.array_split(open_points, max(1, -(-len(open_points) * count // _MOST_PAIRS))):
            reach, candidates = tree.query(points[chunk], k=count)
            reach, candidates = reach.reshape(len(chunk), count), candidates.reshape(len(chunk), count)
            repeated = np.repeat(points[chunk], count, axis=0)
            near = closest_point(triangles[candidates.ravel()], repeated)
            distance = np.linalg.norm(near - repeated, axis=1).reshape(len(chunk), count)
            which = distance.argmin(axis=1)
            rows = np.arange(len(chunk))
            best[chunk], found[chunk] = near.reshape(len(chunk), count, 3)[rows, which], candidates[rows, which]
            if count < len(triangles):
                left.append(chunk[distance[rows, which] > reach[:, -1] - radius])
        open_points = np.concatenate(left) if left else np.empty(0, dtype=int)
        count = min(4 * count, len(triangles))
    return best, found
