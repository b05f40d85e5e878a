"""Friction laws in the form that the kernels read."""

from __future__ import annotations

import math

import numpy as np

from ..kernels.contact.friction import HERSEY, NO_ARGUMENT, PRESSURE, YARN_ANGLE
from .friction import Friction, PressureFriction, StribeckFriction, ViscousFilm, YarnAngleFriction

# Rate of a film, or of the slope of a Stribeck curve, over what the step can carry.
LARGEST_VISCOUS_SHARE = 0.1
_ARGUMENT_KINDS: dict[type[Friction], int] = {
    PressureFriction: int(PRESSURE),
    YarnAngleFriction: int(YARN_ANGLE),
    StribeckFriction: int(HERSEY),
}


def argument_kind(friction: Friction) -> int:
    """What its table is over, as the kernels number it."""
    return _ARGUMENT_KINDS.get(type(friction), int(NO_ARGUMENT))


def carried_rate(density: float, step: float) -> float:
    """Largest drag over speed and area that an explicit step carries [Pa s/m].

    Args:
        density: mass of the sheet per area [kg/m^2].
        step: [s].
    """
    return LARGEST_VISCOUS_SHARE * density / step


def viscous_rates(friction: Friction, carried: float = math.inf) -> tuple[float, float]:
    """Viscosity of the Hersey number [Pa s] and rate of a film [Pa s/m], as far as the time step carries them.

    Args:
        friction: the law.
        carried: see ``carried_rate``.
    """
    if isinstance(friction, ViscousFilm):
        return 0.0, friction.viscosity / (friction.thickness + friction.viscosity / carried)
    if isinstance(friction, StribeckFriction):
        argument, coefficient = friction.table()
        slope = max(0.0, float(np.max(np.diff(coefficient) / np.diff(argument))))
        return friction.viscosity / (1.0 + friction.viscosity * slope / carried), 0.0
    return 0.0, 0.0


def viscous_share(friction: Friction, carried: float) -> float:
    """Share of the viscosity that the time step carries: 1, or less where it is reduced."""
    wanted, found = viscous_rates(friction), viscous_rates(friction, carried)
    return min((have / want for have, want in zip(found, wanted, strict=True) if want > 0.0), default=1.0)
