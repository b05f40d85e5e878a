"""Where a sheet lies on itself: distance of every element to other parts of the sheet."""

from __future__ import annotations

import numpy as np

from ...process.self_contact import EXCLUDED_THICKNESSES
from ..proximity import far_pairs, pair_distances


def distance_to_others(
    position: np.ndarray, flat: np.ndarray, quads: np.ndarray, thickness: float, reach: float
) -> np.ndarray:
    """Distance of the mid-surface of each element to that of other parts of its sheet, (element_count,) [m].

    From nodes to elements, which are two triangles each. Infinite where nothing is within ``reach``. Neighbours do not
    count: what one or two edges of elements join, and what is nearer on the flat blank than twice the thickness.

    Args:
        position: formed nodes, (node_count, 3) [m].
        flat: their material coordinates, (node_count, 2) [m].
        quads: (element_count, 4).
        thickness: of the sheet [m].
        reach: [m].
    """
    result, at_node = np.full(len(quads), np.inf), np.full(len(position), np.inf)
    node, element = far_pairs(position, quads, reach)
    corner = flat[quads]
    size = np.linalg.norm(corner - corner.mean(axis=1)[:, None], axis=2).max(axis=1)
    apart = np.linalg.norm(flat[node] - corner.mean(axis=1)[element], axis=1) - size[element]
    far = apart > EXCLUDED_THICKNESSES * thickness
    node, element = node[far], element[far]
    distance = pair_distances(position, quads, node, element)
    np.minimum.at(at_node, node, distance)
    np.minimum.at(result, element, distance)
    result = np.minimum(result, at_node[quads].min(axis=1))
    return np.where(result <= reach, result, np.inf)
