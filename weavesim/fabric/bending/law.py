"""The laws of bending: what a sheet asks of one."""

from __future__ import annotations

from abc import abstractmethod
from typing import Literal

from ...checks import Kinded
from ..device_form import DeviceForm

YarnName = Literal["warp", "weft"]


class BendingLaw(Kinded):
    """Base of all bending laws. The thickness is that of the undeformed sheet [m]."""

    @abstractmethod
    def device_form(self, thickness: float) -> DeviceForm:
        """The law as the kernels take it."""

    @abstractmethod
    def stiffness_scale(self, thickness: float) -> float:
        """Typical bending stiffness [N m] that the director stabilisation scales with."""

    @abstractmethod
    def largest_stiffness(self, thickness: float) -> float:
        """Bound of the bending stiffness of any curvature [N m], for the stable step."""

    @abstractmethod
    def strip_stiffness(self, yarn: YarnName, thickness: float) -> float:
        """Stiffness per width [N m] of a strip along a yarn that is free to bend across; at first, without friction."""

    def bends_linearly(self, yarn: YarnName) -> bool:
        """True if one stiffness along a yarn says all: no bent curve, no friction."""
        return True

    @property
    def friction_limit(self) -> tuple[float, float]:
        """Largest friction moment inside the bent yarns of warp and weft [N]."""
        return 0.0, 0.0

    @property
    def friction_stiffness(self) -> tuple[float, float]:
        """Slope that this friction adds before it slips [N m]."""
        return 0.0, 0.0
