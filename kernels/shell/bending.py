"""Bending without its law (docs/theory.md, section 4): resultants, friction in the bent yarns, and transverse shear.

m is a ``Membrane``, b a ``Bend``, r the ``Resultants`` that the functions fill or add to.
"""

from functools import cache
from typing import Any

import warp as wp

from ..curve import book_loss, slide, spring_energy
from ..lane_types import lane_types
from ..lanes import fill
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import SlipRow

# The two families of yarns.
WARP = 0
WEFT = 1


@cache
def bending_friction_struct(real: type):
    """Friction inside the bent yarns of both families, as a Warp struct."""

    @wp.struct
    class BendingFriction:
        stiffness: wp.types.vector(2, real)  # WARP, WEFT: of the springs in series with the sliders [N m], not zero
        limit: wp.types.vector(2, real)  # moment at which they slip [N]

    return BendingFriction


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


# --- friction inside the bent yarns of a family -----------------------------------------------------------------------


@wp.func
def family_friction(laws: Any, block: int, family: int, curvature: Any, slip: Any):
    """Moment [N] of the friction in a family, WARP or WEFT; writes its slip, its spring and the work lost."""
    limit = fill(curvature, laws.bending_friction.limit[family])
    slid, spring, lost = slide(
        curvature,
        slip[SlipRow.warp_bending_slip + family, block],
        slip[SlipRow.warp_bending_spring + family, block],
        laws.bending_friction.stiffness[family],
        limit,
        laws.slip_resolution,
    )
    slip[SlipRow.warp_bending_slip + family, block] = slid
    slip[SlipRow.warp_bending_spring + family, block] = spring
    book_loss(slip, SlipRow.bending_friction_loss, SlipRow.bending_friction_remainder, block, lost)
    return laws.bending_friction.stiffness[family] * spring


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
    warp = spring_energy(laws.bending_friction.stiffness[WARP], slip[SlipRow.warp_bending_spring, block])
    weft = spring_energy(laws.bending_friction.stiffness[WEFT], slip[SlipRow.weft_bending_spring, block])
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
