"""Feet of points on the facets of a sheet, found on the host: for the start of a run, and for checks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...kernels.plies.search import NEAR

# Facets around each point that are tried, by their middles.
CANDIDATE_COUNT = 9
ITERATIONS = 12
# Corners of the edges along each coordinate, where the other one is -1 and 1.
EDGES_ALONG_XI, EDGES_ALONG_ETA = ((0, 1), (3, 2)), ((0, 3), (1, 2))


@dataclass(frozen=True)
class Feet:
    """Where points stand on facets.

    Attributes:
        facet: (n,) int32.
        xi, eta: coordinates on it, (n,); beyond +-1 for points that stand beside the sheet.
        height: along the unit normal interpolated from the directors, less the sagitta of the facet, (n,) [m].
        way: how far each may move before it is over a facet, or near above or below it, (n,) [m]; negative if it is.
    """

    facet: np.ndarray
    xi: np.ndarray
    eta: np.ndarray
    height: np.ndarray
    way: np.ndarray


def find_feet(
    points: np.ndarray, position: np.ndarray, director: np.ndarray, quads: np.ndarray, thickness: float
) -> Feet:
    """Feet of ``points`` (n, 3) [m] on the facets of a sheet.

    Args:
        points: whose feet are sought.
        position, director: of the sheet's nodes, (node_count, 3) [m] and unit vectors.
        quads: its elements, (element_count, 4).
        thickness: at which the points touch the sheet [m].
    """
    from scipy.spatial import KDTree

    corners = position[quads]
    middle = corners.mean(axis=1)
    radius = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    distance, near = KDTree(middle).query(points, k=min(CANDIDATE_COUNT, len(quads)))
    distance, near = distance.reshape(len(points), -1), near.reshape(len(points), -1)
    best = np.full(len(points), np.inf)
    facet = near[:, 0].astype(np.int32)
    found = np.zeros((3, len(points)))
    found[0] = 2.0  # beside the sheet, where no facet has a foot
    for k in range(near.shape[1]):
        solved = _solve(points, corners[near[:, k]], director[quads[near[:, k]]])
        outside = np.where(solved[3] < 1.0e-6, np.maximum(np.abs(solved[0]), np.abs(solved[1])), np.inf)
        # on an edge, the facet whose middle is nearer stays
        better = outside < best - 1.0e-9
        best[better], facet[better] = outside[better], near[better, k]
        found[:, better] = solved[:3, better]
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    height = np.abs(np.einsum("nki,nki->nk", points[:, None] - middle[near], normal[near]))
    beside = np.sqrt(np.maximum(distance**2 - height**2, 0.0))
    way = np.maximum(beside - float(NEAR) * radius[near], height - radius[near] - thickness).min(axis=1)
    return Feet(facet, found[0], found[1], found[2], way)


def _solve(points: np.ndarray, corner: np.ndarray, director: np.ndarray) -> np.ndarray:
    """xi, eta, height and error over the size of the facet, for one facet each, (4, n), by Newton's method."""
    xi, eta, g = (np.zeros(len(points)) for _ in range(3))
    g = np.einsum("ni,ni->n", points - corner.mean(axis=1), director.mean(axis=1))
    for _ in range(ITERATIONS):
        weight, by_xi, by_eta = weights(xi, eta)
        n, n1, n2, _ = _normals(xi, eta, corner, director)
        rest = np.einsum("nc,nci->ni", weight, corner) + g[:, None] * n - points
        column1 = np.einsum("nc,nci->ni", by_xi, corner) + g[:, None] * n1
        column2 = np.einsum("nc,nci->ni", by_eta, corner) + g[:, None] * n2
        matrix = np.stack([column1, column2, n], axis=-1)
        singular = np.abs(np.linalg.det(matrix)) < 1.0e-30
        matrix[singular], rest[singular] = np.eye(3), 0.0
        change = np.linalg.solve(matrix, rest[..., None])[..., 0]
        xi, eta = np.clip(xi - change[:, 0], -2.0, 2.0), np.clip(eta - change[:, 1], -2.0, 2.0)
        g = g - change[:, 2]
    n, _, _, sagitta = _normals(xi, eta, corner, director)
    length = np.linalg.norm(n, axis=1)
    rest = np.einsum("nc,nci->ni", weights(xi, eta)[0], corner) + g[:, None] * n - points
    size = np.linalg.norm(corner[:, 2] - corner[:, 0], axis=1)
    return np.stack([xi, eta, g * length - sagitta / length, np.linalg.norm(rest, axis=1) / size])


def _normals(
    xi: np.ndarray, eta: np.ndarray, corner: np.ndarray, director: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Normals (n, 3) as in kernels/plies/facet.py, about their derivatives by xi and eta, and the sagitta (n,) [m].

    Beyond the edges the quadratic part of the normals is zero, and its part of the sagitta goes on straight.
    """
    weight, by_xi, by_eta = weights(xi, eta)
    n, sagitta = np.einsum("nc,nci->ni", weight, director), np.zeros_like(xi)
    derivatives = []
    # the corners before and after along each coordinate, on both edges
    for own, other, by, edges in ((xi, eta, by_xi, EDGES_ALONG_XI), (eta, xi, by_eta, EDGES_ALONG_ETA)):
        along, leaning = np.einsum("nc,nci->ni", by, corner), 0.0
        for (first, second), side in zip(edges, (-1.0, 1.0), strict=True):
            half, mean = 0.5 * (corner[:, second] - corner[:, first]), 0.5 * (director[:, first] + director[:, second])
            leaning = leaning + 0.5 * (1.0 + side * other) * np.einsum("ni,ni->n", half, mean)
        within = np.clip(own, -1.0, 1.0)
        bow, slope = 1.0 - within**2, np.where(within == own, -2.0 * own, 0.0)
        bend = -1.5 * (leaning / np.square(along).sum(axis=1))[:, None] * along
        change = np.einsum("nc,nci->ni", by, director)
        n = n + bow[:, None] * bend
        derivatives.append(change + slope[:, None] * bend)
        lean = leaning * (bow * within - 2.0 * (own - within))
        sagitta = sagitta + 0.5 * ((1.0 - own**2) * np.einsum("ni,ni->n", along, change) + lean)
    return n, *derivatives, sagitta


def weights(xi: np.ndarray, eta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shares of the corners in a point of a facet, and their derivatives by xi and eta, each (n, 4)."""
    one, other = np.array([-1.0, 1.0, 1.0, -1.0]), np.array([-1.0, -1.0, 1.0, 1.0])
    first, second = 1.0 + xi[:, None] * one, 1.0 + eta[:, None] * other
    return 0.25 * first * second, 0.25 * one * second, 0.25 * other * first
