"""Order of the elements of a sheet in which their samples are looked at in blocks."""

from __future__ import annotations

import numpy as np

from ..layout import BLOCK

# Elements change places within windows: blocks of one at most, and windows of a sheet at least, for threads to share.
LARGEST_WINDOW, FEWEST_WINDOWS = 64, 10


def window(element_count: int, lane_count: int) -> int:
    """Blocks of elements that tiles and threads do not divide, for ``compact_order``."""
    if lane_count == 1:
        return 1
    return int(np.clip(element_count // (FEWEST_WINDOWS * lane_count), 1, LARGEST_WINDOW))


def compact_order(centres: np.ndarray, window_size: int) -> np.ndarray:
    """Elements in an order in which each sixteen lie together, (n,).

    Elements are numbered row by row, and a row of sixteen reaches from one feature of a tool to the next. They only
    change places within windows, so that tiles of elements stay what they are.

    Args:
        centres: of the elements, (n, 3) [m].
        window_size: blocks of elements of a window.
    """
    size = window_size * BLOCK
    parts = [
        _halved(centres, np.arange(first, min(first + size, len(centres)))) for first in range(0, len(centres), size)
    ]
    return np.concatenate([np.empty(0, dtype=int), *parts])


def _halved(centres: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """Halved across their length until blocks are left."""
    block_count = -(-len(elements) // BLOCK)
    if block_count <= 1:
        return elements
    own = centres[elements]
    axis = int(np.argmax(own.max(axis=0) - own.min(axis=0)))
    in_order = elements[np.argsort(own[:, axis], kind="stable")]
    half = (block_count // 2) * BLOCK
    return np.concatenate([_halved(centres, in_order[:half]), _halved(centres, in_order[half:])])
