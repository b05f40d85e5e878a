"""Tolerances, areas and connectivity of a mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..quantities import finite

if TYPE_CHECKING:
    from .blank import Blank

# Distances below this share of the size of the blank count as zero when testing whether a node lies on a line.
_RELATIVE_TOLERANCE = 1.0e-6


def checked_distortion(distortion: float) -> float:
    """A random displacement of inner nodes, as a share of the element size.

    Raises:
        InputError: not from 0 to below 0.4, where elements stay convex.
    """
    if not 0.0 <= finite("distortion", distortion) < 0.4:
        raise InputError(f"distortion = {distortion}: a number from 0 to 0.4 is needed")
    return distortion


def length_tolerance(blank: Blank) -> float:
    """Distance [m] below which coordinates of the flat blank are taken as equal."""
    return _RELATIVE_TOLERANCE * float(np.ptp(blank.material_coordinates, axis=0).max())


def area_percentile(values: np.ndarray, areas: np.ndarray, share: float) -> float:
    """Value that a share [%] of the area stays below; what is not a number is left out, and nan if nothing is left.

    Args:
        values: of elements, (k,).
        areas: of them, (k,), in any unit.
        share: of the area [%].
    """
    known = np.isfinite(values)
    values, areas = values[known], areas[known]
    if not len(values):
        return float("nan")
    order = np.argsort(values)
    below = np.cumsum(areas[order]) - 0.5 * areas[order]
    return float(np.interp(0.01 * share * areas.sum(), below, values[order]))


def flat_areas(blank: Blank) -> np.ndarray:
    """Areas of the elements of the flat blank, (element_count,) [m^2]."""
    corner = blank.material_coordinates[blank.quads]
    p, q = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    return 0.5 * np.abs(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])


def longest_outline(quads: np.ndarray, node_count: int) -> np.ndarray:
    """Nodes of the longest closed outline of elements (m, 4), in order, counter-clockwise, (k,)."""
    edges = np.concatenate([quads[:, [i, (i + 1) % 4]] for i in range(4)])
    first, second = edges.T.astype(np.int64)
    either_way = np.minimum(first, second) * node_count + np.maximum(first, second)
    _, inverse, count = np.unique(either_way, return_inverse=True, return_counts=True)
    following = dict(edges[count[inverse] == 1].tolist())
    loops = []
    while following:
        start = next(reversed(following))
        loop, node = [start], following.pop(start)
        while node != start:
            loop.append(node)
            node = following.pop(node)
        loops.append(loop)
    return np.array(max(loops, key=len), dtype=np.int32)


def unit_normals(position: np.ndarray, quads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals of the nodes, (node_count, 3), means of those of their elements by area, and of the elements."""
    normal = doubled_normals(position, quads)
    director = np.zeros_like(position)
    for corner in range(4):
        np.add.at(director, quads[:, corner], normal)
    director[np.linalg.norm(director, axis=1) == 0.0] = (0.0, 0.0, 1.0)
    director /= np.linalg.norm(director, axis=1, keepdims=True)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return director, normal


def at_corners(values: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Vectors of the nodes (node_count, 3) at the corners of all elements, (3, 4, element_count).

    One component after the other is several times as fast as one vector after the other.

    Args:
        values: of the nodes.
        corners: their numbers, (4, element_count).
    """
    return values.T.take(corners, axis=1)


def doubled_normals(position: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Normals of elements (m, 4), from their diagonals, as long as twice the area, (m, 3) [m^2].

    Args:
        position: of the nodes, (node_count, 3) [m].
        quads: corner nodes of each element, (m, 4).
    """
    return np.stack(_doubled_normals(position, quads), axis=1)


def _doubled_normals(position: np.ndarray, quads: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Their components, (m,) each."""
    corner = at_corners(position, quads.T)
    (x1, y1, z1), (x2, y2, z2) = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    return y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2


def node_normals(position: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Unit normals at the nodes, of which each element has a share by its area, (node_count, 3); zero without any.

    Args:
        position: of the nodes, (node_count, 3) [m].
        quads: corner nodes of each element, (m, 4).
    """
    corners = quads.ravel()
    total = np.stack(
        [np.bincount(corners, np.repeat(each, 4), len(position)) for each in _doubled_normals(position, quads)]
    )
    return (total / np.maximum(np.sqrt((total * total).sum(axis=0)), 1.0e-300)).T


def part_of_nodes(groups: np.ndarray, node_count: int) -> np.ndarray:
    """Lowest node number in the connected part of each node, (node_count,).

    Args:
        groups: nodes that are connected, such as the corners of each element, (m, k).
        node_count: of all nodes.
    """
    part = np.arange(node_count)
    while True:
        lowest = part[groups].min(axis=1)
        before = part.copy()
        # the parts of all nodes of a group are merged into the lowest of them
        np.minimum.at(part, before[groups].ravel(), np.repeat(lowest, groups.shape[1]))
        while not np.array_equal(part, part[part]):
            part = part[part]
        if np.array_equal(part, before):
            return part
