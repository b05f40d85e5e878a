"""Constants of the samples at which a sheet meets its tools between the nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...sheet.geometry import ElementGeometry
from ...sheet.samples import FEWEST_PER_SIDE, sample_motion, sample_places, samples_per_side
from ...tools.tool import Tool
from ..layout import RowLayout
from .order import compact_order, window

# Stiffness of all samples over that of the nodes: where tools are blunt nodes carry the sheet, and where one is sharp a
# sample does.
BLUNT_SHARE, SHARP_SHARE = 0.25, 1.0
# Of the thickness: margin of the distance before contact, for the rounding of positions and distances.
SPARE_DISTANCE = 0.002


@dataclass(frozen=True)
class Samples:
    """Samples of one sheet.

    Attributes:
        places: of the samples of an element, (samples of an element, 2) from -1 to 1; none where only nodes meet tools.
        count: samples of all elements, with padding.
        layout: of their friction springs.
        mass: share of each element's mass that is on the contact spring of one of its samples, (element_count,) [kg].
        stiffness: of that spring, (element_count,) [N/m].
        frequency: largest squared frequency of all samples by motions of the corners, with one tool [1/s^2].
        turning: the same by turns of the directors, times the squared radius of their inertia [m^2/s^2].
        order: the elements as their samples lie in memory, (element_count,).
        slot: where those of each element lie, (element_count,).
        window: blocks of elements that neither tiles nor threads divide, see ``compact_order``.
        allowance: depth in a tool from which they push [m].
        spare_distance: see ``SPARE_DISTANCE`` [m].
    """

    places: np.ndarray
    count: int
    layout: RowLayout
    mass: np.ndarray
    stiffness: np.ndarray
    frequency: float
    turning: float
    order: np.ndarray
    slot: np.ndarray
    window: int
    allowance: float
    spare_distance: float

    @classmethod
    def of(
        cls,
        tools: tuple[Tool, ...],
        thickness: float,
        allowance: float,
        geometry: ElementGeometry,
        corners: np.ndarray,
        mass: np.ndarray,
        contact_frequency: float,
        corner_layout: RowLayout,
    ) -> Samples:
        """Samples for some tools.

        Args:
            tools: that are met between nodes; none of them, no samples.
            thickness: of the sheet [m].
            allowance: depth in a tool from which samples push, over the thickness.
            geometry: of its elements.
            corners: of them, (element_count, 4, 3) [m].
            mass: of them, (element_count,) [kg].
            contact_frequency: squared, of a node on its spring [1/s^2].
            corner_layout: of what elements write at their corners.
        """
        side_count, sway, turning = 0, 0.0, 0.0
        if tools:
            sharpest = min(min(tool.fillet_radius, 0.5 * tool.smallest_width) for tool in tools)
            side_count = samples_per_side(geometry.largest_size, sharpest + 0.5 * thickness)
        # with an allowance samples push only where nodes do not carry the sheet
        share = SHARP_SHARE if side_count > FEWEST_PER_SIDE or allowance > 0.0 else BLUNT_SHARE
        places = sample_places(side_count)
        if tools:
            sway, turning = sample_motion(corners, places)
        own = share / max(len(places), 1) * mass
        largest = share * contact_frequency
        own_window, order = 1, np.arange(len(corners))
        if tools:
            own_window = window(len(corners), corner_layout.lane_count)
            order = compact_order(corners.mean(axis=1), own_window)
        layout = RowLayout(3 * max(len(tools), 1), len(places) * corner_layout.length, corner_layout.lane_count)
        return cls(
            places, layout.length, layout, own, contact_frequency * own, largest * sway, largest * turning,
            order, np.argsort(order), own_window, allowance * thickness, SPARE_DISTANCE * thickness,
        )  # fmt: skip
