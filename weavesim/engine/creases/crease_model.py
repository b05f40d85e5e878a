"""Constants of the edges of a sheet that touches itself, of which creases and free edges may meet."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from ...kernels.creases.data import edges_struct
from ...kernels.plies.facet import FREE_EDGE
from ...process.self_contact import SelfContact
from ...sheet.blank import Blank
from ...sheet.symmetry import Symmetry
from ..layout import slots_of_nodes
from ..plies.connectivity import edge_neighbours, turning_way
from ..plies.groups import compact_groups
from ..plies.pass_model import PassModel
from ..sheet_model import TANGENTIAL_RATIO

# Share of the length of an edge by which the next one takes over; none where a crease ends at a free edge or a symmetry
# plane, and where a free edge turns by more than 30 degrees.
OVERLAP, NO_OVERLAP = 0.1, 1.0e-6
LEAST_COSINE_OF_NEXT = 0.866
# Entries of all lists: for every edge of small sheets, and of large ones, where few are creases.
ENTRIES_PER_EDGE, EDGES_OF_SMALL_SHEETS, ENTRIES_PER_EDGE_OF_LARGE_SHEETS = 32, 4096, 4


class CreaseModel:
    """Constants of the contact of the creases of one sheet, and of its free edges.

    Args:
        own_pass: the first pass of the sheet on itself, whose law, search and ledger they share.

    Attributes:
        nodes: ends of every edge, then the two other nodes of either facet, (edge_count, 6); of free edges, which come
            first, the ends in place of the second facet.
        free_count: how many of them are free.
        stiffness: of a pair with an edge that is not lighter, (edge_count,) [N/m].
        entry_count: room for entries of all lists.
        around: twice the edge, and its end, for every node, (slots, node_count) int32; -1 for none.
    """

    def __init__(self, own_pass: PassModel) -> None:
        self.own_pass, self.sheet = own_pass, own_pass.slave
        self.real, self.device = own_pass.real, own_pass.device
        sheet, contact = self.sheet, own_pass.interface
        assert isinstance(contact, SelfContact)
        free = free_edges(sheet.blank, sheet.symmetry)
        self.free_count = len(free)
        self.nodes = np.concatenate([free, interior_edges(sheet.blank.quads, sheet.blank.material_coordinates)])
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
        edges.motion, edges.stride = motion, sheet.motion_layout.stride
        edges.edge_count, edges.free_count = self.edge_count, self.free_count
        edges.thickness, edges.squared_exclusion = own.thickness, own.squared_exclusion
        edges.turning = turning_way(flat)
        law = own.law()
        edges.damping_time, edges.tangential_ratio = law.damping_time, TANGENTIAL_RATIO
        edges.coefficient = law.friction.coefficient
        return edges

    def _overlap(self) -> np.ndarray:
        """Of both ends of every edge, (2, edge_count)."""
        blank, symmetry, free = self.sheet.blank, self.sheet.symmetry, self.nodes[: self.free_count, :2]
        last = np.zeros(blank.node_count, dtype=bool)
        last[free] = True
        for plane in symmetry.planes:
            last[symmetry.held_nodes(blank, plane)] = True
        ends = last[self.nodes[:, :2]]
        ends[: self.free_count] = ~goes_on(free, blank.material_coordinates)[free]
        return np.where(ends, NO_OVERLAP, OVERLAP).T

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
    return _side_by_side(np.concatenate(found, axis=1), flat)


def free_edges(blank: Blank, symmetry: Symmetry) -> np.ndarray:
    """Edges of one element, but for those on symmetry planes; those that lie together one after the other.

    Returns:
        Both ends, the node of the element beside the first and that beside the second, and both ends, (k, 6).
    """
    element, edge = np.nonzero(edge_neighbours(blank, symmetry) == int(FREE_EDGE))
    corners = np.stack([blank.quads[element, (edge + k) % 4] for k in (0, 1, 3, 2, 0, 1)], axis=-1)
    return _side_by_side(corners, blank.material_coordinates)


def _side_by_side(edges: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Edges, with both ends first, (k, 6), those that lie together on the flat blank one after the other."""
    groups = compact_groups(flat[edges[:, :2]].mean(axis=1)).T.ravel()
    return edges[groups[groups >= 0]]


def goes_on(ends: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Nodes at which one free edge goes on in another, about straight, (node_count,) bool.

    Args:
        ends: of the free edges, as they go around their elements, (k, 2).
        flat: coordinates of the nodes on the flat blank, (node_count, 2) [m].
    """
    along = flat[ends[:, 1]] - flat[ends[:, 0]]
    along = along / np.linalg.norm(along, axis=1)[:, None]
    arriving, leaving = np.zeros((2, len(flat), 2))
    arriving[ends[:, 1]], leaving[ends[:, 0]] = along, along
    once = np.bincount(ends.ravel(), minlength=len(flat)) == 2
    return once & ((arriving * leaving).sum(axis=1) > LEAST_COSINE_OF_NEXT)


def _around(ends: np.ndarray, node_count: int) -> np.ndarray:
    node, code = ends.ravel(), np.arange(ends.size)
    order, slot = slots_of_nodes(node)
    result = np.full((int(slot.max(initial=0)) + 1, node_count), -1, dtype=np.int32)
    result[slot, node[order]] = code[order]
    return result
