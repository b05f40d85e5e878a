"""Laws of the sheet beside the unit cell: in-plane shear, bending, transverse shear, stabilisation (theory, 3-5).

Symbols, per element and with one value per lane: a1, a2 the convected yarn vectors; m11, m12, m22 their metric;
area_ratio J = |a1 x a2|; k11, k12, k22 the curvatures; g1, g2 the transverse shears. Resultants are per reference area:
T the part of dpsi/da_alpha along a_beta, M the moments, Q the transverse shear forces.
"""

from functools import cache
from typing import Any

import warp as wp

from .lanes import div, fill, magnitude, mul, spread, where_positive

SHEAR_LINEAR = wp.constant(0)
SHEAR_CURVE = wp.constant(1)
BENDING_ISOTROPIC = wp.constant(0)
BENDING_YARNS = wp.constant(1)


@cache
def sheet_struct(real: type):
    """Shear, bending and stabilisation constants in one precision, as a Warp struct."""

    @wp.struct
    class SheetLaws:
        shear_kind: wp.int32
        shear_stiffness: real  # t G_12 of the linear law [N/m]
        shear_knot_spacing: real  # of the moment curve [rad]
        shear_moment: wp.array(dtype=wp.types.vector(4, real))  # cubic between knots: m = c0 + c1 x + c2 x^2 + c3 x^3
        shear_energy: wp.array(dtype=real)  # psi at the knots [J/m^2]
        bending_kind: wp.int32
        bending_stiffness: real  # D [N m]
        poisson_ratio: real
        yarn_bending_stiffness: wp.types.vector(4, real)  # D_1, D_2, D_12, coupling D_nu [N m]
        transverse_shear_stiffness: real  # 5/6 G t [N/m]
        in_plane_bending_stiffness: real  # B: resists a varying shear angle, psi = 1/2 B |grad gamma|^2 [N m]
        compressive_stiffness: real  # of the sheet itself along a yarn that is pushed together [N/m]
        hourglass_in_plane: real  # factors of the sum of squared shape gradients: [N/m]
        hourglass_warping: real
        hourglass_director: real  # [N m]

    return SheetLaws


# --- in-plane shear ---------------------------------------------------------------------------------------------------


@wp.func
def curve_piece(laws: Any, angle: Any):
    """Piece of the moment curve that holds one angle, and how far into it the angle lies."""
    size = wp.abs(angle)
    # clamped from below too: a NaN becomes the most negative integer
    piece = wp.clamp(int(size / laws.shear_knot_spacing), 0, laws.shear_moment.shape[0] - 1)
    return piece, size - type(angle)(piece) * laws.shear_knot_spacing


@wp.func
def shear_moment(laws: Any, angle: Any):
    """(m, dm/dgamma) of the moment curve, odd in the angle [N/m]."""
    moment = type(angle)()
    tangent = type(angle)()
    for i in range(len(angle)):
        piece, x = curve_piece(laws, angle[i])
        c = laws.shear_moment[piece]
        value = c[0] + x * (c[1] + x * (c[2] + x * c[3]))
        moment[i] = wp.where(angle[i] < angle.dtype(0.0), -value, value)
        tangent[i] = c[1] + x * (angle.dtype(2.0) * c[2] + angle.dtype(3.0) * x * c[3])
    return moment, tangent


@wp.func
def shear_curve_energy(laws: Any, angle: Any):
    """psi(gamma), the integral of the moment curve [J/m^2]."""
    energy = type(angle)()
    for i in range(len(angle)):
        piece, x = curve_piece(laws, angle[i])
        c = laws.shear_moment[piece]
        energy[i] = laws.shear_energy[piece] + x * (
            c[0] + x * (c[1] / angle.dtype(2.0) + x * (c[2] / angle.dtype(3.0) + x * c[3] / angle.dtype(4.0)))
        )
    return energy


@wp.func
def moment_resultants(moment: Any, m11: Any, m12: Any, m22: Any, area_ratio: Any):
    """T11, T12, T22 of a moment m = dpsi/dgamma: dgamma/da_1 = (a_2 - a_1 m12/m11)/J, likewise for a_2."""
    t12 = moment / area_ratio
    return -(t12 * m12 / m11), t12, -(t12 * m12 / m22)


@wp.func
def shear_resultants(laws: Any, m11: Any, m12: Any, m22: Any, area_ratio: Any, angle: Any):
    """T11, T12, T22 of in-plane shear.

    Curve: dpsi/da_1 = m dgamma/da_1. Linear: S_12 = G_12 E_12 with E_12 = 1/2 a_1.a_2, equation (4) of the paper.
    """
    t11 = fill(m11, 0.0)
    t22 = fill(m11, 0.0)
    t12 = fill(m11, 0.0)
    if laws.shear_kind == SHEAR_LINEAR:
        t12 = m11.dtype(0.5) * laws.shear_stiffness * m12
    else:
        moment, tangent = shear_moment(laws, angle)
        t11, t12, t22 = moment_resultants(moment, m11, m12, m22, area_ratio)
    return t11, t12, t22


