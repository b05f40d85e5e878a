"""The interface of the elastic laws of in-plane shear.

All laws give one quantity, m = dpsi/dgamma [N/m], the moment per reference area. Friction of the yarns that rotate on
each other is added to it (``friction.py``).
"""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Self

import numpy as np

from ...checks import Kinded
from ..device_form import DeviceForm

# Curves are tabulated up to here [rad].
LARGEST_SHEAR_ANGLE = 0.5 * math.pi


class ShearLaw(Kinded):
    """Base class of all elastic shear laws: a moment, odd in the angle."""

    @abstractmethod
    def moment(self, angle: np.ndarray, thickness: float) -> np.ndarray:
        """m(gamma) at unit stretch [N/m], of the shape of the angles [rad], in a sheet of the given thickness [m]."""

    @abstractmethod
    def device_form(self, thickness: float) -> DeviceForm:
        """The law in the form that the kernels read, for a sheet of the given thickness [m]."""

    @property
    def trusted_angle(self) -> float | None:
        """Angle up to which the law is measured or meant [rad]; None if it holds at any."""
        return None

    @property
    def locking_slope(self) -> float:
        """Slope dm/dgamma that a locking branch adds [N/m]; 0 without one."""
        return 0.0

    def locking_at_most(self, slope: float) -> Self:
        """The same law with the slope of its locking branch limited to ``slope`` [N/m]."""
        return self
