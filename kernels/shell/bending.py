"""Bending laws and transverse shear (docs/theory.md, section 4)."""

from typing import Any

import warp as wp

from ..curve import curve_energy, odd_curve, slide
from ..lanes import div, fill, mul, spread  # noqa: F401 - operators of lanes
from .laws import BENDING_CURVES, BENDING_ISOTROPIC, BENDING_YARNS

# --- bending and transverse shear -------------------------------------------------------------------------------------


@wp.func
def bending_moments(
    laws: Any, kind: int, m11: Any, m12: Any, m22: Any, inverse_ratio: Any, k11: Any, k12: Any, k22: Any
):
    """M11, M12, M22 and T11, T12, T22 of bending; ``inverse_ratio`` is 1/J.

    Isotropic: M = J D [(1-nu) k + nu a tr k] in the current metric, equation (6) of the paper, with k raised by the
    inverse metric; T = a (psi + 2 J D (1-nu) det k) - 2 J D tr(k) k is the derivative by the metric.
    Yarns: psi = 1/2 sum D_a (k_aa/m_aa)^2 + D_nu k_11 k_22/(m_11 m_22) + 2 D_12 k_12^2/(m_11 m_22).
    Curves: the same with the integral of a family's moment over k_aa/m_aa in place of 1/2 D_a (k_aa/m_aa)^2.
    """
    two = m11.dtype(2.0)
    half = m11.dtype(0.5)
    moment11 = fill(m11, 0.0)
    moment12 = fill(m11, 0.0)
    moment22 = fill(m11, 0.0)
    t11 = fill(m11, 0.0)
    t12 = fill(m11, 0.0)
    t22 = fill(m11, 0.0)
    if kind == BENDING_ISOTROPIC:
        inverse_square = inverse_ratio * inverse_ratio
        twisting = m11.dtype(1.0) - laws.bending.poisson_ratio
        trace = (m22 * k11 - two * m12 * k12 + m11 * k22) * inverse_square
        determinant = (k11 * k22 - k12 * k12) * inverse_square
        stiffness = laws.bending.stiffness * inverse_ratio
        moment11 = stiffness * (trace * m22 - twisting * k22)
        moment12 = stiffness * (twisting * k12 - trace * m12)
        moment22 = stiffness * (trace * m11 - twisting * k11)
        energy = half * (moment11 * k11 + two * moment12 * k12 + moment22 * k22)
        spherical = energy * inverse_square + two * twisting * stiffness * determinant
        along = two * stiffness * trace
        t11 = spherical * m22 - along * (trace * m22 - k22)
        t12 = -(spherical * m12 - along * (trace * m12 - k12))
        t22 = spherical * m11 - along * (trace * m11 - k11)
    else:
        stiffness1 = laws.bending.yarn_stiffness[0]
        stiffness2 = laws.bending.yarn_stiffness[1]
        stiffness12 = laws.bending.yarn_stiffness[2]
        coupling = spread(m11, laws.bending.yarn_stiffness[3]) / (m11 * m22)
        moment12 = two * stiffness12 * k12 / (m11 * m22)
        if kind == BENDING_YARNS:
            moment11 = stiffness1 * k11 / (m11 * m11) + coupling * k22
            moment22 = stiffness2 * k22 / (m22 * m22) + coupling * k11
        else:
            warp_moment, warp_tangent = odd_curve(laws.bending.warp_curve, k11 / m11)
            weft_moment, weft_tangent = odd_curve(laws.bending.weft_curve, k22 / m22)
            moment11 = warp_moment / m11
            moment22 = weft_moment / m22
        t11 = -(two * (moment11 * k11 + moment12 * k12) / m11)
        t22 = -(two * (moment22 * k22 + moment12 * k12) / m22)
    return moment11, moment12, moment22, t11, t12, t22


@wp.func
def bending_energy(
    laws: Any, kind: int, m11: Any, m22: Any, k11: Any, k12: Any, k22: Any, m_11: Any, m_12: Any, m_22: Any
):
    """psi of bending [J/m^2], from curvatures and the moments ``m_11``, ``m_12``, ``m_22`` of ``bending_moments``."""
    half = m11.dtype(0.5)
    energy = half * (m_11 * k11 + m_22 * k22) + m_12 * k12
    if kind == BENDING_CURVES:
        energy = (
            curve_energy(laws.bending.warp_curve, k11 / m11)
            + curve_energy(laws.bending.weft_curve, k22 / m22)
            + m_12 * k12
        )
    return energy


@wp.func
def bending_friction(laws: Any, family: int, curvature: Any, slip: Any, spring: Any):
    """Slip and spring of the friction in a bent family of yarns (0 warp, 1 weft) [1/m], work lost [J/m^2]."""
    limit = spread(curvature, laws.bending.friction_limit[family])
    return slide(curvature, slip, spring, laws.bending.friction_stiffness[family], limit, laws.slip_resolution)


@wp.func
def transverse_shear_forces(
    laws: Any, m11: Any, m12: Any, m22: Any, area_ratio: Any, inverse_ratio: Any, g1: Any, g2: Any
):
    """Q1, Q2 and T11, T12, T22 of transverse shear, Q = J G_s g raised by the inverse metric; the energy is 1/2 Q.g."""
    inverse_square = inverse_ratio * inverse_ratio
    raised1 = (m22 * g1 - m12 * g2) * inverse_square
    raised2 = (m11 * g2 - m12 * g1) * inverse_square
    stiffness = laws.transverse_shear_stiffness * area_ratio
    q1 = stiffness * raised1
    q2 = stiffness * raised2
    energy = m11.dtype(0.5) * (q1 * g1 + q2 * g2) * inverse_square
    t11 = energy * m22 - q1 * raised1
    t12 = -(energy * m12) - q1 * raised2
    t22 = energy * m11 - q2 * raised2
    return q1, q2, t11, t12, t22