@wp.func
def shear_energy(laws: Any, m12: Any, angle: Any):
    """psi of in-plane shear [J/m^2]; linear law: t G_12 E_12^2."""
    energy = m12.dtype(0.25) * laws.shear_stiffness * m12 * m12
    if laws.shear_kind == SHEAR_CURVE:
        energy = shear_curve_energy(laws, angle)
    return energy


@wp.func
def shear_tangent_bound(laws: Any, m11: Any, m12: Any, m22: Any, area_ratio: Any, angle: Any):
    """Upper bound of the shear stiffness per squared change of angle [N/m]: material tangent and moment times tan."""
    bound = fill(m11, 0.0)
    if laws.shear_kind == SHEAR_LINEAR:
        bound = m11.dtype(0.5) * laws.shear_stiffness * (m11 * m22 + magnitude(m12))
    else:
        moment, tangent = shear_moment(laws, angle)
        bound = where_positive(tangent, tangent, fill(m11, 0.0)) + magnitude(moment) * (
            fill(m11, 1.0) + magnitude(m12) / area_ratio
        )
    return bound


# --- compression ------------------------------------------------------------------------------------------------------


@wp.func
def compressive_force(laws: Any, stretch: Any):
    """Resistance of the sheet itself to a yarn that is pushed together [N/m]; psi = 1/2 k min(stretch - 1, 0)^2."""
    shortening = stretch - fill(stretch, 1.0)
    return laws.compressive_stiffness * where_positive(shortening, fill(stretch, 0.0), shortening)


# --- bending and transverse shear -------------------------------------------------------------------------------------


@wp.func
def bending_moments(laws: Any, m11: Any, m12: Any, m22: Any, area_ratio: Any, k11: Any, k12: Any, k22: Any):
    """M11, M12, M22 and T11, T12, T22 of bending; the energy is 1/2 M.k.

    Isotropic: M = J D [(1-nu) k + nu a tr k] in the current metric, equation (6) of the paper, with k raised by the
    inverse metric; T = a (psi + 2 J D (1-nu) det k) - 2 J D tr(k) k is the derivative by the metric.
    Yarns: psi = 1/2 sum D_a (k_aa/m_aa)^2 + D_nu k_11 k_22/(m_11 m_22) + 2 D_12 k_12^2/(m_11 m_22).
    """
    two = m11.dtype(2.0)
    half = m11.dtype(0.5)
    one = fill(m11, 1.0)
    moment11 = fill(m11, 0.0)
    moment12 = fill(m11, 0.0)
    moment22 = fill(m11, 0.0)
    t11 = fill(m11, 0.0)
    t12 = fill(m11, 0.0)
    t22 = fill(m11, 0.0)
    if laws.bending_kind == BENDING_ISOTROPIC:
        inverse_ratio = one / area_ratio
        inverse_square = inverse_ratio * inverse_ratio
        twisting = m11.dtype(1.0) - laws.poisson_ratio
        trace = (m22 * k11 - two * m12 * k12 + m11 * k22) * inverse_square
        determinant = (k11 * k22 - k12 * k12) * inverse_square
        stiffness = laws.bending_stiffness * inverse_ratio
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
        stiffness1 = laws.yarn_bending_stiffness[0]
        stiffness2 = laws.yarn_bending_stiffness[1]
        stiffness12 = laws.yarn_bending_stiffness[2]
        coupling = spread(m11, laws.yarn_bending_stiffness[3]) / (m11 * m22)
        moment11 = stiffness1 * k11 / (m11 * m11) + coupling * k22
        moment12 = two * stiffness12 * k12 / (m11 * m22)
        moment22 = stiffness2 * k22 / (m22 * m22) + coupling * k11
        t11 = -(two * (moment11 * k11 + moment12 * k12) / m11)
        t22 = -(two * (moment22 * k22 + moment12 * k12) / m22)
    return moment11, moment12, moment22, t11, t12, t22


@wp.func
def transverse_shear_forces(laws: Any, m11: Any, m12: Any, m22: Any, area_ratio: Any, g1: Any, g2: Any):
    """Q1, Q2 and T11, T12, T22 of transverse shear, Q = J G_s g raised by the inverse metric; the energy is 1/2 Q.g."""
    inverse_square = fill(m11, 1.0) / (area_ratio * area_ratio)
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
