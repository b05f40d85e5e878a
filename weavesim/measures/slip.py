"""How far sheets that lie on each other have slipped."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..sheet.topology import doubled_normals

if TYPE_CHECKING:
    from ..sheet.blank import Blank

# Elements whose centres are nearest to a point, among which that with the point is looked for.
CANDIDATE_COUNT = 16
# A point may be this far outside a triangle, over its size.
SLACK = 1.0e-6


def slip(lower: Blank, lower_position: np.ndarray, upper: Blank, upper_position: np.ndarray) -> np.ndarray:
    """Slip of the upper sheet on the lower one, (node_count of the lower one, 3) [m].

    Two points that lay on each other on the flat blanks are apart by the slip and a distance across the sheet: the
    slip is what is along the lower sheet. NaN at nodes that no point of the upper blank lay on.

    Args:
        lower, upper: the flat sheets.
        lower_position, upper_position: their formed nodes, (node_count, 3) each [m].
    """
    apart = interpolated(upper, lower.material_coordinates, upper_position) - lower_position
    normal = np.zeros_like(lower_position)
    for axis, values in enumerate(np.repeat(doubled_normals(lower_position, lower.quads), 4, axis=0).T):
        normal[:, axis] = np.bincount(lower.quads.ravel(), values, lower.node_count)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1.0e-300)[:, None]
    return np.asarray(apart - np.einsum("ni,ni->n", apart, normal)[:, None] * normal)


def interpolated(blank: Blank, points: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Nodal ``values`` (node_count, m) at flat ``points`` (k, 2), linear on two triangles an element; NaN outside."""
    from scipy.spatial import cKDTree

    flat = blank.material_coordinates
    _, nearest = cKDTree(flat[blank.quads].mean(axis=1)).query(points, min(CANDIDATE_COUNT, blank.element_count))
    nearest = np.asarray(nearest).reshape(len(points), -1)
    best, nodes = np.full(len(points), -np.inf), np.zeros((len(points), 3), dtype=np.int64)
    weights = np.zeros((len(points), 3))
    for candidate in nearest.T:
        for corners in ((0, 1, 2), (0, 2, 3)):
            triangle = blank.quads[candidate][:, corners]
            share = _barycentric(flat[triangle], points)
            better = share.min(axis=1) > best
            best = np.where(better, share.min(axis=1), best)
            nodes[better], weights[better] = triangle[better], share[better]
    result = np.einsum("kc,kcm->km", weights, np.asarray(values)[nodes])
    result[best < -SLACK] = np.nan
    return result


def _barycentric(triangle: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Weights of the corners of flat triangles (k, 3, 2) at points (k, 2), (k, 3)."""
    a, b, c = (triangle[:, corner] for corner in range(3))

    def area(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
        u, v = q - p, r - p
        return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])

    whole = area(a, b, c)
    return np.column_stack([area(points, b, c), area(points, c, a), area(points, a, b)]) / whole[:, None]
