"""Tolerances, areas and connectivity of a mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .blank import Blank

# Distances below this share of the size of the blank count as zero when testing whether a node lies on a line.
_RELATIVE_TOLERANCE = 1.0e-6


def length_tolerance(blank: Blank) -> float:
    return _RELATIVE_TOLERANCE * float(np.ptp(blank.material_coordinates, axis=0).max())


def flat_areas(blank: Blank) -> np.ndarray:
    corner = blank.material_coordinates[blank.quads]
    p, q = corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]
    return 0.5 * np.abs(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0])


def part_of_nodes(quads: np.ndarray, node_count: int) -> np.ndarray:
    """Lowest node number in the connected part of each node, (node_count,); elements connect their corners."""
    part = np.arange(node_count)
    while True:
        lowest = part[quads].min(axis=1)
        before = part.copy()
        # the parts of all corners are merged into the lowest of them
        np.minimum.at(part, before[quads].ravel(), np.repeat(lowest, 4))
        while not np.array_equal(part, part[part]):
            part = part[part]
        if np.array_equal(part, before):
            return part
