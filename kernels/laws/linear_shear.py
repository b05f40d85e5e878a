"""Linear shear: S_12 = G_12 E_12 with E_12 = 1/2 a_1.a_2, equation (4) of the paper (docs/theory.md, section 3)."""

from functools import cache
from typing import Any

import warp as wp

from ..lanes import fill
from ..operators import add, div, mul, sub  # noqa: F401
from .contract import ShearDevice


@cache
def parameters(real: type):
    """Constants of the law in one precision, as a Warp struct."""

    @wp.struct
    class LinearShear:
        stiffness: real  # t G_12 [N/m]

    return LinearShear


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


LAW = ShearDevice(parameters, linear_resultants, linear_energy, linear_moment, linear_tangent)
