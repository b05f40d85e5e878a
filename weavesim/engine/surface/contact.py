"""Contact of a sheet with its tools between the nodes: constants, and the launch."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from ...device import block_size
from ...kernels.contact.penalty import touch_struct
from ...kernels.stepping.sample_data import sampled_struct, samples_struct
from ...kernels.stepping.surface_contact import surface_contact_kernel
from ..layout import lanes_view
from ..sheet_model import SheetModel
from ..state import SheetState
from .friction import set_friction


class SurfaceContact:
    """Launches the contact at the samples of one sheet, on one state.

    Args:
        sheet: with samples.
        own: its state.
        reaction: forces of its blocks of elements on its tools, [tool, block] [N].
        moment: of these about the pivots of the tools, [tool, block] [N m]; None where no tool is carried.

    Attributes:
        kernel: that is launched.
        samples, laws, sampled: its arguments.
        works: of the last steps, as [row, block of samples] of lanes [J].
    """

    def __init__(self, sheet: SheetModel, own: SheetState, reaction: wp.array, moment: wp.array | None) -> None:
        self.kernel = surface_contact_kernel(sheet.real, sheet.lane_count, sheet.node_traits)
        self._sheet, self._own = sheet, own
        self.laws = sheet.node_laws()
        self.laws.spare_distance = sheet.samples.spare_distance
        self.samples, self.sampled = device_samples(sheet), _sampled(sheet, own, reaction, moment)
        self.works = lanes_view(own.sample_work, sheet.lane_count)

    def launch(self, first: int, count: int | None, around: Any) -> None:
        """Add the forces to those of the elements, in ``count`` blocks from ``first``."""
        sheet = self._sheet
        wp.launch(
            self.kernel,
            dim=sheet.element_count // sheet.lane_count if count is None else count,
            inputs=[first, self.samples, self.laws, around, self._own.moved, self._own.motion],
            outputs=[self._own.corner_force, self.sampled],
            device=sheet.device,
            block_dim=block_size(self.kernel, sheet.device),
        )


def device_samples(sheet: SheetModel) -> Any:
    """Constants of the samples of a sheet, as a new struct."""
    lane_count, block_count = sheet.lane_count, sheet.element_count // sheet.lane_count
    order = np.arange(sheet.element_count, dtype=np.int32)
    order[: sheet.blank.element_count] = sheet.samples.order
    mass = np.zeros(sheet.element_count)
    mass[: sheet.blank.element_count] = sheet.samples.mass
    nodes = sheet.element_nodes[:, order]

    def lanes(values: np.ndarray, dtype: type) -> wp.array:
        return lanes_view(wp.array(np.ascontiguousarray(values), dtype=dtype, device=sheet.device), lane_count)

    samples = samples_struct(sheet.real, lane_count)()
    samples.corner_node = lanes(sheet.motion_layout.entry(0, nodes).astype(np.int32), wp.int32)
    samples.node_stride = sheet.motion_layout.stride
    samples.element = lanes(sheet.corners.entry(0, order).astype(np.int32), wp.int32)
    samples.corner_stride = sheet.corners.stride
    samples.place = wp.array(sheet.samples.places, dtype=wp.vec2d, device=sheet.device)
    samples.block_count, samples.lever = block_count, sheet.geometry.largest_size
    samples.allowance = sheet.samples.allowance
    samples.mass = lanes(mass[order], sheet.real)
    corners = (nodes // lane_count).reshape(4, block_count, lane_count).swapaxes(0, 1)
    around = [np.unique(blocks) for blocks in corners]
    width = max(map(len, around))
    table = np.array([np.pad(blocks, (0, width - len(blocks)), mode="edge") for blocks in around], dtype=np.int32)
    samples.node_block = wp.array(np.ascontiguousarray(table.T), dtype=wp.int32, device=sheet.device)
    return samples


def _sampled(sheet: SheetModel, own: SheetState, reaction: wp.array, moment: wp.array | None) -> Any:
    """What the samples of a sheet write."""
    lane_count = sheet.lane_count
    touch = touch_struct(sheet.real, lane_count)()
    touch.friction = sheet.samples.layout.view(own.sample_friction)
    touch.gap, touch.reaction = own.sample_gap, own.sample_reaction
    if moment is not None:
        count = sheet.tool_count
        touch.reaction, touch.moment = own.sample_reaction[:count], own.sample_reaction[count:]
    touch.depth, touch.thickness = (lanes_view(a, lane_count) for a in (own.sample_depth, own.sample_thickness))
    set_friction(touch, sheet, own.sample_friction_argument, samples=True)
    sampled = sampled_struct(sheet.real, lane_count)()
    sampled.touch, sampled.reaction = touch, reaction
    if moment is not None:
        sampled.moment = moment
    sampled.memory, sampled.works = (lanes_view(a, lane_count) for a in (own.sample_memory, own.sample_work))
    return sampled
