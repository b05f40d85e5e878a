"""Strips for tests that are held at one end and bent by a couple at the other."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from weavesim.sheet.blank import Blank


class BentStrip(NamedTuple):
    """A row of elements along x that bends in the plane of x and z alone.

    Attributes:
        blank: of the strip.
        free: which of the three displacements and rotations of each node are free, (node_count, 6).
        couple: at each node, for a moment per width about y at the free end, (node_count, 3) [N m].
    """

    blank: Blank
    free: np.ndarray
    couple: np.ndarray


def bent_strip(length: float, width: float, count: int, moment: float) -> BentStrip:
    """A strip of ``count`` elements, of length and width in m, for a moment per width [N]."""
    blank = Blank.rectangle((0.0, 0.0), (length, width), (length / count, width))
    x = blank.node_position[:, 0]
    free = np.ones((blank.node_count, 6), dtype=bool)
    free[x < 1e-9] = False
    free[:, [1, 3, 5]] = False
    couple = np.zeros((blank.node_count, 3))
    couple[x > length - 1e-9, 1] = -0.5 * moment * width
    return BentStrip(blank, free, couple)
