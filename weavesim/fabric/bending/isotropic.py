"""Bending like an isotropic plate."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ...checks import NotNegative
from ...ranges import Quantity
from ..device_form import DeviceForm
from .law import BendingLaw, YarnName


class IsotropicBending(BendingLaw):
    """Equations (5) and (6): an isotropic plate in the current tangent plane, decoupled from the membrane."""

    modulus: Annotated[NotNegative, Quantity("sheet modulus")] = Field(
        description="E of the sheet in bending (not of the yarns) [Pa]"
    )
    poisson_ratio: float = Field(default=0.0, gt=-1.0, lt=0.5, description="nu of the sheet in bending")

    def stiffness(self, thickness: float) -> float:
        """D = E t^3 / 12 (1 - nu^2) [N m]."""
        return self.modulus * thickness**3 / (12.0 * (1.0 - self.poisson_ratio**2))

    def stiffness_scale(self, thickness: float) -> float:
        return self.stiffness(thickness)

    def largest_stiffness(self, thickness: float) -> float:
        return self.stiffness(thickness) * (1.0 + abs(self.poisson_ratio))

    def strip_stiffness(self, yarn: YarnName, thickness: float) -> float:
        return self.stiffness(thickness) * (1.0 - self.poisson_ratio**2)

    def device_form(self, thickness: float) -> DeviceForm:
        constants = {"stiffness": self.stiffness(thickness), "poisson_ratio": self.poisson_ratio}
        return DeviceForm("weavesim.kernels.laws.isotropic_bending", constants)
