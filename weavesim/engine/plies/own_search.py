"""Search for the contact of one sheet with itself: tables, and launches of what all its passes share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import warp as wp

from ...kernels.plies.collect import GROUP, settle_own_search_kernel
from ...kernels.plies.own_search import (
    SLOT_COUNT,
    bound_groups_kernel,
    bounds_struct,
    found_struct,
    seek_own_facets_kernel,
    sheet_points_struct,
)
from ...kernels.stepping.step import group_maximum_kernel
from .connectivity import longest_edge, turning_way
from .groups import compact_groups, groups_that_hang_together, nodes_at_cuts, nodes_of
from .normals import normal_layout
from .pass_launches import group_count
from .pass_model import PassModel

# Groups hang together up to this much of the distance at which nodes are followed: for what moves between updates.
SPARE_REACH = 1.5


class OwnSearch:
    """Nearest facets of all nodes of a sheet on the sheet itself.

    Args:
        model: of one of the passes of the sheet on itself.
        motion: of its nodes, in one state.
        normals: of its nodes.
        entries: PassEntry of all of these passes.
        awake: int32 of that state: whether contact needs normals.

    Attributes:
        node_group_count, facet_group_count: groups that are compared.
        found: nearest facets, for the passes.
    """

    def __init__(
        self, model: PassModel, motion: wp.array, normals: wp.array, entries: Sequence[wp.array], awake: wp.array
    ) -> None:
        self._sheet, self._real, self._device = model.slave, model.real, model.device
        self._entries, self._awake = entries, awake
        blank = self._sheet.blank
        flat = blank.material_coordinates
        nodes, facets = compact_groups(flat), compact_groups(flat[blank.quads].mean(axis=1))
        facet_nodes = nodes_of(facets, blank.quads)
        self._nodes, self._facets = self._bounds(nodes, nodes), self._bounds(facets, facet_nodes)
        # edges touch up to half of their length away from their nodes
        self._facets.room = max(0.0, 0.5 * longest_edge(blank) - model.skin)
        cut = nodes_at_cuts(flat, model.on_edge, float(np.sqrt(np.mean(self._sheet.geometry.area))))
        reach = SPARE_REACH * (model.thickness + model.skin)
        hanging = groups_that_hang_together(nodes, facet_nodes, flat, reach, cut)
        self._points = self._sheet_points(model, motion, normals, hanging)
        self.node_group_count, self.facet_group_count = nodes.shape[1], facets.shape[1]
        self.found = self._make_found(self.node_group_count)
        count = group_count(self.node_group_count)
        self._largest = [wp.zeros(count, dtype=self._real, device=self._device) for _ in range(2)]

    def _sheet_points(self, model: PassModel, motion: wp.array, normals: wp.array, touching: np.ndarray) -> Any:
        sheet, points = self._sheet, sheet_points_struct(self._real)()
        node = np.arange(sheet.node_count)
        points.entry = self._integers(sheet.motion_layout.entry(0, node))
        points.normal_entry = self._integers(normal_layout(sheet).entry(0, node))
        points.facets = model.facets(motion, normals)
        points.touching = self._integers(touching)
        points.turning = turning_way(sheet.blank)
        points.thickness, points.skin, points.farthest = model.thickness, model.skin, max(1.1, model.farthest)
        points.squared_exclusion, points.squared_edge_distance = model.squared_exclusion, model.squared_edge_distance
        return points

    def _bounds(self, members: np.ndarray, nodes: np.ndarray) -> Any:
        bounds, count, vec3 = bounds_struct(self._real)(), members.shape[1], self._sheet.types.vec3
        bounds.member, bounds.node = self._integers(members), self._integers(nodes)
        for name in ("low", "high", "axis"):
            setattr(bounds, name, wp.zeros(count, dtype=vec3, device=self._device))
        bounds.spread = wp.zeros(count, dtype=self._real, device=self._device)
        return bounds

    def _make_found(self, node_group_count: int) -> Any:
        found, shape = found_struct(self._real)(), (int(SLOT_COUNT), self._sheet.node_count)
        found.facet = wp.full(shape, -1, dtype=wp.int32, device=self._device)
        for name in ("height", "xi", "eta"):
            setattr(found, name, wp.zeros(shape, dtype=self._real, device=self._device))
        for name in ("urgency", "far_urgency"):
            setattr(found, name, wp.zeros(node_group_count, dtype=self._real, device=self._device))
        return found

    def _integers(self, values: np.ndarray) -> wp.array:
        return wp.array(np.ascontiguousarray(values), dtype=wp.int32, device=self._device)

    def bound(self, nodes: tuple[int, int], facets: tuple[int, int]) -> None:
        """Boxes of groups of nodes and of facets, (first, count) each."""
        for (first, count), bounds in ((nodes, self._nodes), (facets, self._facets)):
            if count:
                inputs = [first, self._points, self._entries[0], bounds]
                wp.launch(bound_groups_kernel(self._real), dim=count, inputs=inputs, device=self._device)

    def seek(self, first: int, count: int) -> None:
        """Nearest facets of the nodes of ``count`` groups from ``first``."""
        if count:
            wp.launch(
                seek_own_facets_kernel(self._real),
                dim=count,
                inputs=[first, self._points, self._nodes, self._facets, self._entries[0]],
                outputs=[self.found],
                device=self._device,
            )

    def settle(self) -> None:
        """How far the sheet may move before it is searched again, and which passes have something to do."""
        for values, largest in zip((self.found.urgency, self.found.far_urgency), self._largest, strict=True):
            wp.launch(
                group_maximum_kernel(self._real, GROUP), dim=len(largest), inputs=[values], outputs=[largest],
                device=self._device,
            )  # fmt: skip
        wp.launch(
            settle_own_search_kernel(self._real), dim=1, inputs=self._largest, outputs=[*self._entries, self._awake],
            device=self._device,
        )  # fmt: skip
