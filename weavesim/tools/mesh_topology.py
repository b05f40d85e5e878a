"""Edges of a triangle mesh: neighbours, borders, seams, and a consistent orientation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

# Pairs of edges that a search for seams compares at once.
SEAM_CHUNK = 20_000


def directed_edges(faces: np.ndarray) -> np.ndarray:
    """(3 m, 2): the edges of face i are rows 3 i to 3 i + 2."""
    edges = np.empty((len(faces), 3, 2), dtype=faces.dtype)
    edges[:, :, 0], edges[:, :2, 1], edges[:, 2, 1] = faces, faces[:, 1:], faces[:, 0]
    return edges.reshape(-1, 2)


def edge_keys(edges: np.ndarray) -> np.ndarray:
    """A number for each edge, the same for both directions."""
    low, high = np.minimum(edges[:, 0], edges[:, 1]), np.maximum(edges[:, 0], edges[:, 1])
    return low.astype(np.int64, copy=False) * (int(edges.max(initial=0)) + 1) + high


def neighbours(faces: np.ndarray) -> np.ndarray:
    """Pairs of edges (rows of ``directed_edges``) that two triangles share, (k, 2)."""
    key = edge_keys(directed_edges(faces))
    order = np.argsort(key, kind="stable")
    same = key[order[1:]] == key[order[:-1]]
    # where more than two triangles meet, none are neighbours
    twice = np.append(same[1:], False) | np.append(False, same[:-1])
    pick = np.flatnonzero(same & ~twice)
    return np.column_stack([order[pick], order[pick + 1]])


def odd_edges(edges: np.ndarray, component: np.ndarray) -> np.ndarray:
    """Rows of edges, (k,), that an odd number of faces of their component share."""
    key = edge_keys(edges)
    of = np.repeat(component, 3)
    order = np.lexsort((of, key))
    start = np.flatnonzero(np.append(True, (np.diff(key[order]) != 0) | (np.diff(of[order]) != 0)))
    times = np.diff(np.append(start, len(order)))
    return order[start[times % 2 == 1]]


def place(point: np.ndarray) -> str:
    """A point [m] in words, in millimetres."""
    return f"({', '.join(f'{1e3 * c:.4g}' for c in point)}) mm"


def labels(count: int, pairs: np.ndarray) -> np.ndarray:
    """Number of the connected component of each of ``count`` items, linked by ``pairs`` (k, 2)."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    links = coo_matrix((np.ones(len(pairs), dtype=np.int8), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return connected_components(links, directed=False)[1]


def oriented(faces: np.ndarray, pairs: np.ndarray, agree: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Faces oriented consistently with their neighbours, each component as its first face.

    Args:
        faces: (m, 3).
        pairs: of faces that are neighbours, (k, 2).
        agree: whether the two are oriented alike.

    Returns:
        faces; number of the component of each; whether its component is one-sided, like a Moebius strip.
    """
    count = len(faces)
    one, other = pairs[:, 0], pairs[:, 1]
    # every face as it is, and turned over: a face that is linked to its own reverse is part of a one-sided surface
    across = np.where(agree, other, other + count), np.where(agree, other + count, other)
    way = labels(
        2 * count, np.column_stack([np.concatenate([one, one + count]), np.concatenate(across).astype(np.int64)])
    )
    one_sided = way[:count] == way[count:]
    _, first, component = np.unique(np.minimum(way[:count], way[count:]), return_index=True, return_inverse=True)
    turned = ~one_sided & (way[:count] != way[first[component]])
    return np.where(turned[:, None], faces[:, ::-1], faces), component, one_sided


@dataclass(frozen=True)
class Contacts:
    """Border edges whose middles lie on another border edge, as at a seam of two patches.

    Attributes:
        edge, other: rows in the array of border edges, (k,).
        along: whether the two run in the same direction.
    """

    edge: np.ndarray
    other: np.ndarray
    along: np.ndarray


def seam_contacts(vertices: np.ndarray, border: np.ndarray, tolerance: float) -> Contacts:
    """All contacts of border edges (k, 2) within ``tolerance`` [m], and within 0.4 of an edge's own length."""
    from scipy.spatial import cKDTree

    start, end = vertices[border[:, 0]], vertices[border[:, 1]]
    middle, along = 0.5 * (start + end), end - start
    length = np.maximum(np.linalg.norm(along, axis=1), 1e-15)
    allowed = np.minimum(tolerance, 0.4 * length)
    found = [np.empty((0, 2), dtype=np.int64)]
    if len(border):
        tree = cKDTree(middle)
        # by classes of length, so that the search around a short edge is not as wide as that around the longest
        size = np.floor(np.log2(length / length.min())).astype(int)
        for value in np.unique(size):
            members = np.flatnonzero(size == value)
            for first in range(0, len(members), SEAM_CHUNK):
                found.append(_touching(tree, members[first : first + SEAM_CHUNK], start, along, length, allowed))
    pairs = np.concatenate(found)
    edge, other = pairs[:, 0], pairs[:, 1]
    return Contacts(edge, other, np.einsum("ij,ij->i", along[edge], along[other]) > 0.0)


def _touching(
    tree, longer: np.ndarray, start: np.ndarray, along: np.ndarray, length: np.ndarray, allowed: np.ndarray
) -> np.ndarray:
    """Pairs (edge, other), other among the edges ``longer``, where the edge's middle lies on the other."""
    from scipy.spatial import cKDTree

    middle = tree.data
    reach = 0.5 * float(length[longer].max()) + float(allowed.max())
    near = cKDTree(middle[longer]).sparse_distance_matrix(tree, reach, output_type="ndarray")
    other, edge = longer[near["i"]], near["j"]
    share = np.einsum("ij,ij->i", middle[edge] - start[other], along[other]) / length[other] ** 2
    gap = np.linalg.norm(start[other] + share.clip(0.0, 1.0)[:, None] * along[other] - middle[edge], axis=1)
    kept = (gap < allowed[edge]) & (edge != other)
    return np.column_stack([edge[kept], other[kept]])


def border_in_words(vertices: np.ndarray, edges: np.ndarray) -> str:
    """The open border of a mesh for messages: number of edges and loops, and the smallest loop's place and size.

    Args:
        vertices: (n, 3) [m].
        edges: (k, 2).
    """
    index = np.unique(edges, return_inverse=True)[1].reshape(-1, 2)
    loop = labels(int(index.max()) + 1, index)[index[:, 0]]
    counts = np.bincount(loop)
    corners = vertices[edges[loop == np.argmin(counts)].ravel()]
    loops = f"in {len(counts)} loops, the smallest" if len(counts) > 1 else "in one loop"
    return (
        f"{len(edges)} open edges {loops} of {counts.min()} edges, "
        f"{1e3 * float(np.linalg.norm(np.ptp(corners, axis=0))):.3g} mm across, at {place(corners[0])}"
    )
