"""Bending like an isotropic plate, equation (6) of the paper (docs/theory.md, section 4)."""

from functools import cache
from typing import Any

import warp as wp

from ..operators import add, div, mul, sub  # noqa: F401
from .contract import BendingDevice, quadratic_energy


@cache
def parameters(real: type):
    """Constants of the law in one precision, as a Warp struct."""

    @wp.struct
    class IsotropicBending:
        stiffness: real  # D [N m]
        poisson_ratio: real

    return IsotropicBending


@wp.func
def isotropic_resultants(laws: Any, m: Any, b: Any, r: Any):
    """M = J D [(1-nu) k + nu a tr k] in the current metric, equation (6) of the paper, k raised by the inverse metric.

    T = a (psi + 2 J D (1-nu) det k) - 2 J D tr(k) k is the derivative with respect to the metric.
    """
    inverse_ratio = m.inverse_ratio
    two = inverse_ratio.dtype(2.0)
    half = inverse_ratio.dtype(0.5)
    inverse_square = inverse_ratio * inverse_ratio
    twisting = inverse_ratio.dtype(1.0) - laws.bending.poisson_ratio
    trace = (m.m22 * b.k11 - two * m.m12 * b.k12 + m.m11 * b.k22) * inverse_square
    determinant = (b.k11 * b.k22 - b.k12 * b.k12) * inverse_square
    stiffness = laws.bending.stiffness * inverse_ratio
    moment11 = stiffness * (trace * m.m22 - twisting * b.k22)
    moment12 = stiffness * (twisting * b.k12 - trace * m.m12)
    moment22 = stiffness * (trace * m.m11 - twisting * b.k11)
    energy = half * (moment11 * b.k11 + two * moment12 * b.k12 + moment22 * b.k22)
    spherical = energy * inverse_square + two * twisting * stiffness * determinant
    along = two * stiffness * trace
    r.t11 = spherical * m.m22 - along * (trace * m.m22 - b.k22)
    r.t12 = -(spherical * m.m12 - along * (trace * m.m12 - b.k12))
    r.t22 = spherical * m.m11 - along * (trace * m.m11 - b.k11)
    r.moment11 = moment11
    r.moment12 = moment12
    r.moment22 = moment22
    return r


@wp.func
def area_widening(m: Any, sine: Any):
    """The law contains J."""
    return m.area_ratio


LAW = BendingDevice(
    parameters,
    isotropic_resultants,
    quadratic_energy,
    widening=area_widening,
    # rounded up
    curvature_stiffening=24.0,  # proven: 13.72
    curvature_coupling=7.4,  # proven: 5.17
)
