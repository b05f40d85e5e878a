"""Friction at the crossovers with a limit over the angle, which their pressure raises (docs/theory.md, section 3)."""

from functools import cache
from typing import Any

import warp as wp

from ..curve import curve_size, curve_struct
from ..lanes import fill, where_positive
from ..operators import div, mul  # noqa: F401
from .contract import FrictionDevice


@cache
def parameters(real: type):
    """Constants of the law in one precision, as a Warp struct."""

    @wp.struct
    class ShearFriction:
        stiffness: real  # of the spring before the slider [N/m]
        limit: curve_struct(real)  # moment that makes it slip, over the angle [N/m]
        crossover_friction_length: real  # times the pressure of the crossovers, is added to that limit [m]

    return ShearFriction


@wp.func
def friction_limit(laws: Any, angle: Any, crossover_pressure: Any):
    """Moment at which the yarns turn on each other [N/m]; it grows with the pressure of the crossovers [Pa]."""
    pressed = where_positive(crossover_pressure, crossover_pressure, fill(angle, 0.0))
    return curve_size(laws.shear_friction.limit, angle) + laws.shear_friction.crossover_friction_length * pressed


LAW = FrictionDevice(parameters, friction_limit)
