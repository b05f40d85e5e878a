"""The linear shear law of the paper."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from ...checks import NotNegative
from ...ranges import Quantity
from ..device_form import DeviceForm
from .law import ShearLaw


class LinearShear(ShearLaw):
    """The paper's law, equation (4): S_12 = G_12 E_12 with the tensor component E_12 of the Green-Lagrange strain.

    At small angles the stress is therefore G_12 gamma / 2: a modulus G = tau/gamma, stress over angle, as transverse
    shear and ``YarnBending.from_moduli`` use it, has to be doubled here.
    """

    modulus: Annotated[NotNegative, Quantity("shear modulus")] = Field(
        description="G_12 of equation (4), stress over the tensor strain: twice the stress over the angle [Pa]"
    )

    def moment(self, angle: np.ndarray, thickness: float) -> np.ndarray:
        """m(gamma) = dpsi/dgamma at unit stretch, t/2 G_12 sin(gamma) cos(gamma) [N/m]."""
        return 0.5 * thickness * self.modulus * np.sin(angle) * np.cos(angle)

    def device_form(self, thickness: float) -> DeviceForm:
        return DeviceForm("weavesim.kernels.laws.linear_shear", {"stiffness": thickness * self.modulus})
