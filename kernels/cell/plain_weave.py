"""The plain-weave unit cell: warp beam, weft beam and contact element (docs/theory.md, section 2).

Energy of the half cell, per yarn k (1 = warp, 2 = weft), with chord X_k = L_k + u_k, H_k = h_k + w_k:

    Pi = sum_k [ 1/2 (EA_k/l0_k) (l_k - l0_k)^2 + 1/2 (3 EI_k/l0_k) phi_k^2 ] + 1/2 k_c (w_1 + w_2)^2

u_k is prescribed by the shell (yarn stretch), w_k is found by a safeguarded Newton iteration on dPi/dw = 0, whose
matrix is the Hessian of Pi, that is K = K_E + K_G, equation (2) of the paper without the prescribed rows of
equation (3). In compression the yarn is a buckled bundle: its axial stiffness is ``compressive_stiffness``.
"""

from functools import cache
from typing import Any

import warp as wp

from ..lanes import fill, from_rows, lane_maximum, larger, magnitude, smaller, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from .heights import contact_stiffness, regular_parts, rounded_closing, settled_closing, solve_unit_cell
from .law import CellLaw
from .yarn import yarn_axial_stiffness, yarn_forces, yarn_hessian, yarn_strain

# A height change in one step beyond this share of the crimp heights is a snap: the energy released is booked.
SNAP_SHARE = wp.constant(0.05)
ENERGY_NAMES = ("warp_axial", "weft_axial", "yarn_bending", "crossover_contact")


@cache
def unit_cell_struct(real: type):
    """Parameters of a plain-weave cell in one precision, as a Warp struct.

    Lengths and stiffnesses are in units of their own, powers of two: products of the legal ranges would leave that of
    single precision, and the powers change no digit.
    """

    @wp.struct
    class PlainWeave:
        length_unit: real  # [m]
        per_length_unit: real  # [1/m]
        stiffness_unit: real  # [N/m]
        per_width: wp.types.vector(2, real)  # n_1 and n_2 of a yarn force of one [N/m]
        per_area: real  # pressure of a crossover force of one [N/m^2]
        half_spacing: wp.types.vector(2, real)  # L_1, L_2
        crimp_height: wp.types.vector(2, real)  # h_1, h_2
        chord_length: wp.types.vector(2, real)  # l0_1, l0_2
        tensile_stiffness: wp.types.vector(2, real)  # EA / l0 in tension
        compressive_stiffness: wp.types.vector(2, real)  # EA_c / l0 in compression
        rotation_stiffness: wp.types.vector(2, real)  # 3 EI / l0, a stiffness times an area
        inverse_rotation_stiffness: wp.types.vector(2, real)  # 0 without bending stiffness
        contact_stiffness: real  # E_3 A_3 / L_3 of the half cell
        unilateral: wp.int32  # 1: the yarns may separate
        tolerance: real  # residual relative to the forces in balance
        resolution: real  # rounding of w_1 + w_2 over the sum of their sizes
        stiffness_floor: real  # of a slack yarn, in the Newton matrix only
        force_floor: real  # smallest reference force of the residual

    return PlainWeave


# --- energies and tangents at given heights ---------------------------------------------------------------------------


@wp.func
def unit_cell_energies(cell: Any, u1: Any, u2: Any, w: Any):
    """Energy of the half cell: axial of warp, axial of weft, bending of both yarns, contact."""
    half = u1.dtype(0.5)
    elongation1, rotation1, x1, h1, inverse_length1 = yarn_strain(cell, 0, u1, w[0])
    elongation2, rotation2, x2, h2, inverse_length2 = yarn_strain(cell, 1, u2, w[1])
    warp = half * yarn_axial_stiffness(cell, 0, elongation1) * elongation1 * elongation1
    weft = half * yarn_axial_stiffness(cell, 1, elongation2) * elongation2 * elongation2
    bending = half * (
        cell.rotation_stiffness[0] * rotation1 * rotation1 + cell.rotation_stiffness[1] * rotation2 * rotation2
    )
    closing = exact_closing(cell, u1, u2, w)
    contact = half * contact_stiffness(cell, closing) * closing * closing
    return warp, weft, bending, contact


