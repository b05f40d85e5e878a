"""Bending per yarn family with constant stiffnesses (docs/theory.md, section 4).

psi = psi_1(k_11/m_11) + psi_2(k_22/m_22) + (D_nu k_11 k_22 + 2 D_12 k_12^2)/(m_11 m_22), psi_k = 1/2 D_k (k_kk/m_kk)^2.
"""

from functools import cache
from typing import Any

import warp as wp

from ..lanes import fill
from ..operators import add, div, mul, sub  # noqa: F401
from .contract import YARN_CURVATURE_COUPLING, YARN_CURVATURE_STIFFENING, BendingDevice, quadratic_energy, yarn_widening


@cache
def parameters(real: type):
    """Constants of the law in one precision, as a Warp struct."""

    @wp.struct
    class YarnBending:
        warp_stiffness: real  # D_1 [N m]
        weft_stiffness: real  # D_2
        twist_stiffness: real  # D_12
        coupling_stiffness: real  # D_nu

    return YarnBending


@wp.func
def family_resultants(laws: Any, m: Any, b: Any, moment11: Any, moment22: Any, r: Any):
    """Resultants from given moments of the families, plus coupling and twist."""
    two = moment11.dtype(2.0)
    moment12 = two * laws.bending.twist_stiffness * b.k12 / (m.m11 * m.m22)
    r.t11 = -(two * (moment11 * b.k11 + moment12 * b.k12) / m.m11)
    r.t12 = fill(moment11, 0.0)
    r.t22 = -(two * (moment22 * b.k22 + moment12 * b.k12) / m.m22)
    r.moment11 = moment11
    r.moment12 = moment12
    r.moment22 = moment22
    return r


@wp.func
def yarn_resultants(laws: Any, m: Any, b: Any, r: Any):
    """psi_k = 1/2 D_k (k_kk/m_kk)^2."""
    m11 = m.m11
    m22 = m.m22
    coupling = fill(m11, laws.bending.coupling_stiffness) / (m11 * m22)
    moment11 = laws.bending.warp_stiffness * b.k11 / (m11 * m11) + coupling * b.k22
    moment22 = laws.bending.weft_stiffness * b.k22 / (m22 * m22) + coupling * b.k11
    return family_resultants(laws, m, b, moment11, moment22, r)


LAW = BendingDevice(
    parameters,
    yarn_resultants,
    quadratic_energy,
    widening=yarn_widening,
    curvature_stiffening=YARN_CURVATURE_STIFFENING,
    curvature_coupling=YARN_CURVATURE_COUPLING,
)
