"""Constants of a sheet as facets on which nodes stand: made once, for all passes that it takes part in."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import warp as wp

from ...kernels.plies.facet import FREE_EDGE, facets_struct
from ...kernels.rows import GradientRow
from ..sheet_model import SheetModel
from .connectivity import edge_neighbours, free_edge_distance, home_elements, rings
from .groups import compact_groups
from .normals import normal_layout


class FacetTables:
    """Tables of one sheet on the device; each is made when it is first asked for.

    Args:
        sheet: constants of the sheet.

    Attributes:
        sheet: as given.
    """

    def __init__(self, sheet: SheetModel) -> None:
        self.sheet = sheet

    def facets(self, motion: wp.array, normals: wp.array):
        """Facets, as a new struct, on the motion and the normals of one state of the sheet."""
        facets = facets_struct(self.sheet.real)()
        facets.corner, facets.normal_corner, facets.neighbour, facets.warp_gradient = self._arrays
        facets.motion, facets.stride = motion, self.sheet.motion_layout.stride
        facets.normals, facets.normal_stride = normals, normal_layout(self.sheet).stride
        facets.flat = self.flat
        return facets

    @cached_property
    def flat(self) -> wp.array:
        """Flat coordinates of the nodes [m], and 1 behind those on a free edge, laid out as the normals."""
        sheet, layout = self.sheet, normal_layout(self.sheet)
        rows, count = np.zeros((layout.row_count, sheet.node_count)), sheet.blank.node_count
        rows[:2, :count] = sheet.blank.material_coordinates.T
        rows[3, :count] = self.on_edge
        return wp.array(layout.flat(rows), dtype=sheet.real, device=sheet.device)

    @cached_property
    def edge_distance(self) -> np.ndarray:
        """Distance of every node of the flat blank from a free edge, (node_count,) [m]."""
        return free_edge_distance(self.sheet.blank, self.sheet.symmetry)

    @cached_property
    def on_edge(self) -> np.ndarray:
        """Which nodes lie on a free edge, (node_count,) bool."""
        return self.edge_distance == 0.0

    @cached_property
    def home(self) -> wp.array:
        """An element beside every node, (node blocks,) of lanes of int32."""
        home = np.zeros(self.sheet.node_count, dtype=np.int32)
        home[: self.sheet.blank.node_count] = home_elements(self.sheet.blank)
        lanes = home.reshape(-1, self.sheet.lane_count)
        return wp.array(lanes, dtype=self.sheet.types.indices, device=self.sheet.device)

    @cached_property
    def ring(self) -> wp.array:
        """Facets that share a node with each, itself first, (element_count, k) int32; -1 where none."""
        return self._integers(rings(self.sheet.blank.quads))

    @cached_property
    def groups(self) -> wp.array:
        """Facets that lie together on the flat blank, (place, group) int32; -1 where a group has fewer."""
        blank = self.sheet.blank
        return self._integers(compact_groups(blank.material_coordinates[blank.quads].mean(axis=1)))

    @cached_property
    def _arrays(self) -> tuple[wp.array, ...]:
        """Corners, those among the normals, neighbours and gradients along the warp."""
        sheet, count = self.sheet, self.sheet.blank.element_count
        neighbours = np.full((sheet.element_count, 4), int(FREE_EDGE), dtype=np.int32)
        neighbours[:count] = edge_neighbours(sheet.blank, sheet.symmetry)
        gradient = np.zeros((2, sheet.element_count))
        gradient[:, :count] = sheet.geometry.gradient[[GradientRow.bp1, GradientRow.bq1]]
        return (
            self._integers(sheet.motion_layout.entry(0, sheet.element_nodes).T.ravel()),
            self._integers(normal_layout(sheet).entry(0, sheet.element_nodes).T.ravel()),
            self._integers(neighbours),
            wp.array(gradient, dtype=sheet.real, device=sheet.device),
        )

    def _integers(self, values: np.ndarray) -> wp.array:
        return wp.array(np.ascontiguousarray(values), dtype=wp.int32, device=self.sheet.device)
