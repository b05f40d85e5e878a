"""Constants of the interior edges of a sheet that touches itself, whose creases may meet."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from ...kernels.creases.data import edges_struct
from ...process.self_contact import SelfContact
from ..layout import slots_of_nodes
from ..plies.connectivity import free_edge_nodes, turning_way
from ..plies.groups import compact_groups
from ..plies.pass_model import PassModel
from ..sheet_model import TANGENTIAL_RATIO

# Share of the length of an edge by which the next one takes over; none at free edges and symmetry planes.
OVERLAP, NO_OVERLAP = 0.1, 1.0e-6
# Entries of all lists: for every edge of small sheets, and of large ones, where few are creases.
ENTRIES_PER_EDGE, EDGES_OF_SMALL_SHEETS, ENTRIES_PER_EDGE_OF_LARGE_SHEETS = 32, 4096, 4


class CreaseModel:
    """Constants of the contact of the creases of one sheet.

    Args:
        own_pass: the first pass of the sheet on itself, whose law, search and ledger they share.

    Attributes:
        nodes: ends of every edge, then the two other nodes of either facet, (edge_count, 6).
        stiffness: of a pair with an edge that is not lighter, (edge_count,) [N/m].
        entry_count: room for entries of all lists.
        around: twice the edge, and its end, for every node, (slots, node_count) int32; -1 for none.
    """

    def __init__(self, own_pass: PassModel) -> None:
        self.own_pass, self.sheet = own_pass, own_pass.slave
        self.real, self.device = own_pass.real, own_pass.device
        sheet, contact = self.sheet, own_pass.interface
        assert isinstance(contact, SelfContact)
        self.nodes = interior_edges(sheet.blank.quads, sheet.blank.material_coordinates)
        ends = self.nodes[:, :2]
        # the reduced mass of four equal nodes, where two edges cross in their middles, is that of one; half of it
        # leaves room for several contacts of an edge
        lightest = np.asarray(sheet.node_mass)[ends].min(axis=1) if len(ends) else np.zeros(0)
        self.stiffness = 0.5 * contact.stiffness_share / own_pass.reference_step**2 * lightest
        self.edge_count = len(self.nodes)
        large = ENTRIES_PER_EDGE_OF_LARGE_SHEETS * self.edge_count
        self.entry_count = max(ENTRIES_PER_EDGE * min(self.edge_count, EDGES_OF_SMALL_SHEETS), large)
        self.around = _around(ends, sheet.blank.node_count)

    def edges(self, motion: wp.array) -> Any:
        """The edges, as a new struct, on the motion of one state."""
        edges, sheet, own, flat = edges_struct(self.real)(), self.sheet, self.own_pass, self.sheet.blank
        edges.entry = self.integers(sheet.motion_layout.entry(0, self.nodes).T)
        ends = flat.material_coordinates[self.nodes[:, :2]].reshape(-1, 4)
        edges.flat = wp.array(ends, dtype=wp.types.vector(4, self.real), device=self.device)
        edges.stiffness = self._numbers(self.stiffness)
        edges.overlap = self._numbers(self._overlap())
        edges.motion, edges.stride, edges.edge_count = motion, sheet.motion_layout.stride, self.edge_count
        edges.thickness, edges.squared_exclusion = own.thickness, own.squared_exclusion
        edges.turning = turning_way(flat)
        law = own.law()
        edges.damping_time, edges.tangential_ratio = law.damping_time, TANGENTIAL_RATIO
        edges.coefficient = law.friction.coefficient
        return edges

    def _overlap(self) -> np.ndarray:
        """Of both ends of every edge, (2, edge_count)."""
        blank, symmetry = self.sheet.blank, self.sheet.symmetry
        last = np.zeros(blank.node_count, dtype=bool)
        last[free_edge_nodes(blank, symmetry)] = True
        for plane in symmetry.planes:
            last[symmetry.held_nodes(blank, plane)] = True
        return np.where(last[self.nodes[:, :2]], NO_OVERLAP, OVERLAP).T

    def integers(self, values: np.ndarray) -> wp.array:
        """On the device."""
        return wp.array(np.ascontiguousarray(values), dtype=wp.int32, device=self.device)

    def _numbers(self, values: np.ndarray) -> wp.array:
        return wp.array(np.ascontiguousarray(values), dtype=self.real, device=self.device)


def interior_edges(quads: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Edges between two elements, those that lie together on the flat blank one after the other.

    Args:
        quads: (element_count, 4).
        flat: coordinates of the nodes on the flat blank, (node_count, 2) [m].

    Returns:
        Both ends, then of either element the node beside the first end and that beside the second, (edge_count, 6).
    """
    corners = np.stack([np.roll(quads, -k, axis=1) for k in range(4)], axis=-1).reshape(-1, 4)
    ordered = np.sort(corners[:, :2], axis=1)
    edges, edge, count = np.unique(ordered, axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(edge.ravel(), kind="stable")
    begin = np.concatenate([[0], np.cumsum(count)[:-1]])[count == 2]
    found = [edges[count == 2]]
    for shift in range(2):
        own = corners[order[begin + shift]]
        # an element goes along an edge from its corner 0 to 1: corner 3 is beside 0, and 2 beside 1
        forward = (own[:, 0] == found[0][:, 0])[:, None]
        found.append(np.where(forward, own[:, [3, 2]], own[:, [2, 3]]))
    nodes = np.concatenate(found, axis=1)
    if not len(nodes):
        return nodes
    groups = compact_groups(flat[nodes[:, :2]].mean(axis=1)).T.ravel()
    return nodes[groups[groups >= 0]]


def _around(ends: np.ndarray, node_count: int) -> np.ndarray:
    node, code = ends.ravel(), np.arange(ends.size)
    order, slot = slots_of_nodes(node)
    result = np.full((int(slot.max(initial=0)) + 1, node_count), -1, dtype=np.int32)
    result[slot, node[order]] = code[order]
    return result
