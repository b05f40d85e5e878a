"""Memory of corner records that stays in a core's cache: few places, used by all tiles in turn."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from ...kernels.rows import CORNER_ROW_COUNT
from ...kernels.stepping.node_data import node_struct
from ..layout import RowLayout
from ..mesh.corners import corner_table
from ..sheet_model import SheetModel
from .corner_places import CornerPlaces


class CornerRing:
    """Corner records of the tiles of one sheet on one number of threads (docs/decisions/0067).

    Args:
        sheet: constants.
        places: of its blocks of elements.

    Attributes:
        records: flat, as in ``SheetModel.corners`` but by places; the block behind the last place stays zero.
        nodes: those of the sheet, with the entries of their corners in ``records``.
    """

    def __init__(self, sheet: SheetModel, places: CornerPlaces) -> None:
        self._of_block, lane_count = places.of_block, sheet.lane_count
        self._layout = RowLayout(CORNER_ROW_COUNT, (places.count + 1) * lane_count, lane_count, CORNER_ROW_COUNT)
        self.records = wp.zeros(CORNER_ROW_COUNT * self._layout.length, dtype=sheet.real, device=sheet.device)
        self.nodes = self._nodes(sheet, lane_count * places.count)

    def _nodes(self, sheet: SheetModel, spare: int) -> Any:
        elements, lane_count = np.arange(sheet.blank.element_count), sheet.lane_count
        place = lane_count * self._of_block[elements // lane_count] + elements % lane_count
        table = corner_table(sheet.blank.quads, sheet.node_count, self._layout, place, spare)
        nodes = node_struct(sheet.real, lane_count)()
        for name in node_struct(sheet.real, lane_count).vars:
            setattr(nodes, name, getattr(sheet.nodes, name))
        nodes.corner_offset = sheet.node_indices(table)
        return nodes

    def at(self, first: int) -> wp.array:
        """[row, block] of lanes, with block ``first``, the first one of a run, at its place.

        Only the blocks of that run lie within the memory for certain.
        """
        return self._layout.view(self.records, int(self._of_block[first]) - first)
