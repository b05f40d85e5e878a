"""Friction at the crossovers; its limit depends on the angle and grows with pressure (docs/theory.md, section 3)."""

from functools import cache
from typing import Any

import warp as wp

from ..curve import curve_size, curve_struct
from ..lanes import fill, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from .contract import FrictionDevice


@cache
def parameters(real: type):
    """Constants of the law in one precision, as a Warp struct."""

    @wp.struct
    class ShearFriction:
        stiffness: real  # of the spring in series with the slider [N/m]
        limit: curve_struct(real)  # moment at which it slips, as a function of the angle [N/m]
        crossover_friction_length: real  # times the crossover pressure, is added to that limit [m]

    return ShearFriction


@wp.func
def friction_limit(laws: Any, angle: Any, crossover_pressure: Any):
    """Moment at which the yarns slip on each other [N/m]; it grows with the crossover pressure [Pa]."""
    pressed = where_positive(crossover_pressure, crossover_pressure, fill(angle, 0.0))
    return curve_size(laws.shear_friction.limit, angle) + laws.shear_friction.crossover_friction_length * pressed


LAW = FrictionDevice(parameters, friction_limit)
