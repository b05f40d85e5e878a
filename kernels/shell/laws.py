"""Laws of the sheet beside the unit cell: in-plane shear, bending, transverse shear, stabilisation (theory, 3-5).

Symbols, per element and with one value per lane: a1, a2 the convected yarn vectors; m11, m12, m22 their metric;
area_ratio J = |a1 x a2|; k11, k12, k22 the curvatures; g1, g2 the transverse shears. Resultants are per reference area:
T the part of dpsi/da_alpha along a_beta, M the moments, Q the transverse shear forces.
"""

from dataclasses import dataclass
from functools import cache

import warp as wp

from ..curve import curve_struct

BENDING_ISOTROPIC = wp.constant(0)
BENDING_YARNS = wp.constant(1)
BENDING_CURVES = wp.constant(2)


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