@wp.func
def exact_closing(cell: Any, u1: Any, u2: Any, w: Any):
    """w_1 + w_2, where little is left of it by rounding that of a Newton step."""
    closing = rounded_closing(cell, w)
    by_u1, by_w1, hessian1, elastic1, size1, state1 = yarn_forces(cell, 0, u1, w[0])
    by_u2, by_w2, hessian2, elastic2, size2, state2 = yarn_forces(cell, 1, u2, w[1])
    stiffness = contact_stiffness(cell, closing)
    hessian = from_rows(hessian1, hessian2)
    own, definite = regular_parts(cell, hessian, from_rows(elastic1, elastic2), stiffness)
    inverse = fill(u1, 1.0) / larger(own[0] * own[1] + stiffness * (own[0] + own[1]), fill(u1, 1.0e-36))
    known = magnitude(closing) - u1.dtype(1.0e3) * cell.resolution * (magnitude(w[0]) + magnitude(w[1]))
    settled = settled_closing(own, inverse, from_rows(by_w1, by_w2), closing)
    return where_positive(known, closing, settled)


@wp.func
def unit_cell_descent(cell: Any, u1: Any, u2: Any, w: Any, change: Any):
    """-dPi/dw . change at (u, w)."""
    by_u1, by_w1, hessian1, elastic1, size1, state1 = yarn_forces(cell, 0, u1, w[0])
    by_u2, by_w2, hessian2, elastic2, size2, state2 = yarn_forces(cell, 1, u2, w[1])
    closing = w[0] + w[1]
    pressure = contact_stiffness(cell, closing) * closing
    return -(by_w1 * change[0] + by_w2 * change[1] + pressure * (change[0] + change[1]))


@wp.func
def condensed_tangent(cell: Any, u1: Any, u2: Any, w: Any, in_tension: bool):
    """(K11, K12, K22): d(F1, F2)/d(u1, u2) with w in equilibrium, H_uu - H_uw H_ww^-1 H_wu.

    ``in_tension`` gives the stiffness of the cell as soon as its yarns are pulled, for the stable step. Determinants of
    the yarns' own matrices come from their polar form, since H_uu and what is subtracted are often nearly equal.
    """
    uu1, uw1, ww1, determinant1 = yarn_hessian(cell, 0, u1, w[0], in_tension)
    uu2, uw2, ww2, determinant2 = yarn_hessian(cell, 1, u2, w[1], in_tension)
    stiffness = contact_stiffness(cell, rounded_closing(cell, w))
    determinant = ww1 * ww2 + stiffness * (ww1 + ww2)
    # straight yarns without bending stiffness: w has no stiffness and is not coupled to u
    free = magnitude(determinant) - fill(determinant, 1.0e-36)
    inverse = fill(determinant, 1.0) / where_positive(free, determinant, fill(determinant, 1.0))
    k11 = where_positive(free, determinant1 * ((ww2 + stiffness) * inverse) + uu1 * (stiffness * ww2 * inverse), uu1)
    k22 = where_positive(free, determinant2 * ((ww1 + stiffness) * inverse) + uu2 * (stiffness * ww1 * inverse), uu2)
    k12 = uw1 * uw2 * (stiffness * inverse)
    return k11, k12, k22


# --- the contract of kernels/cell/law.py, in SI units -----------------------------------------------------------------


@wp.func
def energy_unit(cell: Any):
    """Energy of a half cell of one over its area [J/m^2]."""
    return cell.per_area * cell.length_unit


@wp.func
def equilibrium(cell: Any, strain1: Any, strain2: Any, start: Any):
    """Height changes, n_1, n_2, pressure, energy, residual, iterations."""
    u1 = cell.half_spacing[0] * strain1
    u2 = cell.half_spacing[1] * strain2
    w, force, crossover, energy, residual, iterations, slopes = solve_unit_cell(
        cell, u1, u2, cell.per_length_unit * start
    )
    return (
        cell.length_unit * w,
        cell.per_width[0] * force[0],
        cell.per_width[1] * force[1],
        cell.per_area * crossover,
        (u1.dtype(0.5) * energy_unit(cell)) * energy,
        residual,
        iterations,
        slopes,
    )


# What follows are the functions of the law, as ``CellLaw`` describes them.


@wp.func
def solve(cell: Any, strain1: Any, strain2: Any, angle: Any, start: Any, answer: Any):
    w, n1, n2, pressure, energy, residual, iterations, slopes = equilibrium(cell, strain1, strain2, start)
    return type(answer)(n1, n2, fill(n1, 0.0), pressure, energy, residual, iterations, w, slopes)


