"""In-plane shear (docs/theory.md, section 3): the linear law, the law by a curve, and friction between the yarns.

Each law is a ``ShearDevice`` of functions of lanes; kernels are made for one of them. m is a ``Membrane``, angle its
shear angle gamma.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

from ..curve import curve_energy, curve_size, curve_struct, odd_curve, slide
from ..lanes import fill, lane_types, larger, where_positive
from ..operators import div, mul  # noqa: F401
from ..rows import SlipRow


@dataclass(frozen=True, eq=False)
class ShearDevice:
    """One law of shear without friction, as the kernels use it.

    Attributes:
        resultants: (laws, m) -> moment dpsi/dgamma [N/m], and T12 beside what follows from the moment.
        energy: (laws, m) -> psi [J/m^2].
        moment: (laws, m) -> dpsi/dgamma at constant stretches [N/m], all of it.
        tangent: (laws, m, sine, cosine, t) -> the ``Tangent`` t, filled; sine and cosine are those of the angle.
    """

    resultants: Any
    energy: Any
    moment: Any
    tangent: Any


@cache
def shear_struct(real: type):
    """Constants of in-plane shear in one precision, as a Warp struct."""

    @wp.struct
    class ShearLaw:
        stiffness: real  # t G_12 of the linear law [N/m]
        curve: curve_struct(real)  # moment per reference area over the angle [N/m]
        friction_stiffness: real  # of the spring before the slider [N/m]
        friction_limit: curve_struct(real)  # moment that makes it slip, over the angle [N/m]
        crossover_friction_length: real  # times the pressure of the crossovers, is added to that limit [m]

    return ShearLaw


@cache
def tangent_struct(real: type, lane_count: int):
    """First and second derivatives of an energy by (stretch 1, stretch 2, shear angle) [N/m]."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class Tangent:
        c11: lanes
        c12: lanes
        c22: lanes
        c13: lanes
        c23: lanes
        c33: lanes
        n1: lanes
        n2: lanes
        moment: lanes

    return Tangent


@wp.func
def moment_resultants(moment: Any, m12: Any, inverse1: Any, inverse2: Any, inverse_ratio: Any):
    """T11, T12, T22 of a moment m = dpsi/dgamma: dgamma/da_1 = (a_2 - a_1 m12/m11)/J, likewise for a_2.

    Given are the reciprocals of the stretches, whose squares are m11 and m22, and of J.
    """
    t12 = moment * inverse_ratio
    across = -(t12 * m12)
    return across * inverse1 * inverse1, t12, across * inverse2 * inverse2


# --- linear: S_12 = G_12 E_12 with E_12 = 1/2 a_1.a_2, equation (4) of the paper --------------------------------------


@wp.func
def linear_resultants(laws: Any, m: Any):
    m12 = m.m12
    return fill(m12, 0.0), m12.dtype(0.5) * laws.shear.stiffness * m12


@wp.func
def linear_energy(laws: Any, m: Any):
    """psi = t G_12 E_12^2."""
    m12 = m.m12
    return m12.dtype(0.25) * laws.shear.stiffness * m12 * m12


@wp.func
def linear_moment(laws: Any, m: Any):
    """T12 dm12/dgamma = T12 J."""
    m12 = m.m12
    return m12.dtype(0.5) * laws.shear.stiffness * m12 * m.area_ratio


@wp.func
def linear_tangent(laws: Any, m: Any, sine: Any, cosine: Any, t: Any):
    """psi = 1/4 t G_12 (stretch1 stretch2 sin)^2."""
    half = sine.dtype(0.5) * laws.shear.stiffness
    product = m.stretch1 * m.stretch2
    c11 = half * (m.stretch2 * sine) * (m.stretch2 * sine)
    c22 = half * (m.stretch1 * sine) * (m.stretch1 * sine)
    mixed = (sine.dtype(2.0) * half) * (product * sine * cosine)
    t.c11 = c11
    t.c12 = (sine.dtype(2.0) * half) * (product * sine * sine)
    t.c22 = c22
    t.c13 = m.stretch2 * mixed
    t.c23 = m.stretch1 * mixed
    t.c33 = half * (product * product) * (cosine * cosine - sine * sine)
    t.n1 = m.stretch1 * c11
    t.n2 = m.stretch2 * c22
    t.moment = half * (product * product) * (sine * cosine)
    return t


LINEAR_SHEAR = ShearDevice(linear_resultants, linear_energy, linear_moment, linear_tangent)


# --- by a curve of the moment over the angle: dpsi/da_1 = m dgamma/da_1 -----------------------------------------------


@wp.func
def curve_resultants(laws: Any, m: Any):
    moment, tangent = odd_curve(laws.shear.curve, m.angle)
    return moment, fill(moment, 0.0)


@wp.func
def curve_psi(laws: Any, m: Any):
    return curve_energy(laws.shear.curve, m.angle)


@wp.func
def curve_moment(laws: Any, m: Any):
    moment, tangent = odd_curve(laws.shear.curve, m.angle)
    return moment


@wp.func
def curve_tangent(laws: Any, m: Any, sine: Any, cosine: Any, t: Any):
    moment, stiffness = odd_curve(laws.shear.curve, m.angle)
    t.c33 = larger(stiffness, fill(stiffness, 0.0))
    t.moment = moment
    return t


CURVED_SHEAR = ShearDevice(curve_resultants, curve_psi, curve_moment, curve_tangent)


# --- friction between the yarns that turn on each other ---------------------------------------------------------------


@wp.func
def shear_friction_limit(laws: Any, angle: Any, crossover_pressure: Any):
    """Moment at which the yarns turn on each other [N/m]; it grows with the pressure of the crossovers [Pa]."""
    pressed = where_positive(crossover_pressure, crossover_pressure, fill(angle, 0.0))
    return curve_size(laws.shear.friction_limit, angle) + laws.shear.crossover_friction_length * pressed


@wp.func
def shear_friction(laws: Any, block: int, angle: Any, crossover_pressure: Any, slip: Any):
    """Moment of the friction [N/m]; writes its slip, its spring and the work lost."""
    limit = shear_friction_limit(laws, angle, crossover_pressure)
    turned, spring, lost = slide(
        angle,
        slip[SlipRow.shear_slip, block],
        slip[SlipRow.shear_spring, block],
        laws.shear.friction_stiffness,
        limit,
        laws.slip_resolution,
    )
    slip[SlipRow.shear_slip, block] = turned
    slip[SlipRow.shear_spring, block] = spring
    slip[SlipRow.shear_friction_loss, block] = slip[SlipRow.shear_friction_loss, block] + lost
    return laws.shear.friction_stiffness * spring


@wp.func
def sticking_shear(laws: Any, angle: Any, crossover_pressure: Any, t: Any):
    """Add friction to a ``Tangent`` of shear: it sticks, and counts with all the moment that it can bear."""
    limit = shear_friction_limit(laws, angle, crossover_pressure)
    t.c33 = t.c33 + fill(angle, laws.shear.friction_stiffness)
    t.moment = t.moment + where_positive(t.moment, limit, -limit)
    return t
