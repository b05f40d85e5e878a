"""The interface of bending laws."""

from __future__ import annotations

from abc import abstractmethod
from typing import Literal

from ...checks import Kinded
from ..device_form import DeviceForm

YarnName = Literal["warp", "weft"]


class BendingLaw(Kinded):
    """Base class of all bending laws. The thickness is that of the undeformed sheet [m]."""

    @abstractmethod
    def device_form(self, thickness: float) -> DeviceForm:
        """The law in the form that the kernels read."""

    @abstractmethod
    def stiffness_scale(self, thickness: float) -> float:
        """Typical bending stiffness [N m] that the director stabilisation scales with."""

    @abstractmethod
    def largest_stiffness(self, thickness: float) -> float:
        """Upper bound of the bending stiffness at any curvature [N m], for the stable step."""

    @abstractmethod
    def strip_stiffness(self, yarn: YarnName, thickness: float) -> float:
        """Initial stiffness per width [N m] of a strip along a yarn, free to bend across; without friction."""

    def bends_linearly(self, yarn: YarnName) -> bool:
        """True if bending along a yarn is fully described by one stiffness: no curve, no friction."""
        return True

    @property
    def trusted_curvature(self) -> tuple[float | None, float | None]:
        """Curvature of warp and weft up to which the law is measured [1/m]; None if it holds at any."""
        return None, None

    @property
    def friction_limit(self) -> tuple[float, float]:
        """Largest friction moment inside the bent yarns of warp and weft [N]."""
        return 0.0, 0.0

    @property
    def friction_stiffness(self) -> tuple[float, float]:
        """Slope that this friction adds before slip [N m]."""
        return 0.0, 0.0
