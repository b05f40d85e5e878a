"""Connected regions of elements, and what counts in them."""

from __future__ import annotations

import numpy as np

from ...sheet.topology import part_of_nodes


def regions(quads: np.ndarray, chosen: np.ndarray) -> list[np.ndarray]:
    """Elements of each connected region among the chosen ones, the largest number of elements first.

    Elements are connected if they share a node.

    Args:
        quads: corner nodes of all elements, (element_count, 4).
        chosen: (element_count,) bool.
    """
    rows = np.flatnonzero(chosen)
    if not len(rows):
        return []
    nodes, local = np.unique(quads[rows], return_inverse=True)
    part = part_of_nodes(local.reshape(-1, 4), len(nodes))[local.reshape(-1, 4)[:, 0]]
    found = [rows[part == number] for number in np.unique(part)]
    return sorted(found, key=lambda region: (-len(region), int(region[0])))


def with_neighbours(quads: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Elements that are chosen, or share a node with one that is, (element_count,) bool."""
    nodal = np.zeros(int(quads.max(initial=-1)) + 1, dtype=bool)
    nodal[quads[chosen]] = True
    found: np.ndarray = nodal[quads.T].any(axis=0)
    return found
