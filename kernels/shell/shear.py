"""In-plane shear: moment, energy, second derivatives, friction (docs/theory.md, section 3)."""

from typing import Any

import warp as wp

from ..curve import curve_energy, curve_size, odd_curve, slide
from ..lanes import (
    fill,
    larger,
    mul,  # noqa: F401 - operators of lanes
    spread,
    where_positive,
)

# --- in-plane shear ---------------------------------------------------------------------------------------------------


@wp.func
def moment_resultants(moment: Any, m12: Any, inverse1: Any, inverse2: Any, inverse_ratio: Any):
    """T11, T12, T22 of a moment m = dpsi/dgamma: dgamma/da_1 = (a_2 - a_1 m12/m11)/J, likewise for a_2.

    Given are the reciprocals of the stretches, whose squares are m11 and m22, and of J.
    """
    t12 = moment * inverse_ratio
    across = -(t12 * m12)
    return across * inverse1 * inverse1, t12, across * inverse2 * inverse2


@wp.func
def shear_resultants(laws: Any, curved: bool, m12: Any, angle: Any):
    """In-plane shear without friction: its moment, and T12 beside what follows from the moment.

    Curve: dpsi/da_1 = m dgamma/da_1. Linear: S_12 = G_12 E_12 with E_12 = 1/2 a_1.a_2, equation (4) of the paper.
    """
    moment = fill(angle, 0.0)
    t12 = fill(angle, 0.0)
    if curved:
        moment, tangent = odd_curve(laws.shear.curve, angle)
    else:
        t12 = m12.dtype(0.5) * laws.shear.stiffness * m12
    return moment, t12


@wp.func
def shear_energy(laws: Any, curved: bool, m12: Any, angle: Any):
    """psi of in-plane shear [J/m^2]; linear law: t G_12 E_12^2."""
    energy = m12.dtype(0.25) * laws.shear.stiffness * m12 * m12
    if curved:
        energy = curve_energy(laws.shear.curve, angle)
    return energy


@wp.func
def shear_moment(laws: Any, curved: bool, m12: Any, area_ratio: Any, angle: Any):
    """dpsi/dgamma at constant stretches, without friction [N/m]; linear law: T12 dm12/dgamma = T12 J."""
    moment = m12.dtype(0.5) * laws.shear.stiffness * m12 * area_ratio
    if curved:
        moment, tangent = odd_curve(laws.shear.curve, angle)
    return moment


@wp.func
def shear_friction_limit(laws: Any, angle: Any, crossover_pressure: Any):
    """Moment at which the yarns turn on each other [N/m]; it grows with the pressure of the crossovers [Pa]."""
    pressed = where_positive(crossover_pressure, crossover_pressure, fill(angle, 0.0))
    return curve_size(laws.shear.friction_limit, angle) + laws.shear.crossover_friction_length * pressed


@wp.func
def shear_friction(laws: Any, angle: Any, slip: Any, spring: Any, crossover_pressure: Any):
    """Slip and spring of the friction between the yarns [rad], work lost [J/m^2]; the moment is stiffness x spring."""
    limit = shear_friction_limit(laws, angle, crossover_pressure)
    return slide(angle, slip, spring, laws.shear.friction_stiffness, limit, laws.slip_resolution)


@wp.func
def shear_tangent(
    laws: Any,
    curved: bool,
    sticking: bool,
    stretch1: Any,
    stretch2: Any,
    sine: Any,
    cosine: Any,
    angle: Any,
    crossover_pressure: Any,
):
    """Second derivatives of the shear energy by (stretch 1, stretch 2, angle): C11, C12, C22, C13, C23, C33 [N/m].

    Then its first derivatives n_1, n_2, m. Friction (``sticking``) counts with all the moment that it can bear.
    """
    zero = fill(angle, 0.0)
    c11 = zero
    c12 = zero
    c22 = zero
    c13 = zero
    c23 = zero
    c33 = zero
    n1 = zero
    n2 = zero
    moment = zero
    if curved:
        moment, c33 = odd_curve(laws.shear.curve, angle)
        c33 = larger(c33, zero)
    else:
        # psi = 1/4 t G_12 (stretch1 stretch2 sin)^2
        half = angle.dtype(0.5) * laws.shear.stiffness
        product = stretch1 * stretch2
        c11 = half * (stretch2 * sine) * (stretch2 * sine)
        c12 = (angle.dtype(2.0) * half) * (product * sine * sine)
        c22 = half * (stretch1 * sine) * (stretch1 * sine)
        mixed = (angle.dtype(2.0) * half) * (product * sine * cosine)
        c13 = stretch2 * mixed
        c23 = stretch1 * mixed
        c33 = half * (product * product) * (cosine * cosine - sine * sine)
        n1 = stretch1 * c11
        n2 = stretch2 * c22
        moment = half * (product * product) * (sine * cosine)
    if sticking:
        limit = shear_friction_limit(laws, angle, crossover_pressure)
        c33 = c33 + spread(angle, laws.shear.friction_stiffness)
        moment = moment + where_positive(moment, limit, -limit)
    return c11, c12, c22, c13, c23, c33, n1, n2, moment
