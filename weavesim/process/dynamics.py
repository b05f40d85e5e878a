"""Gravity, damping and the dissipation of contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..errors import InputError


@dataclass(frozen=True)
class Dynamics:
    """Loads and dissipation of the time integration.

    Attributes:
        gravity: (3,) [m/s^2].
        damping: mass-proportional damping rate of the nodes [1/s].
        director_damping: the same for the directors [1/s].
        contact_damping_ratio: normal dashpot of the contact, as a share of critical.
        contact_thickness: tools meet the sheet at half its "initial" or its "current" thickness; what a change of
            thickness does on the tools is booked as ``thickness_work``.
    """

    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    damping: float = 0.0
    director_damping: float = 0.0
    contact_damping_ratio: float = 0.1
    contact_thickness: Literal["initial", "current"] = "initial"

    def __post_init__(self) -> None:
        gravity = np.asarray(self.gravity, dtype=np.float64)
        damping = np.array([self.damping, self.director_damping, self.contact_damping_ratio])
        if gravity.shape != (3,) or not (
            np.isfinite(gravity).all() and np.isfinite(damping).all() and damping.min() >= 0
        ):
            raise InputError(f"{self}: gravity needs three finite components, damping is finite and not negative")
        if self.contact_thickness not in ("initial", "current"):
            raise InputError(f'contact_thickness = {self.contact_thickness!r}: "initial" or "current" is needed')
