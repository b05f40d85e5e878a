"""Traits of a sheet, which select the laws compiled into a kernel, and its constants."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import warp as wp

from ..cell.law import CellLaw
from ..laws import isotropic_bending, moment_curve
from ..laws.contract import device_law
from .bending import bending_friction_struct
from .kinematics import element_struct


@dataclass(frozen=True)
class SheetTraits:
    """Features of a sheet: kernels are generated for them, without branches or code for other features.

    A branch costs more than its test: the lanes of all values that are live after it are split and reassembled.

    Attributes:
        shear, bending: modules of the laws, see kernels/laws/contract.py.
        shear_friction: module of the friction between yarns that rotate on each other; "" without.
        bending_friction: whether the bent yarns of at least one family have internal friction.
        follows_thickness: contact with tools uses the current thickness.
        flat: all initial strains are zero.
        skewed: some element is not a parallelogram.
    """

    shear: str = moment_curve.__name__
    bending: str = isotropic_bending.__name__
    shear_friction: str = ""
    bending_friction: bool = False
    follows_thickness: bool = False
    flat: bool = True
    skewed: bool = False


@cache
def no_law_struct():
    """Placeholder for the constants of a law that a sheet does not have."""

    @wp.struct
    class NoLaw:
        unused: wp.int32

    return NoLaw


def sheet_laws_struct(real: type, traits: SheetTraits):
    """Constants of a sheet's laws and stabilisation in one precision, as a Warp struct."""
    ShearLaw, BendingLaw = (device_law(module).parameters(real) for module in (traits.shear, traits.bending))
    friction = traits.shear_friction
    FrictionLaw = device_law(friction).parameters(real) if friction else no_law_struct()
    return _sheet_laws_struct(real, ShearLaw, FrictionLaw, BendingLaw)


@cache
def _sheet_laws_struct(real: type, ShearLaw: Any, FrictionLaw: Any, BendingLaw: Any):
    @wp.struct
    class SheetLaws:
        shear: ShearLaw
        shear_friction: FrictionLaw
        bending: BendingLaw
        bending_friction: bending_friction_struct(real)
        transverse_shear_stiffness: real  # 5/6 G t [N/m]
        in_plane_bending_stiffness: real  # beta: resists a varying shear angle, psi = 1/2 beta |grad gamma|^2 [N m]
        compressive_stiffness: real  # of the sheet itself along a yarn in compression [N/m]
        hourglass_in_plane: real  # factors of the sum of squared shape gradients: [N/m]
        hourglass_warping: real
        hourglass_director: real  # [N m]
        slip_resolution: real  # relative rounding of a slip
        thickness: real  # t_0 [m]
        thickening: real  # n of t = t_0 J^-n / (1 + p/E_c)
        inverse_crossover_modulus: real  # 1/E_c [1/Pa]

    return SheetLaws


def sheet_struct(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """All that is constant of a sheet's elements, as a Warp struct."""
    return _sheet_struct(element_struct(real, lane_count), cell.parameters(real), sheet_laws_struct(real, traits))


@cache
def _sheet_struct(Elements: Any, UnitCell: Any, SheetLaws: Any):
    @wp.struct
    class Sheet:
        elements: Elements
        cell: UnitCell
        laws: SheetLaws

    return Sheet
