"""Normals of the plies at their nodes: tables, and the launch that computes them in every step."""

from __future__ import annotations

import numpy as np
import warp as wp

from ...kernels.plies.normals import NORMAL_ROW_COUNT, normal_table_struct, surface_normals_kernel
from ...sheet.symmetry import AXES
from ..layout import RowLayout, lanes_view, slots_of_nodes
from ..sheet_model import SheetModel


def normal_layout(sheet: SheetModel) -> RowLayout:
    """Layout of the normals of a sheet."""
    return RowLayout(NORMAL_ROW_COUNT, sheet.node_count, sheet.lane_count, NORMAL_ROW_COUNT)


class NormalLaunch:
    """Computes the normals of one sheet on one state.

    Args:
        sheet: constants.
        motion: of its nodes, in one state.
        awake: int32 of that state, 0 where no contact needs normals now.

    Attributes:
        normals: flat, ``normal_layout``.
    """

    def __init__(self, sheet: SheetModel, motion: wp.array, awake: wp.array) -> None:
        self._sheet, self._motion, self._awake = sheet, motion, awake
        self._always = wp.ones(1, dtype=wp.int32, device=sheet.device)
        self.normals = wp.zeros(NORMAL_ROW_COUNT * sheet.node_count, dtype=sheet.real, device=sheet.device)
        self._rows = sheet.motion_layout.view(motion)
        self._view = normal_layout(sheet).view(self.normals)
        self._table = _table(sheet)

    def launch(self, first: int, count: int, always: bool = False) -> None:
        """Normals of ``count`` blocks of nodes from ``first``; ``always`` also where no contact needs them."""
        wp.launch(
            surface_normals_kernel(self._sheet.real, self._sheet.lane_count),
            dim=count,
            inputs=[first, self._table, self._motion, self._rows, self._always if always else self._awake],
            outputs=[self._view],
            device=self._sheet.device,
        )


def _table(sheet: SheetModel):
    blank, lane_count = sheet.blank, sheet.lane_count
    quads, node = blank.quads, blank.quads.ravel()
    order, slot = slots_of_nodes(node)
    # a node without a further element sees itself, and no area
    own = sheet.motion_layout.entry(0, np.arange(sheet.node_count))
    tables: list[wp.array] = []
    for shift in (-1, 1):
        table = np.tile(own, (slot.max() + 1, 1)).astype(np.int32)
        neighbour = np.roll(quads, shift, axis=1).ravel()
        table[slot, node[order]] = sheet.motion_layout.entry(0, neighbour[order])
        tables.append(
            wp.array(table.reshape(len(table), -1, lane_count), dtype=sheet.types.indices, device=sheet.device)
        )
    kept = np.ones((3, sheet.node_count))
    for plane in sheet.symmetry.planes:
        kept[AXES[plane], : blank.node_count][sheet.symmetry.held_nodes(blank, plane)] = 0.0
    result = normal_table_struct(sheet.real, lane_count)()
    result.following, result.preceding = tables
    result.kept = lanes_view(wp.array(kept, dtype=sheet.real, device=sheet.device), lane_count)
    result.stride = sheet.motion_layout.stride
    return result
