"""Elements that are folded or turned over, and nodes on the wrong side of a symmetry plane."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..sheet.symmetry import AXES
from ..sheet.topology import doubled_normals

if TYPE_CHECKING:
    from ..sheet.blank import Blank
    from ..sheet.symmetry import Symmetry

# Neighbours whose normals differ by more are folded onto each other [degrees].
LARGEST_FOLD = 170.0


def folded_elements(position: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Which elements are folded along a diagonal by more than 90 degrees, (element_count,) bool.

    Args:
        position: formed nodes, (node_count, 3) [m].
        quads: (element_count, 4).
    """
    corners = position[quads]
    following, before = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    normal = np.cross(following, before)  # at each corner that of the triangle with its two neighbours
    opposite = np.einsum("eci,eci->ec", normal[:, :2], normal[:, 2:])
    return (opposite < 0.0).any(axis=1)


def neighbours(quads: np.ndarray) -> np.ndarray:
    """Pairs of elements with a common edge, (k, 2)."""
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    element = np.repeat(np.arange(len(quads)), 4)
    order = np.lexsort(edges.T)
    edges, element = edges[order], element[order]
    same = (edges[1:] == edges[:-1]).all(axis=1)
    return np.column_stack([element[:-1][same], element[1:][same]])


def folded_pairs(position: np.ndarray, quads: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Which neighbours are folded onto each other, (k,) bool, for the ``pairs`` of ``neighbours``."""
    normal = doubled_normals(position, quads)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1.0e-300)[:, None]
    cosine = np.einsum("ki,ki->k", normal[pairs[:, 0]], normal[pairs[:, 1]])
    return cosine < np.cos(np.deg2rad(LARGEST_FOLD))


def facing(position: np.ndarray, director: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Positive where the normal of an element points as the directors of its nodes do, else negative, (element_count,).

    Args:
        position, director: of the nodes, (node_count, 3).
        quads: (element_count, 4).
    """
    along: np.ndarray = np.einsum("ei,ei->e", doubled_normals(position, quads), director[quads].sum(axis=1))
    return along


def directors_apart(director: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Angle between the mean directors at both diagonals of each element, (element_count,) [rad].

    None where the element is bent or twisted, whose normals are the same at both; twice the angle by which directors
    of neighbouring nodes swing against each other (docs/theory.md, section 5).

    Args:
        director: of the nodes, (node_count, 3).
        quads: (element_count, 4).
    """
    one, other = (director[quads[:, k]] + director[quads[:, k + 2]] for k in range(2))
    across = np.linalg.norm(np.cross(one, other), axis=1)
    return np.asarray(np.arctan2(across, np.einsum("ei,ei->e", one, other)))


def beyond_symmetry(position: np.ndarray, blank: Blank, symmetry: Symmetry) -> np.ndarray:
    """How far each node lies beyond a symmetry plane, on the side of the mirror image, (node_count,) [m]."""
    beyond = np.zeros(len(position))
    for plane in symmetry.planes:
        axis = AXES[plane]
        side = np.sign(blank.node_position[:, axis].sum())
        beyond = np.maximum(beyond, -side * position[:, axis])
    return beyond
