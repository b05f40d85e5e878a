"""Parts of a sheet that come close to each other."""

from __future__ import annotations

from itertools import product

import numpy as np

from ..errors import InputError


def close_pairs(position: np.ndarray, quads: np.ndarray, distance: float) -> int:
    """Number of pairs of a node and an element closer than ``distance`` [m] that are not neighbours.

    Node and element are neighbours if one or two element edges lead from the node to a corner of the element. An
    element is treated as two triangles.

    Args:
        position: formed nodes, (node_count, 3) [m].
        quads: (element_count, 4).
    """
    if not distance > 0.0:
        raise InputError(f"distance of close pairs is {distance} m; it must be positive")
    gap = pair_distances(position, quads, *far_pairs(position, quads, distance))
    return int((gap < distance).sum())


def far_pairs(position: np.ndarray, quads: np.ndarray, distance: float) -> tuple[np.ndarray, np.ndarray]:
    """``near_pairs`` without neighbours: nodes and elements, (k,) each."""
    node, element = near_pairs(position, quads, distance)
    far = ~np.isin(element * len(position) + node, neighbour_keys(quads, len(position)))
    return node[far], element[far]


def pair_distances(position: np.ndarray, quads: np.ndarray, node: np.ndarray, element: np.ndarray) -> np.ndarray:
    """Distance of each node (k,) from its element (k,), which is two triangles, (k,) [m]."""
    distance = np.full(len(node), np.inf)
    if not len(node):
        return distance
    from trimesh.triangles import closest_point  # import takes half a second, and a good sheet never needs it

    corners = position[quads]
    for triangle in ((0, 1, 2), (0, 2, 3)):
        foot = closest_point(corners[element][:, triangle], position[node])
        distance = np.minimum(distance, np.linalg.norm(foot - position[node], axis=1))
    return distance


def near_pairs(position: np.ndarray, quads: np.ndarray, distance: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and elements, (k,) each, of all pairs that may be closer than ``distance``."""
    corners = position[quads]
    centre = corners.mean(axis=1)
    reach = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1) + distance
    origin, size = position.min(axis=0), reach.max()

    # nodes by cell; for an element the 27 cells around its centre are searched
    node_cell, element_cell = (np.floor((points - origin) / size).astype(np.int64) + 1 for points in (position, centre))
    stride = node_cell.max(axis=0) + 3
    node_key, element_key = ((c[:, 0] * stride[1] + c[:, 1]) * stride[2] + c[:, 2] for c in (node_cell, element_cell))
    order = np.argsort(node_key, kind="stable")
    ranked = node_key[order]
    elements, nodes = [], []
    for shift in product((-1, 0, 1), repeat=3):
        step = (shift[0] * stride[1] + shift[1]) * stride[2] + shift[2]
        first, last = (np.searchsorted(ranked, element_key + step, side=side) for side in ("left", "right"))
        element, place = join(np.arange(len(quads)), first, last)
        node = order[place]
        near = np.sum((position[node] - centre[element]) ** 2, axis=1) < reach[element] ** 2
        elements.append(element[near])
        nodes.append(node[near])
    return np.concatenate(nodes), np.concatenate(elements)


def join(left: np.ndarray, first: np.ndarray, last: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Every (left[i], j) with first[i] <= j < last[i], as two arrays; all three given are (n,)."""
    count = last - first
    ends = np.cumsum(count)
    within = np.arange(int(count.sum())) - np.repeat(ends - count, count)
    return np.repeat(left, count), np.repeat(first, count) + within


def neighbour_keys(quads: np.ndarray, node_count: int) -> np.ndarray:
    """Keys element * node_count + node, (k,), of nodes connected to a corner of the element by at most two edges."""
    edges = np.concatenate([quads[:, [i, (i + 1) % 4]] for i in range(4)]).astype(np.int64)
    itself = np.repeat(np.arange(node_count), 2).reshape(-1, 2)
    first, second = np.concatenate([edges, edges[:, ::-1], itself]).T
    edges = np.stack(np.divmod(np.unique(first * node_count + second), node_count), axis=1)
    element, reached = np.repeat(np.arange(len(quads)), 4), quads.ravel().astype(np.int64)
    for _ in range(2):
        first, last = (np.searchsorted(edges[:, 0], reached, side=side) for side in ("left", "right"))
        element, place = join(element, first, last)
        keys = np.unique(element * node_count + edges[place, 1])
        element, reached = np.divmod(keys, node_count)
    return keys
