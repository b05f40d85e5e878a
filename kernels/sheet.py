"""Laws of the sheet beside the unit cell: in-plane shear, bending, transverse shear, stabilisation (theory, 3-5).

Symbols, per element and with one value per lane: a1, a2 the convected yarn vectors; m11, m12, m22 their metric;
area_ratio J = |a1 x a2|; k11, k12, k22 the curvatures; g1, g2 the transverse shears. Resultants are per reference area:
T the part of dpsi/da_alpha along a_beta, M the moments, Q the transverse shear forces.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

from .curve import curve_energy, curve_size, curve_struct, odd_curve, slide
from .lanes import div, fill, larger, mul, power, spread, where_positive

BENDING_ISOTROPIC = wp.constant(0)
BENDING_YARNS = wp.constant(1)
BENDING_CURVES = wp.constant(2)
# Rows of what friction inside the sheet remembers: slip and spring of the sliders, and the work lost in them [J/m^2].
SLIP_ROWS = (
    "shear_slip",
    "warp_bending_slip",
    "weft_bending_slip",
    "shear_spring",
    "warp_bending_spring",
    "weft_bending_spring",
    "shear_friction_loss",
    "bending_friction_loss",
)
SHEAR_SLIP_ROW = wp.constant(0)
BENDING_SLIP_ROW = wp.constant(1)
SHEAR_SPRING_ROW = wp.constant(3)
BENDING_SPRING_ROW = wp.constant(4)
SHEAR_LOSS_ROW = wp.constant(6)
BENDING_LOSS_ROW = wp.constant(7)


@dataclass(frozen=True)
class SheetTraits:
    """What a sheet has and what not: kernels are made for it and hold no branch, and no code, of the rest.

    A branch costs more than its test: the lanes of all that lives on behind it are taken apart and put together again.

    Attributes:
        curved_shear: the shear moment is a curve over the angle; False: the linear law.
        bending: BENDING_ISOTROPIC, BENDING_YARNS or BENDING_CURVES.
        shear_friction: between the yarns that turn on each other.
        bending_friction: inside the bent yarns of one family at least.
        follows_thickness: tools meet the current thickness.
        flat: all initial strains are zero.
        skewed: some element is no parallelogram.
    """

    curved_shear: bool = True
    bending: int = int(BENDING_ISOTROPIC)
    shear_friction: bool = False
    bending_friction: bool = False
    follows_thickness: bool = False
    flat: bool = True
    skewed: bool = False


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
def bending_struct(real: type):
    """Constants of bending in one precision, as a Warp struct."""

    @wp.struct
    class BendingLaw:
        stiffness: real  # D [N m]
        poisson_ratio: real
        yarn_stiffness: wp.types.vector(4, real)  # D_1, D_2, D_12, coupling D_nu [N m]
        warp_curve: curve_struct(real)  # moment over curvature [N]
        weft_curve: curve_struct(real)
        friction_stiffness: wp.types.vector(2, real)  # of the springs before the sliders [N m], not zero
        friction_limit: wp.types.vector(2, real)  # moment that makes them slip [N]

    return BendingLaw


@cache
def sheet_struct(real: type):
    """Shear, bending and stabilisation constants in one precision, as a Warp struct."""

    @wp.struct
    class SheetLaws:
        shear: shear_struct(real)
        bending: bending_struct(real)
        transverse_shear_stiffness: real  # 5/6 G t [N/m]
        in_plane_bending_stiffness: real  # B: resists a varying shear angle, psi = 1/2 B |grad gamma|^2 [N m]
        compressive_stiffness: real  # of the sheet itself along a yarn that is pushed together [N/m]
        hourglass_in_plane: real  # factors of the sum of squared shape gradients: [N/m]
        hourglass_warping: real
        hourglass_director: real  # [N m]
        slip_resolution: real  # relative rounding of a slip
        thickness: real  # t_0 [m]
        thickening: real  # n of t = t_0 J^-n / (1 + p/E_c)
        inverse_crossover_modulus: real  # 1/E_c [1/Pa]

    return SheetLaws


# --- in-plane shear ---------------------------------------------------------------------------------------------------


@wp.func
def moment_resultants(moment: Any, m11: Any, m12: Any, m22: Any, area_ratio: Any):
    """T11, T12, T22 of a moment m = dpsi/dgamma: dgamma/da_1 = (a_2 - a_1 m12/m11)/J, likewise for a_2."""
    t12 = moment / area_ratio
    return -(t12 * m12 / m11), t12, -(t12 * m12 / m22)


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


# --- compression ------------------------------------------------------------------------------------------------------


@wp.func
def compressive_force(laws: Any, stretch: Any):
    """Resistance of the sheet itself to a yarn that is pushed together [N/m]; psi = 1/2 k min(stretch - 1, 0)^2."""
    shortening = stretch - fill(stretch, 1.0)
    return laws.compressive_stiffness * where_positive(shortening, fill(stretch, 0.0), shortening)


# --- thickness --------------------------------------------------------------------------------------------------------


@wp.func
def current_thickness(laws: Any, area_ratio: Any, crossover_pressure: Any):
    """t = t_0 J^-n / (1 + p/E_c) [m], with the pressure p of the crossovers."""
    pressed = where_positive(crossover_pressure, crossover_pressure, fill(area_ratio, 0.0))
    flattened = fill(area_ratio, 1.0) + laws.inverse_crossover_modulus * pressed
    return laws.thickness * power(area_ratio, -laws.thickening) / flattened


# --- bending and transverse shear -------------------------------------------------------------------------------------


@wp.func
def bending_moments(laws: Any, kind: int, m11: Any, m12: Any, m22: Any, area_ratio: Any, k11: Any, k12: Any, k22: Any):
    """M11, M12, M22 and T11, T12, T22 of bending.

    Isotropic: M = J D [(1-nu) k + nu a tr k] in the current metric, equation (6) of the paper, with k raised by the
    inverse metric; T = a (psi + 2 J D (1-nu) det k) - 2 J D tr(k) k is the derivative by the metric.
    Yarns: psi = 1/2 sum D_a (k_aa/m_aa)^2 + D_nu k_11 k_22/(m_11 m_22) + 2 D_12 k_12^2/(m_11 m_22).
    Curves: the same with the integral of a family's moment over k_aa/m_aa in place of 1/2 D_a (k_aa/m_aa)^2.
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
    if kind == BENDING_ISOTROPIC:
        inverse_ratio = one / area_ratio
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
def spring_energy(stiffness: Any, spring: Any):
    """psi of the spring before a slider [J/m^2]."""
    return (spring.dtype(0.5) * stiffness) * (spring * spring)


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
