"""Constants of one pass of an interface: the nodes of one sheet on the facets of another."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import warp as wp

from ...kernels.contact.friction import friction_law_struct
from ...kernels.plies.data import UNSOUGHT, contact_law_struct, slaves_struct
from ...kernels.plies.own_search import SLOT_COUNT
from ...kernels.plies.search import search_struct
from ...kernels.rows import PLY_RECORD_LENGTH, PlyRow
from ...process.friction import Friction
from ...process.friction_device import argument_kind, carried_rate, viscous_rates, viscous_share
from ...process.interfaces import Interface
from ...process.self_contact import EXCLUDED_THICKNESSES, SelfContact
from ..layout import RowLayout
from ..sheet_model import REFRESH_INTERVAL, TANGENTIAL_RATIO, SheetModel
from .connectivity import distance_from, free_edge_nodes
from .facet_tables import FacetTables
from .feet import Feet, find_feet
from .normals import normal_layout

# Nodes within this share of an element's size of a facet are listed with it.
SKIN_SHARE = 0.3
# Coordinates up to which feet may lie beyond a free edge: rounding between plies, and at most within a sheet.
FARTHEST_OF_PLIES = 1.001
LARGEST_FARTHEST = 1.85
# Slots of a list of candidates, over the mean number of nodes within its box.
SPARE_SLOTS = 3.0


@dataclass(frozen=True)
class PassPlace:
    """Which sheets of a run a pass joins.

    Attributes:
        interface: index among the interfaces of the run.
        slave, master: indices of the sheets whose nodes stand on the facets of the other.
        side: 1 if the nodes lie above the facets, -1 if below.
        is_first: whether it is the first pass of the slave sheet.
        share: of the interface's stiffness.
        slot: within a sheet, which pair of faces meets there: see kernels/plies/own_search.py; -1 between sheets.
        facing: within a sheet, 1 if the nodes' normals point along those of the facets, else -1; 0 between sheets.
        plane: of symmetry, "x" or "y", at which a sheet meets its mirror image (``MirrorModel``); "" without.
    """

    interface: int
    slave: int
    master: int
    side: int
    is_first: bool
    share: float
    slot: int = -1
    facing: int = 0
    plane: str = ""


class PassModel:
    """Constants of one pass.

    Args:
        place: which sheets it joins.
        interface: of which it is a pass, or the contact of a sheet with itself.
        slave_tables, master_tables: of both sheets, with their constants.
        damping_ratio: normal dashpot as a share of critical.
        reference_step: of the run [s].

    Attributes:
        rows: layout of PlyRow.
        stiffness: normal spring of every node, (node_count,) [N/m].
        area_stiffness: of both passes together, per area [Pa/m].
        thickness: distance of the mid-surfaces at which the plies touch [m].
        slot_count: slots of the list of candidates of a facet.
    """

    def __init__(
        self,
        place: PassPlace,
        interface: Interface | SelfContact,
        slave_tables: FacetTables,
        master_tables: FacetTables,
        damping_ratio: float,
        reference_step: float,
    ) -> None:
        self.place, self.interface, self._own_facets, self._facets = place, interface, slave_tables, master_tables
        slave, master = slave_tables.sheet, master_tables.sheet
        self.slave, self.master = slave, master
        self.device, self.real, self.types, self.lane_count = slave.device, slave.real, slave.types, slave.lane_count
        self.damping_ratio, self.reference_step = damping_ratio, reference_step
        self.rows = RowLayout(PlyRow.row_count(), slave.node_count, self.lane_count, PLY_RECORD_LENGTH)
        self.thickness = 0.5 * (slave.fabric.thickness + master.fabric.thickness)
        densities = [mean_density(sheet) for sheet in (slave, master)]
        self.reduced_density = densities[0] * densities[1] / sum(densities)
        self.area_stiffness = interface.stiffness_share * self.reduced_density / reference_step**2
        area, own_area = mean_facet_area(master), mean_facet_area(slave)
        # one ratio for all nodes: those on a symmetry plane have half an area, as half of a whole node has
        smaller = min(1.0, area / own_area) * nodal_areas(slave)
        self.stiffness = self._edge_shares(place.share) * self.area_stiffness * smaller
        self.skin = SKIN_SHARE * math.sqrt(area)
        if self.is_own:
            self.skin = max(self.skin, self.thickness)
        self.squared_exclusion = (EXCLUDED_THICKNESSES * self.thickness) ** 2
        self.squared_edge_distance = (EXCLUDED_THICKNESSES * self.thickness + 2.0 * math.sqrt(area)) ** 2
        box = (math.sqrt(area) + 2.0 * self.skin) ** 2
        self.slot_count = min(math.ceil(SPARE_SLOTS * (box / own_area + 1.0)), slave.node_count)
        if not self.is_own:
            # lists are made from those of the facets around: between two of them, no node passes a whole facet
            self.skin = min(self.skin, least_width(master))

    @property
    def is_own(self) -> bool:
        """Whether a sheet meets itself."""
        return self.place.slot >= 0

    @property
    def farthest(self) -> float:
        """Coordinate up to which a foot may lie beyond a free edge of its facet.

        A sheet's edge is as round as the sheet is thick. Edges of a fold lie on each other, and would slip past each
        other without that; those of plies in a stack do not meet.
        """
        if not self.is_own:
            return FARTHEST_OF_PLIES
        return min(LARGEST_FARTHEST, 1.0 + self.thickness / math.sqrt(mean_facet_area(self.master)))

    @property
    def name(self) -> str:
        """For outputs."""
        return contact_name(self.interface, self.slave.name)

    def _edge_shares(self, share: float) -> np.ndarray:
        """Share of every node: at least a half near a free edge of either sheet, where both passes are needed.

        Of the other sheet's edge, where it is at the start counts: a share that changed in contact would be a jump.
        """
        size = math.sqrt(mean_facet_area(self.slave))
        band = max(size, 2.0 * self.thickness)
        distance = self._own_facets.edge_distance
        if not self.is_own:
            blank = self.master.blank
            edge = blank.node_position[free_edge_nodes(blank, self.master.symmetry)]
            distance = np.minimum(distance, distance_from(self.slave.blank.node_position, edge))
        near = np.clip((band + size - distance) / size, 0.0, 1.0)
        return share + (max(share, 0.5) - share) * near

    @property
    def on_edge(self) -> np.ndarray:
        """Which nodes lie on a free edge of their sheet, (node_count,) bool."""
        return self._own_facets.on_edge

    # --- device constants --------------------------------------------------------------------------------------------

    def facets(self, motion: wp.array, normals: wp.array):
        """Facets under the nodes, as a new struct, on the motion and the normals of one state of their sheet."""
        return self._facets.facets(motion, normals)

    def slaves(self, motion: wp.array, normals: wp.array):
        """Nodes of the pass, as a new struct, on the motion and the normals of one state of their sheet."""
        slaves = slaves_struct(self.real, self.lane_count)()
        slaves.stiffness, slaves.home = self._device_stiffness, self._own_facets.home
        slaves.facets = self._own_facets.facets(motion, normals)
        slaves.is_first = int(self.place.is_first)
        layout = normal_layout(self.slave)
        slaves.normals, slaves.flat = layout.view(normals), layout.view(self._own_facets.flat)
        slaves.facing, slaves.squared_exclusion = float(self.place.facing), self.squared_exclusion
        slaves.squared_edge_distance = self.squared_edge_distance
        return slaves

    @cached_property
    def _device_stiffness(self) -> wp.array:
        stiffness = np.zeros(self.slave.node_count)
        stiffness[: len(self.stiffness)] = self.stiffness
        lanes = stiffness.reshape(-1, self.lane_count)
        return wp.array(lanes, dtype=self.types.lanes, device=self.device)

    def law(self):
        """Contact law, as a new struct."""
        law = contact_law_struct(self.real)()
        law.side, law.thickness, law.farthest = float(self.place.side), self.thickness, self.farthest
        law.area_stiffness, law.tangential_ratio = self.area_stiffness, TANGENTIAL_RATIO
        # c = 2 zeta sqrt(k m) of the relative motion, whose squared frequency is that share of 1/step^2
        law.damping_time = 2.0 * self.damping_ratio * self.reference_step / math.sqrt(self.interface.stiffness_share)
        law.friction = self._friction()
        return law

    def _friction(self):
        friction, law = self.interface.friction, friction_law_struct(self.real)()
        argument, coefficient = friction.table()
        law.argument_kind = argument_kind(friction)
        law.argument = wp.array(argument, dtype=self.real, device=self.device)
        law.coefficient = wp.array(coefficient, dtype=self.real, device=self.device)
        law.viscosity, law.film = viscous_rates(friction, self._carried_rate)
        return law

    @property
    def _carried_rate(self) -> float:
        return carried_rate(self.reduced_density, self.reference_step)

    @property
    def viscous_share(self) -> float:
        """Share of the viscosity that the time step can carry: 1, or less where it is reduced."""
        return self.carried_share(self.interface.friction)

    def carried_share(self, friction: Friction) -> float:
        """The same of another law, which a stage gives the contact."""
        return viscous_share(friction, self._carried_rate)

    def search(self):
        """Constants of the search, as a new struct."""
        search = search_struct(self.real)()
        search.skin, search.thickness, search.steps = self.skin, self.thickness, REFRESH_INTERVAL
        search.facet_count, search.slot = self.master.blank.element_count, self.place.slot
        search.ring = self._facets.ring
        # within a sheet, nodes without a foot are sought by ``OwnSearch``
        search.group = wp.empty((0, 0), dtype=wp.int32, device=self.device) if self.is_own else self._facets.groups
        return search

    @cached_property
    def feet(self) -> Feet:
        """Feet of the nodes at the start; within a sheet, the first search finds them."""
        if self.is_own:
            count = self.slave.blank.node_count
            none = np.zeros(count)
            return Feet(none.astype(np.int32), none, none, none, np.full(count, float(UNSOUGHT)))
        master = self.master.blank
        points = self.slave.blank.node_position
        return find_feet(points, master.node_position, master.initial_director, master.quads, self.thickness)


def contact_name(contact: Interface | SelfContact, sheet: str) -> str:
    """Of an interface, or of the contact of a sheet with itself, for outputs."""
    return f"interface {contact.name}" if isinstance(contact, Interface) else f"self-contact of {sheet}"


def nodal_areas(sheet: SheetModel) -> np.ndarray:
    """Area of the flat sheet around every node, (node_count,) [m^2]."""
    area = np.zeros(sheet.blank.node_count)
    np.add.at(area, sheet.blank.quads.ravel(), np.repeat(0.25 * sheet.geometry.area, 4))
    return area


def mean_facet_area(sheet: SheetModel) -> float:
    """Area around a node within the flat sheet, on the mean, which is that of its elements [m^2]."""
    return float(np.mean(sheet.geometry.area))


def least_width(sheet: SheetModel) -> float:
    """Smallest width of an element of the flat sheet: its area over its longest side [m]."""
    corner = sheet.blank.material_coordinates[sheet.blank.quads]
    side = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max(axis=1)
    return float((sheet.geometry.area / side).min())


def mean_density(sheet: SheetModel) -> float:
    """Areal density with the added mass, of the whole sheet [kg/m^2]."""
    return float(sheet.node_mass.sum() / sheet.geometry.area.sum())


def pass_shares(interface: Interface, lower: SheetModel, upper: SheetModel) -> tuple[float, float]:
    """Shares of the stiffness of the passes of the upper nodes on the lower facets, and of the reverse.

    The finer sheet carries more: unequal meshes would otherwise press unevenly on its nodes.
    """
    fine, coarse = mean_facet_area(upper), mean_facet_area(lower)
    share = coarse**2 / (fine**2 + coarse**2)
    if interface.passes == "one":
        share = 1.0 if fine <= coarse else 0.0
    return share, 1.0 - share


def pass_places(interfaces: tuple[Interface, ...], sheets: tuple[SheetModel, ...]) -> list[PassPlace]:
    """Every pass of every interface of a run, in order."""
    names = [sheet.name for sheet in sheets]
    places: list[PassPlace] = []
    begun: set[int] = set()
    for index, interface in enumerate(interfaces):
        lower, upper = names.index(interface.lower), names.index(interface.upper)
        shares = pass_shares(interface, sheets[lower], sheets[upper])
        for slave, master, side, share in ((upper, lower, 1, shares[0]), (lower, upper, -1, shares[1])):
            if share > 0.0:
                places.append(PassPlace(index, slave, master, side, slave not in begun, share))
                begun.add(slave)
    return places


def own_pass_places(index: int, sheet: int, is_first: bool) -> list[PassPlace]:
    """Passes of a sheet on itself: nodes above or below the facets, turned against them or along."""
    return [
        PassPlace(index, sheet, sheet, (1, -1)[slot % 2], is_first and slot == 0, 0.5, slot, (-1, 1)[slot // 2])
        for slot in range(int(SLOT_COUNT))
    ]
