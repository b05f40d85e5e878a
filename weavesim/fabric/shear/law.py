"""The elastic laws of in-plane shear: what a sheet asks of one.

All laws speak of one quantity, m = dpsi/dgamma [N/m], the moment per reference area. The friction of the yarns that
turn on each other is beside it (``friction.py``).
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import Self

import numpy as np

from ...checks import Kinded
from ..device_form import DeviceForm

# Curves are tabulated up to here [rad].
LARGEST_SHEAR_ANGLE = 0.5 * math.pi


class ShearLaw(Kinded):
    """Base of all elastic shear laws: a moment, odd in the angle."""

    @abstractmethod
    def moment(self, angle: np.ndarray, thickness: float) -> np.ndarray:
        """m(gamma) at unit stretch [N/m], of angles [rad] in a sheet of a thickness [m]."""

    @abstractmethod
    def device_form(self, thickness: float) -> DeviceForm:
        """The law as the kernels take it, in a sheet of a thickness [m]."""

    @property
    def locking_slope(self) -> float:
        """Slope dm/dgamma that a locking branch adds [N/m]; 0 without one."""
        return 0.0

    def locking_at_most(self, slope: float) -> Self:
        """The same law with a locking branch of at most this slope [N/m]."""
        return self


def check_radians(angle: Sequence[float]) -> None:
    """ValueError if the last of these angles is beyond a right angle, as degrees would be."""
    if angle[-1] > LARGEST_SHEAR_ANGLE:
        raise ValueError(
            f"the last angle is {angle[-1]:.4g} rad: angles must stay below pi/2 rad (1 degree is 0.01745 rad)"
        )
