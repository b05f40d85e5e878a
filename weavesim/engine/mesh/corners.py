"""Which corners of elements lie around each node."""

from __future__ import annotations

import numpy as np

from ...kernels.rows import ROWS_PER_CORNER
from ...kernels.stepping.node_forces import USUAL_CORNER_COUNT
from ..layout import RowLayout, slots_of_nodes


def corner_table(quads: np.ndarray, node_count: int, corners: RowLayout, places: np.ndarray, spare: int) -> np.ndarray:
    """First entries of the records of the corners around every node, (slots, node_count) int32.

    Args:
        quads: (element_count, 4) node indices.
        node_count: padded.
        corners: layout of the records, rows ``CornerRow``.
        places: of every element in ``corners``, (element_count,) int.
        spare: place of an element whose records are always zero: nodes with fewer neighbours read them.
    """
    node = quads.ravel()
    order, slot = slots_of_nodes(node)
    table = np.full((max(slot.max() + 1, USUAL_CORNER_COUNT), node_count), corners.entry(0, spare), dtype=np.int32)
    entry = corners.entry(ROWS_PER_CORNER * np.tile(np.arange(4), len(quads)), np.repeat(places, 4))
    table[slot, node[order]] = entry[order]
    return table
