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


def flat_areas(blank: Blank) -> np.ndarray:
    """Areas of the elements of the flat blank, (element_count,) [m^2]."""
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
