"""Thickness and fibre content of the deformed sheet, from its change of area and the pressure at its crossovers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field

from ..checks import Parameters, Positive, Share
from ..ranges import Quantity

if TYPE_CHECKING:
    from .cell import UnitCell


class Compaction(Parameters):
    """t = t_0 J^-n / (1 + p/E_c), v_f = (fibre mass per area) / (fibre density t J).

    J is the area ratio, p the pressure between warp and weft, per reference area. A sheet whose area shrinks in shear
    thickens (n = 1: its fibre content stays constant; n = 0: its thickness stays constant and its fibres pack
    instead); yarns under tension flatten each other where they cross.
    """

    thickening: Share = Field(default=1.0, description="n, share of a loss of area that is converted to thickness")
    crossover_modulus: Annotated[Positive, Quantity("contact modulus")] | None = Field(
        default=None, description="E_c, pressure over relative flattening [Pa]; None uses that of the unit cell"
    )
    fibre_areal_density: Annotated[Positive, Quantity("areal density")] | None = Field(
        default=None, description="mass of the fibres alone per reference area [kg/m^2]; None: no fibre volume fraction"
    )
    fibre_density: Annotated[Positive, Quantity("fibre density")] | None = Field(
        default=None, description="density of the fibres [kg/m^3]"
    )

    def modulus(self, cell: UnitCell) -> float:
        """E_c [Pa]; infinite if the cell has no crossovers that can flatten."""
        return cell.crossover_modulus if self.crossover_modulus is None else self.crossover_modulus

    def thickness_ratio(self, cell: UnitCell, area_ratio: np.ndarray, pressure: np.ndarray) -> np.ndarray:
        """t/t_0 from the area ratio J and the crossover pressure [Pa], of their shape."""
        return area_ratio**-self.thickening / (1.0 + np.maximum(pressure, 0.0) / self.modulus(cell))

    def fibre_volume_fraction(self, thickness: np.ndarray, area_ratio: np.ndarray) -> np.ndarray | None:
        """Fibre volume fraction at the given thickness [m], of its shape; None if the fibre content is unknown."""
        if self.fibre_areal_density is None or self.fibre_density is None:
            return None
        return self.fibre_areal_density / (self.fibre_density * thickness * area_ratio)


def check_compaction(compaction: Compaction, thickness: float, areal_density: float) -> None:
    """Raise ValueError if the fibres weigh more than the sheet, or fill more than is possible."""
    fibres, density = compaction.fibre_areal_density, compaction.fibre_density
    if (fibres is None) != (density is None):
        raise ValueError("compaction: give fibre_areal_density and fibre_density together")
    if fibres is None or density is None:
        return
    if fibres > areal_density * (1.0 + 1.0e-9):
        raise ValueError(
            f"compaction.fibre_areal_density = {fibres:.4g} kg/m^2: at most the areal density, {areal_density:.4g}"
        )
    share = fibres / (density * thickness)
    if not share <= math.pi / (2.0 * math.sqrt(3.0)):
        raise ValueError(
            f"compaction: the fibres fill {share:.3g} of the undeformed sheet, more than round fibres can (0.907); "
            "check fibre_areal_density [kg/m^2], fibre_density [kg/m^3] and thickness [m]"
        )
