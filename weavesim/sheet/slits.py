"""Cut a mesh open along slits: its edges nearest to each slit, whose nodes are moved onto it, are doubled.

Where the edges of elements are not along a slit the cut is a zigzag about it, by less than half an element.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InputError
from .untangling import corner_sines

# A slit goes along edges within this many element sizes of it.
REACH = 1.5
# Nodes are moved onto a slit, or by part of the distance, as long as elements keep this quality.
LEAST_QUALITY = 0.3
# How dear it is for an edge to be off the slit.
OFF_THE_SLIT = 4.0


def cut_open(
    node: np.ndarray, quads: np.ndarray, slits: Sequence[np.ndarray], element_size: float
) -> tuple[np.ndarray, np.ndarray, float]:
    """Nodes and elements with both sides of each slit apart, and how far a cut is from its slit at most [m].

    Args:
        node: (n, 2) [m].
        quads: (m, 4).
        slits: points of each, in order, (k, 2) [m].
        element_size: of the mesh [m].

    Raises:
        InputError: a slit that is shorter than an element, outside the sheet, or crosses another.
    """
    cuts: list[np.ndarray] = []
    furthest = 0.0
    for index, slit in enumerate(slits):
        slit = np.asarray(slit, dtype=np.float64)
        if len(slit) < 2 or np.linalg.norm(np.diff(slit, axis=0), axis=1).sum() < element_size:
            raise InputError(f"slit {index} is shorter than an element; use smaller elements, or leave it out")
        path = _path(node, quads, slit, element_size, index)
        node = _moved(node, quads, path, slit, {int(k) for cut in cuts for k in cut})
        furthest = max(furthest, float(_distance(node[path], slit).max()))
        cuts.append(path)
    return *_doubled(node, quads, cuts), furthest


def _distance(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Distances (n,) of points (n, 2) from a line of points (k, 2)."""
    start, side = line[:-1], np.diff(line, axis=0)
    share = np.einsum("nki,ki->nk", points[:, None] - start, side) / np.maximum((side**2).sum(axis=1), 1e-300)
    place = start + np.clip(share, 0.0, 1.0)[..., None] * side
    return np.linalg.norm(points[:, None] - place, axis=2).min(axis=1)


def _path(node: np.ndarray, quads: np.ndarray, slit: np.ndarray, size: float, index: int) -> np.ndarray:
    """Nodes along edges of the mesh that follow a slit, in order."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra

    edges = np.unique(np.sort(np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)]), axis=1), axis=0)
    distance = _distance(node, slit)
    near = np.all(distance[edges] <= REACH * size, axis=1)
    a, b = edges[near].T
    length = np.linalg.norm(node[a] - node[b], axis=1) * (1.0 + OFF_THE_SLIT * (distance[a] + distance[b]) / size)
    graph = coo_matrix((length, (a, b)), shape=(len(node), len(node))).tocsr()
    stops = [int(np.argmin(np.linalg.norm(node - point, axis=1))) for point in slit]
    for point, stop in zip(slit, stops, strict=True):
        if np.linalg.norm(node[stop] - point) > REACH * size:
            raise InputError(
                f"slit {index}: its point ({point[0]:.4g}, {point[1]:.4g}) m lies outside the sheet, or in a hole"
            )
    path = [stops[0]]
    for start, stop in zip(stops[:-1], stops[1:], strict=True):
        if start == stop:
            continue
        before = dijkstra(graph, directed=False, indices=start, return_predecessors=True)[1]
        piece = [stop]
        while piece[-1] != start:
            if before[piece[-1]] < 0:
                raise InputError(f"slit {index} leads through a hole, or out of the sheet; give it in pieces")
            piece.append(int(before[piece[-1]]))
        path += piece[-2::-1]
    if len(path) < 2 or len(set(path)) < len(path):
        raise InputError(f"slit {index} is too short, or turns too sharply, for the elements; use smaller ones")
    return np.array(path)


def _moved(node: np.ndarray, quads: np.ndarray, path: np.ndarray, slit: np.ndarray, held: set[int]) -> np.ndarray:
    """Nodes of a path moved onto the slit, as far as the elements allow; those on the border stay on it."""
    edges = np.sort(np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)]), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    on_border = np.zeros(len(node), dtype=bool)
    on_border[unique[count == 1].ravel()] = True
    free = np.array([k for k in path if not on_border[k] and int(k) not in held], dtype=int)
    if not len(free):
        return node
    wished = node.copy()
    wished[free] = _spread(node, path, slit)[np.isin(path, free)]
    before = corner_sines(node, quads)
    for share in (0.5, 0.5, 0.0):
        after = corner_sines(wished, quads)
        worse = np.unique(quads[(after < LEAST_QUALITY) & (after < before)].ravel())
        worse = worse[np.isin(worse, free)]
        if not len(worse):
            break
        wished[worse] = node[worse] + share * (wished[worse] - node[worse])
    return wished


def _spread(node: np.ndarray, path: np.ndarray, slit: np.ndarray) -> np.ndarray:
    """Places of the nodes of a path on a slit, in order and as far apart as along the path, (k, 2)."""
    stops = [int(np.argmin(np.linalg.norm(node[path] - point, axis=1))) for point in slit]
    stops[0], stops[-1] = 0, len(path) - 1
    place = node[path].copy()
    for (first, a), (last, b) in zip(
        zip(stops[:-1], slit[:-1], strict=True), zip(stops[1:], slit[1:], strict=True), strict=True
    ):
        way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(node[path[first : last + 1]], axis=0), axis=1)))
        if way[-1] > 0.0:
            place[first : last + 1] = a + (way / way[-1])[:, None] * (b - a)
    return place


def _doubled(node: np.ndarray, quads: np.ndarray, cuts: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Each node on a cut once for every group of elements around it that edges which are not cut connect."""
    cut = {tuple(sorted(map(int, pair))) for path in cuts for pair in zip(path[:-1], path[1:], strict=True)}
    quads, nodes = quads.copy(), [node]
    count = len(node)
    on_cut = sorted({k for pair in cut for k in pair})
    around: dict[int, list[int]] = {k: [] for k in on_cut}
    for row in np.flatnonzero(np.isin(quads, on_cut).any(axis=1)).tolist():
        for corner in quads[row]:
            if int(corner) in around:
                around[int(corner)].append(row)
    original = quads.copy()
    for spot in map(int, on_cut):
        rest, groups = list(around[spot]), []
        while rest:
            group = [rest.pop()]
            for row in group:
                own = _spokes(original[row], spot) - {other for pair in cut if spot in pair for other in pair}
                joined = [other for other in rest if own & _spokes(original[other], spot)]
                group += joined
                rest = [other for other in rest if other not in joined]
            groups.append(sorted(group))
        for group in sorted(groups)[1:]:
            quads[group] = np.where(original[group] == spot, count, quads[group])
            nodes.append(node[spot : spot + 1])
            count += 1
    return np.concatenate(nodes), quads


def _spokes(quad: np.ndarray, node: int) -> set[int]:
    """The neighbours of a node along the edges of an element."""
    place = int(np.flatnonzero(quad == node)[0])
    return {int(quad[place - 1]), int(quad[(place + 1) % 4])}
