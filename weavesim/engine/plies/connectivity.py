"""Neighbours among the elements of a mesh, as facets on which another ply stands."""

from __future__ import annotations

import numpy as np

from ...kernels.plies.facet import FREE_EDGE, SYMMETRY_EDGE
from ...sheet.blank import Blank
from ...sheet.symmetry import Symmetry

# Two normals turn against each other by at most this over the shortest edge of the flat sheet, for every metre that
# both faces move: an edge of half that length turns by twice a node's way over its length, a normal between edges at 30
# degrees by four times that, and by half as much more as the weights of its elements change.
TURNING_OF_EDGES = 24.0


def turning_way(blank: Blank) -> float:
    """What both faces move at least while normals, or facets, turn against each other by one radian [m]."""
    return float(_edge_lengths(blank).min()) / TURNING_OF_EDGES


def longest_edge(blank: Blank) -> float:
    """Of the flat sheet [m]."""
    return float(_edge_lengths(blank).max())


def _edge_lengths(blank: Blank) -> np.ndarray:
    corners = blank.material_coordinates[blank.quads]
    return np.asarray(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2))


def edge_neighbours(blank: Blank, symmetry: Symmetry) -> np.ndarray:
    """The element beyond every edge, FREE_EDGE or SYMMETRY_EDGE, (element_count, 4) int32.

    Edge k of an element leads from its corner k to the next one.
    """
    quads = blank.quads
    nodes = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    ordered = np.sort(nodes, axis=1)
    _, edge, count = np.unique(ordered, axis=0, return_inverse=True, return_counts=True)
    edge = edge.ravel()
    result = np.full(len(nodes), int(FREE_EDGE), dtype=np.int32)
    order = np.argsort(edge, kind="stable")
    first = np.flatnonzero(count[edge[order]] == 2)[::2]
    one, other = order[first], order[first + 1]
    result[one], result[other] = other // 4, one // 4
    for plane in symmetry.planes:
        on_plane = symmetry.held_nodes(blank, plane)
        result[(result == int(FREE_EDGE)) & on_plane[nodes].all(axis=1)] = int(SYMMETRY_EDGE)
    return result.reshape(-1, 4)


def rings(quads: np.ndarray) -> np.ndarray:
    """Elements that share a node with each, itself first, then ascending, (element_count, k) int32; -1 where none."""
    from scipy.sparse import csr_array

    count = len(quads)
    row = np.repeat(np.arange(count), 4)
    touching = csr_array((np.ones(4 * count, dtype=np.int32), (row, quads.ravel())), shape=(count, quads.max() + 1))
    shared = (touching @ touching.T).tocsr()
    shared.sort_indices()
    sizes = np.diff(shared.indptr)
    result = np.full((count, int(sizes.max())), -1, dtype=np.int32)
    place = np.arange(len(shared.indices)) - np.repeat(shared.indptr[:-1], sizes)
    result[np.repeat(np.arange(count), sizes), place] = shared.indices
    # itself first: a stable sort keeps the others ascending
    order = np.argsort(result != np.arange(count)[:, None], axis=1, kind="stable")
    return np.take_along_axis(result, order, axis=1)


def home_elements(blank: Blank) -> np.ndarray:
    """The lowest element beside every node, (node_count,) int32."""
    home = np.full(blank.node_count, blank.element_count, dtype=np.int32)
    np.minimum.at(home, blank.quads.ravel(), np.repeat(np.arange(blank.element_count, dtype=np.int32), 4))
    return home


def free_edge_nodes(blank: Blank, symmetry: Symmetry) -> np.ndarray:
    """Nodes of free edges, ascending (k,)."""
    neighbours = edge_neighbours(blank, symmetry)
    element, edge = np.nonzero(neighbours == int(FREE_EDGE))
    return np.unique(np.concatenate([blank.quads[element, edge], blank.quads[element, (edge + 1) % 4]]))


def free_edge_distance(blank: Blank, symmetry: Symmetry) -> np.ndarray:
    """Distance of every node of the flat blank from the nearest node of a free edge, (node_count,) [m]."""
    flat = blank.material_coordinates
    return distance_from(flat, flat[free_edge_nodes(blank, symmetry)])


def distance_from(points: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Distance of ``points`` (n, d) from the nearest of ``others`` (k, d), (n,); infinite where there are none."""
    from scipy.spatial import KDTree

    return KDTree(others).query(points)[0] if len(others) else np.full(len(points), np.inf)
