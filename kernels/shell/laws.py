"""What a sheet is made of: its traits, which choose the laws that a kernel holds, and its constants."""

from dataclasses import dataclass
from functools import cache

import warp as wp

from .bending import CURVED_BENDING, ISOTROPIC_BENDING, YARN_BENDING, BendingDevice, bending_struct
from .shear import CURVED_SHEAR, LINEAR_SHEAR, ShearDevice, shear_struct

SHEAR_LAWS: dict[str, ShearDevice] = {"linear": LINEAR_SHEAR, "curve": CURVED_SHEAR}
BENDING_LAWS: dict[str, BendingDevice] = {
    "isotropic": ISOTROPIC_BENDING,
    "yarns": YARN_BENDING,
    "curves": CURVED_BENDING,
}


@dataclass(frozen=True)
class SheetTraits:
    """What a sheet has and what not: kernels are made for it and hold no branch, and no code, of the rest.

    A branch costs more than its test: the lanes of all that lives on behind it are taken apart and put together again.

    Attributes:
        shear: one of SHEAR_LAWS.
        bending: one of BENDING_LAWS.
        shear_friction: between the yarns that turn on each other.
        bending_friction: inside the bent yarns of one family at least.
        follows_thickness: tools meet the current thickness.
        flat: all initial strains are zero.
        skewed: some element is no parallelogram.
    """

    shear: str = "curve"
    bending: str = "isotropic"
    shear_friction: bool = False
    bending_friction: bool = False
    follows_thickness: bool = False
    flat: bool = True
    skewed: bool = False


@cache
def sheet_struct(real: type):
    """Shear, bending and stabilisation constants in one precision, as a Warp struct."""

    @wp.struct
    class SheetLaws:
        shear: shear_struct(real)
        bending: bending_struct(real)
        transverse_shear_stiffness: real  # 5/6 G t [N/m]
        in_plane_bending_stiffness: real  # beta: resists a varying shear angle, psi = 1/2 beta |grad gamma|^2 [N m]
        compressive_stiffness: real  # of the sheet itself along a yarn that is pushed together [N/m]
        hourglass_in_plane: real  # factors of the sum of squared shape gradients: [N/m]
        hourglass_warping: real
        hourglass_director: real  # [N m]
        slip_resolution: real  # relative rounding of a slip
        thickness: real  # t_0 [m]
        thickening: real  # n of t = t_0 J^-n / (1 + p/E_c)
        inverse_crossover_modulus: real  # 1/E_c [1/Pa]

    return SheetLaws
