"""Bending (docs/theory.md, section 4): the isotropic law, the laws per yarn family, friction, and transverse shear.

Each law is a ``BendingDevice`` of functions of lanes; kernels are made for one of them. m is a ``Membrane``, b a
``Bend``, r the ``Resultants`` that the functions fill or add to.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

from ..curve import curve_energy, curve_struct, odd_curve, slide, spring_energy
from ..lanes import fill, lane_types
from ..operators import div, mul  # noqa: F401
from ..rows import SlipRow

# The two families of yarns.
WARP = 0
WEFT = 1


@dataclass(frozen=True, eq=False)
class BendingDevice:
    """One law of bending without friction, as the kernels use it.

    Attributes:
        resultants: (laws, m, b, r) -> r with moments and T of bending set.
        energy: (laws, m, b, r) -> psi [J/m^2], with the moments of r.
    """

    resultants: Any
    energy: Any


@cache
def bending_struct(real: type):
    """Constants of bending in one precision, as a Warp struct."""

    @wp.struct
    class BendingLaw:
        stiffness: real  # D [N m]
        poisson_ratio: real
        warp_stiffness: real  # D_1 [N m]
        weft_stiffness: real  # D_2
        twist_stiffness: real  # D_12
        coupling_stiffness: real  # D_nu
        warp_curve: curve_struct(real)  # moment over curvature [N]
        weft_curve: curve_struct(real)
        friction_stiffness: wp.types.vector(2, real)  # WARP, WEFT: of the springs before the sliders [N m], not zero
        friction_limit: wp.types.vector(2, real)  # moment that makes them slip [N]

    return BendingLaw


@cache
def resultants_struct(real: type, lane_count: int):
    """Resultants of a block of elements, per reference area."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class Resultants:
        t11: lanes  # T: the part of dpsi/da_alpha along a_beta [N/m]
        t12: lanes
        t22: lanes
        moment11: lanes  # M: dpsi/dk [N]
        moment12: lanes
        moment22: lanes
        shear_force1: lanes  # Q: dpsi/dg [N/m]
        shear_force2: lanes

    return Resultants


# --- isotropic --------------------------------------------------------------------------------------------------------


@wp.func
def isotropic_resultants(laws: Any, m: Any, b: Any, r: Any):
    """M = J D [(1-nu) k + nu a tr k] in the current metric, equation (6) of the paper, k raised by the inverse metric.

    T = a (psi + 2 J D (1-nu) det k) - 2 J D tr(k) k is the derivative by the metric.
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
def quadratic_energy(laws: Any, m: Any, b: Any, r: Any):
    """psi of moments linear in the curvatures."""
    half = b.k11.dtype(0.5)
    return half * (r.moment11 * b.k11 + r.moment22 * b.k22) + r.moment12 * b.k12


ISOTROPIC_BENDING = BendingDevice(isotropic_resultants, quadratic_energy)


# --- per yarn family: psi = psi_1(k_11/m_11) + psi_2(k_22/m_22) + (D_nu k_11 k_22 + 2 D_12 k_12^2)/(m_11 m_22) --------


@wp.func
def family_resultants(laws: Any, m: Any, b: Any, moment11: Any, moment22: Any, r: Any):
    """Of given moments of the families and the twist between them."""
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


YARN_BENDING = BendingDevice(yarn_resultants, quadratic_energy)


@wp.func
def curve_resultants(laws: Any, m: Any, b: Any, r: Any):
    """psi_k is the integral of the family's moment over k_kk/m_kk; D_nu = 0."""
    warp_moment, warp_tangent = odd_curve(laws.bending.warp_curve, b.k11 / m.m11)
    weft_moment, weft_tangent = odd_curve(laws.bending.weft_curve, b.k22 / m.m22)
    return family_resultants(laws, m, b, warp_moment / m.m11, weft_moment / m.m22, r)


@wp.func
def curve_psi(laws: Any, m: Any, b: Any, r: Any):
    return (
        curve_energy(laws.bending.warp_curve, b.k11 / m.m11)
        + curve_energy(laws.bending.weft_curve, b.k22 / m.m22)
        + r.moment12 * b.k12
    )


CURVED_BENDING = BendingDevice(curve_resultants, curve_psi)


# --- friction inside the bent yarns of a family -----------------------------------------------------------------------


@wp.func
def family_friction(laws: Any, block: int, family: int, curvature: Any, slip: Any):
    """Moment [N] of the friction in a family, WARP or WEFT; writes its slip, its spring and the work lost."""
    limit = fill(curvature, laws.bending.friction_limit[family])
    slid, spring, lost = slide(
        curvature,
        slip[SlipRow.warp_bending_slip + family, block],
        slip[SlipRow.warp_bending_spring + family, block],
        laws.bending.friction_stiffness[family],
        limit,
        laws.slip_resolution,
    )
    slip[SlipRow.warp_bending_slip + family, block] = slid
    slip[SlipRow.warp_bending_spring + family, block] = spring
    slip[SlipRow.bending_friction_loss, block] = slip[SlipRow.bending_friction_loss, block] + lost
    return laws.bending.friction_stiffness[family] * spring


@wp.func
def bending_friction(laws: Any, block: int, m: Any, b: Any, slip: Any, r: Any):
    """Add friction to r."""
    two = b.k11.dtype(2.0)
    warp_moment = family_friction(laws, block, WARP, b.k11 / m.m11, slip)
    weft_moment = family_friction(laws, block, WEFT, b.k22 / m.m22, slip)
    r.moment11 = r.moment11 + warp_moment / m.m11
    r.moment22 = r.moment22 + weft_moment / m.m22
    r.t11 = r.t11 - two * warp_moment * b.k11 / (m.m11 * m.m11)
    r.t22 = r.t22 - two * weft_moment * b.k22 / (m.m22 * m.m22)
    return r


@wp.func
def bending_friction_energy(laws: Any, block: int, slip: Any):
    """psi of the springs before the sliders of warp and weft [J/m^2]."""
    warp = spring_energy(laws.bending.friction_stiffness[WARP], slip[SlipRow.warp_bending_spring, block])
    weft = spring_energy(laws.bending.friction_stiffness[WEFT], slip[SlipRow.weft_bending_spring, block])
    return warp, weft


# --- transverse shear -------------------------------------------------------------------------------------------------


@wp.func
def transverse_shear(laws: Any, m: Any, b: Any, r: Any):
    """Set Q = J G_s g raised by the inverse metric, and add T; the energy is 1/2 Q.g."""
    inverse_ratio = m.inverse_ratio
    inverse_square = inverse_ratio * inverse_ratio
    raised1 = (m.m22 * b.g1 - m.m12 * b.g2) * inverse_square
    raised2 = (m.m11 * b.g2 - m.m12 * b.g1) * inverse_square
    stiffness = laws.transverse_shear_stiffness * m.area_ratio
    force1 = stiffness * raised1
    force2 = stiffness * raised2
    energy = inverse_ratio.dtype(0.5) * (force1 * b.g1 + force2 * b.g2) * inverse_square
    r.t11 = r.t11 + (energy * m.m22 - force1 * raised1)
    r.t12 = r.t12 + (-(energy * m.m12) - force1 * raised2)
    r.t22 = r.t22 + (energy * m.m11 - force2 * raised2)
    r.shear_force1 = force1
    r.shear_force2 = force2
    return r