@wp.func
def follow(cell: Any, change1: Any, change2: Any, turn: Any, slopes: Any, last: Any):
    """Heights to start from: those of the last step follow the strains, if they do not change as much as in a snap."""
    limit = fill(change1, change1.dtype(SNAP_SHARE) * cell.length_unit * (cell.crimp_height[0] + cell.crimp_height[1]))
    u1 = (cell.length_unit * cell.half_spacing[0]) * change1
    u2 = (cell.length_unit * cell.half_spacing[1]) * change2
    moved1 = slopes[0] * u1 + slopes[1] * u2
    moved2 = slopes[2] * u1 + slopes[3] * u2
    # not a number compares false
    near = smaller(limit - magnitude(moved1), limit - magnitude(moved2))
    zero = fill(change1, 0.0)
    return from_rows(last[0] + where_positive(near, moved1, zero), last[1] + where_positive(near, moved2, zero))


@wp.func
def energies(cell: Any, strain1: Any, strain2: Any, angle: Any, q: Any, area: Any):
    warp, weft, bending, contact = unit_cell_energies(
        cell, cell.half_spacing[0] * strain1, cell.half_spacing[1] * strain2, cell.per_length_unit * q
    )
    unit = energy_unit(cell) * area
    return from_rows(unit * warp, unit * weft, unit * bending, unit * contact)


@wp.func
def per_width(cell: Any, k11: Any, k12: Any, k22: Any):
    """C11, C12, C22 of dn = C dlambda from dF = K du [N/m]."""
    half = k11.dtype(0.5) * cell.stiffness_unit
    l1 = cell.half_spacing[0]
    l2 = cell.half_spacing[1]
    return (half * l1 / l2) * k11, half * k12, (half * l2 / l1) * k22


@wp.func
def tangent(cell: Any, strain1: Any, strain2: Any, angle: Any, q: Any, t: Any):
    k11, k12, k22 = condensed_tangent(
        cell, cell.half_spacing[0] * strain1, cell.half_spacing[1] * strain2, cell.per_length_unit * q, False
    )
    c11, c12, c22 = per_width(cell, k11, k12, k22)
    zero = fill(k11, 0.0)
    return type(t)(c11, c12, c22, zero, zero, zero, zero, zero, zero, zero)


@wp.func
def stable_tangent(cell: Any, strain1: Any, strain2: Any, angle: Any, q: Any, state: int, t: Any):
    solution, n1, n2, pressure, energy, residual, iterations, slopes = equilibrium(cell, strain1, strain2, q)
    k11, k12, k22 = condensed_tangent(
        cell, cell.half_spacing[0] * strain1, cell.half_spacing[1] * strain2, cell.per_length_unit * solution, True
    )
    c11, c12, c22 = per_width(cell, k11, k12, k22)
    zero = fill(k11, 0.0)
    return type(t)(c11, c12, c22, zero, zero, zero, n1, n2, zero, pressure)


@wp.func
def snap_loss(cell: Any, strain1: Any, strain2: Any, angle: Any, start: Any, q: Any):
    loss = fill(strain1, 0.0)
    before = cell.per_length_unit * start
    after = cell.per_length_unit * q
    change = after - before
    jump = larger(magnitude(change[0]), magnitude(change[1]))
    least = strain1.dtype(SNAP_SHARE) * (cell.crimp_height[0] + cell.crimp_height[1])
    if lane_maximum(jump) > least:
        u1 = cell.half_spacing[0] * strain1
        u2 = cell.half_spacing[1] * strain2
        warp_before, weft_before, bending_before, contact_before = unit_cell_energies(cell, u1, u2, before)
        warp_after, weft_after, bending_after, contact_after = unit_cell_energies(cell, u1, u2, after)
        freed = (
            (warp_before - warp_after)
            + (weft_before - weft_after)
            + (bending_before - bending_after)
            + (contact_before - contact_after)
        )
        snapped = jump - fill(jump, least)
        # a fast but steady change releases 1/2 dw.H dw, half of what its initial gradient predicts, and the work of
        # the forces includes that; a snap starts near an equilibrium and releases far more
        promised = unit_cell_descent(cell, u1, u2, before, change)
        snapped = where_positive(snapped, freed - promised, snapped)
        loss = where_positive(snapped, energy_unit(cell) * freed, loss)
    return loss


PLAIN_WEAVE = CellLaw(
    name="plain weave",
    parameters=unit_cell_struct,
    unknown_count=2,
    energy_names=ENERGY_NAMES,
    depends_on_shear=False,
    lane_by_lane=False,
    stable_state_count=1,
    solve=solve,
    energies=energies,
    tangent=tangent,
    stable_tangent=stable_tangent,
    follow=follow,
    slope_count=4,
    snap_loss=snap_loss,
)
