"""A sheet that meets its mirror image at a symmetry plane: constants."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp

from ...kernels.plies.mirror import mirror_struct
from ...kernels.plies.within import LEAST_COSINE
from ...process.self_contact import EXCLUDED_THICKNESSES, SelfContact
from ...sheet.symmetry import AXES
from ..sheet_model import SheetModel
from .connectivity import distance_from
from .facet_tables import FacetTables
from .normals import normal_layout
from .pass_model import PassModel, PassPlace, mean_density, mean_facet_area, nodal_areas

# Least cosine of nodes that never touch their image.
NEVER_FACING = 2.0


class MirrorModel(PassModel):
    """Constants of one face of a sheet before a symmetry plane: ``PassModel`` with the plane in place of facets.

    The plane is where the sheet touches its image, half a thickness away. It does not give way, so that the stiffness
    is that of two sheets of which the other is held.

    Attributes:
        least_cosine: between normal and plane's axis, (node_count,).
    """

    def __init__(
        self,
        place: PassPlace,
        contact: SelfContact,
        tables: FacetTables,
        damping_ratio: float,
        reference_step: float,
    ) -> None:
        super().__init__(place, contact, tables, tables, damping_ratio, reference_step)
        sheet = self.slave
        self.axis = AXES[place.plane]
        self.thickness *= 0.5
        self.reduced_density = mean_density(sheet)
        self.area_stiffness = contact.stiffness_share * self.reduced_density / reference_step**2
        self.stiffness = self.area_stiffness * nodal_areas(sheet)
        self.least_cosine = self._least_cosine()
        self.slot_count = 1

    def _least_cosine(self) -> np.ndarray:
        """As between nodes and facets of a sheet: none of neighbours, and free edges may stand edge-on."""
        sheet = self.slave
        blank = sheet.blank
        flat = blank.material_coordinates
        apart = 2.0 * distance_from(flat, flat[sheet.symmetry.held_nodes(blank, self.place.plane)])
        thickness = sheet.fabric.thickness
        least = np.full(blank.node_count, float(LEAST_COSINE))
        far = apart > EXCLUDED_THICKNESSES * thickness + 2.0 * np.sqrt(mean_facet_area(sheet))
        least[self.on_edge & far] = 0.0
        least[apart <= EXCLUDED_THICKNESSES * thickness] = NEVER_FACING
        return least

    def mirror(self, motion: wp.array, normals: wp.array) -> Any:
        """The plane and the nodes before it, as a new struct, on the motion and the normals of one state."""
        mirror, sheet = mirror_struct(self.real, self.lane_count)(), self.slave
        mirror.axis, mirror.facing, mirror.distance = self.axis, float(self.place.facing), self.thickness
        mirror.side = float(np.sign(sheet.blank.node_position[:, self.axis].sum()) or 1.0)
        mirror.damping_time = self.law().damping_time
        mirror.stiffness, mirror.least = self._lanes(self.stiffness, 0.0), self._lanes(self.least_cosine, NEVER_FACING)
        mirror.normals, mirror.motion = normal_layout(sheet).view(normals), sheet.motion_layout.view(motion)
        return mirror

    def _lanes(self, values: np.ndarray, rest: float) -> wp.array:
        padded = np.full(self.slave.node_count, rest)
        padded[: len(values)] = values
        return wp.array(padded.reshape(-1, self.lane_count), dtype=self.types.lanes, device=self.device)


def mirror_places(interface: int, sheet: int, model: SheetModel, first_slot: int) -> list[PassPlace]:
    """Passes of both faces of a sheet at each of its symmetry planes."""
    faces = [(plane, facing) for plane in model.symmetry.planes for facing in (1, -1)]
    return [
        PassPlace(interface, sheet, sheet, 1, False, 1.0, first_slot + number, facing, plane)
        for number, (plane, facing) in enumerate(faces)
    ]
