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

from ..lanes import fill, inverses, lane_maximum, larger, magnitude, smaller, where_positive
from ..operators import div, mul  # noqa: F401
from .law import MAXIMUM_ITERATIONS, CellLaw
from .yarn import (
    ELONGATION,
    MOMENT,
    STIFFNESS,
    yarn_axial_stiffness,
    yarn_expansion,
    yarn_forces,
    yarn_hessian,
    yarn_remainder,
    yarn_strain,
)

# A height change in one step beyond this share of the crimp heights is a snap: the energy released is booked.
SNAP_SHARE = wp.constant(0.05)
ENERGY_NAMES = ("warp_axial", "weft_axial", "yarn_bending", "crossover_contact")


@cache
def unit_cell_struct(real: type):
    """Parameters of a plain-weave cell in one precision, as a Warp struct."""

    @wp.struct
    class PlainWeave:
        half_spacing: wp.types.vector(2, real)  # L_1, L_2 [m]
        crimp_height: wp.types.vector(2, real)  # h_1, h_2 [m]
        chord_length: wp.types.vector(2, real)  # l0_1, l0_2 [m]
        tensile_stiffness: wp.types.vector(2, real)  # EA / l0 in tension [N/m]
        compressive_stiffness: wp.types.vector(2, real)  # EA_c / l0 in compression [N/m]
        rotation_stiffness: wp.types.vector(2, real)  # 3 EI / l0 [N m]
        inverse_rotation_stiffness: wp.types.vector(2, real)  # 0 without bending stiffness [1/(N m)]
        contact_stiffness: real  # E_3 A_3 / L_3 of the half cell [N/m]
        unilateral: wp.int32  # 1: the yarns may separate
        tolerance: real  # residual relative to the forces in balance
        resolution: real  # share of the cancelling parts of the elongation that counts as rounding of the residual
        stiffness_floor: real  # of a slack yarn, in the Newton matrix only [N/m]
        force_floor: real  # smallest reference force of the residual [N]

    return PlainWeave


@wp.func
def contact_active(cell: Any, closing: Any):
    """1 where the contact element carries force: everywhere if bilateral, in compression only if unilateral."""
    active = fill(closing, 1.0)
    if cell.unilateral == 1:
        active = where_positive(closing, active, fill(closing, 0.0))
    return active


# --- equilibrium of the heights; pairs of values are the rows (warp, weft) of a matrix --------------------------------


@wp.func
def yarn_pair(cell: Any, u1: Any, u2: Any, w: Any):
    """``yarn_forces`` of both: dPi/du, dPi/dw, d2Pi/dw2, its positive part, sizes; state of warp, state of weft."""
    by_u1, by_w1, hessian1, elastic1, size1, state1 = yarn_forces(cell, 0, u1, w[0])
    by_u2, by_w2, hessian2, elastic2, size2, state2 = yarn_forces(cell, 1, u2, w[1])
    return (
        wp.matrix_from_rows(by_u1, by_u2),
        wp.matrix_from_rows(by_w1, by_w2),
        wp.matrix_from_rows(hessian1, hessian2),
        wp.matrix_from_rows(elastic1, elastic2),
        wp.matrix_from_rows(size1, size2),
        state1,
        state2,
    )


@wp.func
def residual_size(sizes: Any, crossover: Any, least: Any):
    """Reference force of the residual [N]."""
    return larger(sizes[0], sizes[1]) + magnitude(crossover) + least


@wp.func
def regular_parts(cell: Any, hessian: Any, elastic: Any, stiffness: Any):
    """Yarn terms of a positive definite matrix; positive where no term had to be dropped for that."""
    # (h1 + k)(h2 + k) - k^2, written to avoid cancellation with a stiff contact
    determinant = hessian[0] * hessian[1] + stiffness * (hessian[0] + hessian[1])
    definite = smaller(determinant, hessian[0] + stiffness)
    # a slack yarn without bending stiffness has none: use the least that keeps the matrix regular
    floor = fill(stiffness, cell.stiffness_floor)
    own1 = where_positive(definite, hessian[0], elastic[0] + floor)
    own2 = where_positive(definite, hessian[1], elastic[1] + floor)
    return wp.matrix_from_rows(own1, own2), definite


@wp.func
def against(diagonal: Any, stiffness: Any, inverse: Any, force: Any):
    """-H^-1 force, for H with this diagonal, off-diagonal ``stiffness``, and 1/det H = ``inverse``."""
    return wp.matrix_from_rows(
        (stiffness * force[1] - diagonal[1] * force[0]) * inverse,
        (stiffness * force[0] - diagonal[0] * force[1]) * inverse,
    )


@wp.func
def energy_change(better: Any, gradient: Any, newton: Any, extra: Any):
    """Change of Pi in the last step, where it is taken, to the fourth order: 1/2 g d_1 + 1/3 g d_2 [J]."""
    half = better.dtype(0.5)
    third = better.dtype(1.0 / 3.0)
    change1 = gradient[0] * (half * newton[0] + third * extra[0])
    change2 = gradient[1] * (half * newton[1] + third * extra[1])
    return where_positive(better, change1 + change2, fill(better, 0.0))


@wp.func
def pair_expansion(cell: Any, state1: Any, state2: Any):
    """``yarn_expansion`` of both: uw, uww, www."""
    uw1, uww1, www1 = yarn_expansion(cell, 0, state1)
    uw2, uww2, www2 = yarn_expansion(cell, 1, state2)
    return wp.matrix_from_rows(uw1, uw2), wp.matrix_from_rows(uww1, uww2), wp.matrix_from_rows(www1, www2)


@wp.func
def third_order_step(cell: Any, state1: Any, state2: Any, diagonal: Any, stiffness: Any, inverse: Any, gradient: Any):
    """Newton's step, its correction from the third derivatives, and the derivatives uw, uww."""
    half = inverse.dtype(0.5)
    newton = against(diagonal, stiffness, inverse, gradient)
    uw, uww, www = pair_expansion(cell, state1, state2)
    bent = wp.matrix_from_rows(half * www[0] * newton[0] * newton[0], half * www[1] * newton[1] * newton[1])
    return newton, against(diagonal, stiffness, inverse, bent), uw, uww


@wp.func
def twice_squared_ratio(newton: Any, extra: Any):
    """Size of what the third derivatives add to Newton's step, over the size of that: twice its square."""
    added = magnitude(extra[0]) + magnitude(extra[1])
    ratio = added / (magnitude(newton[0]) + magnitude(newton[1]) + fill(added, 1.0e-37))
    return ratio.dtype(2.0) * ratio * ratio


@wp.func
def pair_remainder(cell: Any, state1: Any, state2: Any, w: Any, step: Any):
    """``yarn_remainder`` of both: change of dPi/dw in a step beyond the third derivatives, and change of the sizes."""
    beyond1, change1 = yarn_remainder(cell, 0, state1, step[0])
    beyond2, change2 = yarn_remainder(cell, 1, state2, step[1])
    beyond = beyond1 + beyond2
    if cell.unilateral == 1:
        closing = w[0] + w[1]
        closed = closing + step[0] + step[1]
        beyond = beyond + cell.contact_stiffness * larger(where_positive(-closing, closed, -closed), fill(closing, 0.0))
    return beyond, wp.matrix_from_rows(change1, change2)


@wp.func
def pair_energy(cell: Any, state1: Any, state2: Any, w: Any, crossover: Any):
    """Pi of the half cell where the states of its yarns were taken [J]."""
    closing = w[0] + w[1]
    bent1 = state1[MOMENT] * state1[MOMENT] * fill(closing, cell.inverse_rotation_stiffness[0])
    bent2 = state2[MOMENT] * state2[MOMENT] * fill(closing, cell.inverse_rotation_stiffness[1])
    drawn1 = state1[STIFFNESS] * state1[ELONGATION] * state1[ELONGATION]
    drawn2 = state2[STIFFNESS] * state2[ELONGATION] * state2[ELONGATION]
    return closing.dtype(0.5) * ((drawn1 + drawn2) + (bent1 + bent2) - crossover * closing)


@wp.func
def last_step(w: Any, step: Any, better: Any, by_u: Any, uw: Any, uww: Any):
    """Heights after the last step, which is taken where ``better`` > 0, and dPi/du there, to second order."""
    half = better.dtype(0.5)
    heights = type(w)()
    force = type(w)()
    for k in range(2):
        taken = where_positive(better, step[k], fill(better, 0.0))
        heights[k] = w[k] + taken
        force[k] = by_u[k] + (uw[k] + half * uww[k] * taken) * taken
    return heights, force


@wp.func
def safeguarded(cell: Any, gradient: Any, diagonal: Any, stiffness: Any, newton: Any, step: Any, slope: Any):
    """(change of w, its direction, slope along that) from Newton's step, the previous step and the slope at its start.

    A step is at most a quarter of the chord; if the previous one overshot, it is partly undone instead.
    """
    one = fill(slope, 1.0)
    limit1 = fill(slope, slope.dtype(0.25) * cell.chord_length[0])
    limit2 = fill(slope, slope.dtype(0.25) * cell.chord_length[1])
    shrink = smaller(
        one,
        smaller(
            limit1 / (magnitude(newton[0]) + slope.dtype(1.0e-3) * limit1),
            limit2 / (magnitude(newton[1]) + slope.dtype(1.0e-3) * limit2),
        ),
    )
    newton1 = shrink * newton[0]
    newton2 = shrink * newton[1]
    step1 = step[0]
    step2 = step[1]
    # overshoot of the previous step: a Newton step back along it, with the current stiffness
    rise = gradient[0] * step1 + gradient[1] * step2
    overshoot = rise + slope.dtype(0.5) * slope
    curvature = diagonal[0] * step1 * step1 + diagonal[1] * step2 * step2 + slope.dtype(2.0) * stiffness * step1 * step2
    back = smaller(larger(rise / larger(curvature, fill(rise, 1.0e-37)), fill(rise, 0.0625)), fill(rise, 0.9375))
    change1 = where_positive(overshoot, -(back * step1), newton1)
    change2 = where_positive(overshoot, -(back * step2), newton2)
    new1 = where_positive(overshoot, (one - back) * step1, newton1)
    new2 = where_positive(overshoot, (one - back) * step2, newton2)
    new_slope = where_positive(overshoot, (one - back) * slope, gradient[0] * newton1 + gradient[1] * newton2)
    return wp.matrix_from_rows(change1, change2), wp.matrix_from_rows(new1, new2), new_slope


@wp.func
def solve_unit_cell(cell: Any, u1: Any, u2: Any, start: Any):
    """Height changes w that make Pi stationary, by Newton's method from ``start``.

    The last step is of third order (Chebyshev's: Newton's step d, minus H^-1 Pi_www d d/2), without an evaluation
    after it: the forces are extrapolated to second order. A step is the last as soon as the estimated residual after it
    is within the tolerance; from one time step to the next that is usually the first.

    Safeguards, all per lane: where the Hessian is not positive definite its geometric part is dropped; a step is at
    most a quarter of the chord; a step that overshoots (the directional derivative changes sign and keeps more than
    half its size) is partly undone, by a Newton step along it, so that the point stays between two known slopes.

    Returns w, dPi/du, crossover force of the half cell, Pi, relative residual, iterations.
    """
    w = start
    zero = fill(u1, 0.0)
    step = type(start)()
    slope = zero  # directional derivative at the start of the step, <= 0
    force = type(start)()
    energy = zero
    stiffness = zero
    residual = fill(u1, 1.0)
    iterations = zero
    for iteration in range(MAXIMUM_ITERATIONS + 1):
        by_u, by_w, hessian, elastic, sizes, state1, state2 = yarn_pair(cell, u1, u2, w)
        stiffness = cell.contact_stiffness * contact_active(cell, -(w[0] + w[1]))
        crossover = -(stiffness * (w[0] + w[1]))
        gradient = wp.matrix_from_rows(by_w[0] - crossover, by_w[1] - crossover)
        least = fill(u1, cell.force_floor) + cell.resolution * stiffness * (magnitude(w[0]) + magnitude(w[1]))
        size = residual_size(sizes, crossover, least)
        own, definite = regular_parts(cell, hessian, elastic, stiffness)
        diagonal = wp.matrix_from_rows(own[0] + stiffness, own[1] + stiffness)
        inverse, inverse_size = inverses(own[0] * own[1] + stiffness * (own[0] + own[1]), size)
        residual = larger(magnitude(gradient[0]), magnitude(gradient[1])) * inverse_size
        newton, extra, uw, uww = third_order_step(cell, state1, state2, diagonal, stiffness, inverse, gradient)
        last = newton + extra
        # residual after both: the ratio of the two parts once more, and terms beyond the third derivatives
        beyond, changes = pair_remainder(cell, state1, state2, w, last)
        size_after = residual_size(sizes + changes, crossover - stiffness * (last[0] + last[1]), least)
        remainder = (residual * size * twice_squared_ratio(newton, extra) + beyond) / smaller(size, size_after)
        better = where_positive(definite, residual - remainder, zero)
        remainder = where_positive(better, remainder, residual)
        # a NaN compares false and is caught by the caller; it must not stall the other lanes
        unfinished = where_positive(remainder - fill(u1, cell.tolerance), fill(u1, 1.0), zero)
        if iteration == MAXIMUM_ITERATIONS or lane_maximum(unfinished) == u1.dtype(0.0):
            energy = pair_energy(cell, state1, state2, w, crossover) + energy_change(better, gradient, newton, extra)
            w, force = last_step(w, last, better, by_u, uw, uww)
            residual = remainder
            break
        iterations = iterations + unfinished
        change, step, slope = safeguarded(cell, gradient, diagonal, stiffness, newton, step, slope)
        for k in range(2):
            w[k] = where_positive(unfinished, w[k] + change[k], w[k])
    return w, force, -(stiffness * (w[0] + w[1])), energy, residual, iterations


@wp.func
def unit_cell_energies(cell: Any, u1: Any, u2: Any, w1: Any, w2: Any):
    """Energy of the half cell [J]: axial of warp, axial of weft, bending of both yarns, contact."""
    half = u1.dtype(0.5)
    elongation1, rotation1, x1, h1, inverse_length1, parts1 = yarn_strain(cell, 0, u1, w1)
    elongation2, rotation2, x2, h2, inverse_length2, parts2 = yarn_strain(cell, 1, u2, w2)
    warp = half * yarn_axial_stiffness(cell, 0, elongation1) * elongation1 * elongation1
    weft = half * yarn_axial_stiffness(cell, 1, elongation2) * elongation2 * elongation2
    bending = half * (
        cell.rotation_stiffness[0] * rotation1 * rotation1 + cell.rotation_stiffness[1] * rotation2 * rotation2
    )
    contact = half * cell.contact_stiffness * contact_active(cell, -(w1 + w2)) * (w1 + w2) * (w1 + w2)
    return warp, weft, bending, contact


@wp.func
def unit_cell_descent(cell: Any, u1: Any, u2: Any, w1: Any, w2: Any, change1: Any, change2: Any):
    """-dPi/dw . change at (u, w) [J]."""
    by_u1, by_w1, hessian1, elastic1, size1, state1 = yarn_forces(cell, 0, u1, w1)
    by_u2, by_w2, hessian2, elastic2, size2, state2 = yarn_forces(cell, 1, u2, w2)
    closing = cell.contact_stiffness * contact_active(cell, -(w1 + w2)) * (w1 + w2)
    return -((by_w1 + closing) * change1 + (by_w2 + closing) * change2)


@wp.func
def condensed_tangent(cell: Any, u1: Any, u2: Any, w1: Any, w2: Any, in_tension: bool):
    """(K11, K12, K22) [N/m]: d(F1, F2)/d(u1, u2) with w in equilibrium, H_uu - H_uw H_ww^-1 H_wu.

    ``in_tension`` gives the stiffness of the cell as soon as its yarns are pulled, for the stable step.
    """
    uu1, uw1, ww1 = yarn_hessian(cell, 0, u1, w1, in_tension)
    uu2, uw2, ww2 = yarn_hessian(cell, 1, u2, w2, in_tension)
    stiffness = cell.contact_stiffness * contact_active(cell, -(w1 + w2))
    determinant = ww1 * ww2 + stiffness * (ww1 + ww2)
    # straight yarns without bending stiffness: w has no stiffness and is not coupled to u
    determinant = where_positive(magnitude(determinant), determinant, fill(determinant, 1.0))
    k11 = uu1 - uw1 * uw1 * (ww2 + stiffness) / determinant
    k22 = uu2 - uw2 * uw2 * (ww1 + stiffness) / determinant
    k12 = uw1 * uw2 * stiffness / determinant
    return k11, k12, k22


# --- the contract of kernels/cell/law.py


@wp.func
def equilibrium(cell: Any, strain1: Any, strain2: Any, start: Any):
    """Height changes, n_1, n_2, pressure, energy, residual, iterations."""
    u1 = cell.half_spacing[0] * strain1
    u2 = cell.half_spacing[1] * strain2
    w, force, crossover, energy, residual, iterations = solve_unit_cell(cell, u1, u2, start)
    half = u1.dtype(0.5)
    return (
        w,
        (half / cell.half_spacing[1]) * force[0],
        (half / cell.half_spacing[0]) * force[1],
        (half / (cell.half_spacing[0] * cell.half_spacing[1])) * crossover,
        (half / (cell.half_spacing[0] * cell.half_spacing[1])) * energy,
        residual,
        iterations,
    )


@wp.func
def solve(cell: Any, strain1: Any, strain2: Any, angle: Any, start: Any, answer: Any):
    w, n1, n2, pressure, energy, residual, iterations = equilibrium(cell, strain1, strain2, start)
    return type(answer)(n1, n2, fill(n1, 0.0), pressure, energy, residual, iterations, w)


@wp.func
def energies(cell: Any, strain1: Any, strain2: Any, angle: Any, q: Any, area: Any):
    warp, weft, bending, contact = unit_cell_energies(
        cell, cell.half_spacing[0] * strain1, cell.half_spacing[1] * strain2, q[0], q[1]
    )
    cells = area / fill(area, area.dtype(2.0) * cell.half_spacing[0] * cell.half_spacing[1])
    return wp.matrix_from_rows(cells * warp, cells * weft, cells * bending, cells * contact)


@wp.func
def per_width(cell: Any, k11: Any, k12: Any, k22: Any):
    """C11, C12, C22 of dn = C dlambda from dF = K du [N/m]."""
    half = k11.dtype(0.5)
    l1 = cell.half_spacing[0]
    l2 = cell.half_spacing[1]
    return (half * l1 / l2) * k11, half * k12, (half * l2 / l1) * k22


@wp.func
def tangent(cell: Any, strain1: Any, strain2: Any, angle: Any, q: Any, t: Any):
    k11, k12, k22 = condensed_tangent(
        cell, cell.half_spacing[0] * strain1, cell.half_spacing[1] * strain2, q[0], q[1], False
    )
    c11, c12, c22 = per_width(cell, k11, k12, k22)
    zero = fill(k11, 0.0)
    return type(t)(c11, c12, c22, zero, zero, zero, zero, zero, zero, zero)


@wp.func
def stable_tangent(cell: Any, strain1: Any, strain2: Any, angle: Any, q: Any, state: int, t: Any):
    solution, n1, n2, pressure, energy, residual, iterations = equilibrium(cell, strain1, strain2, q)
    k11, k12, k22 = condensed_tangent(
        cell, cell.half_spacing[0] * strain1, cell.half_spacing[1] * strain2, solution[0], solution[1], True
    )
    c11, c12, c22 = per_width(cell, k11, k12, k22)
    zero = fill(k11, 0.0)
    return type(t)(c11, c12, c22, zero, zero, zero, n1, n2, zero, pressure)


@wp.func
def snap_loss(cell: Any, strain1: Any, strain2: Any, angle: Any, start: Any, q: Any):
    loss = fill(strain1, 0.0)
    change1 = q[0] - start[0]
    change2 = q[1] - start[1]
    jump = larger(magnitude(change1), magnitude(change2))
    least = strain1.dtype(SNAP_SHARE) * (cell.crimp_height[0] + cell.crimp_height[1])
    if lane_maximum(jump) > least:
        u1 = cell.half_spacing[0] * strain1
        u2 = cell.half_spacing[1] * strain2
        warp_before, weft_before, bending_before, contact_before = unit_cell_energies(cell, u1, u2, start[0], start[1])
        warp_after, weft_after, bending_after, contact_after = unit_cell_energies(cell, u1, u2, q[0], q[1])
        freed = (
            (warp_before - warp_after)
            + (weft_before - weft_after)
            + (bending_before - bending_after)
            + (contact_before - contact_after)
        )
        snapped = jump - fill(jump, least)
        # a fast but steady change releases 1/2 dw.H dw, half of what its initial gradient predicts, and the work of
        # the forces includes that; a snap starts near an equilibrium and releases far more
        promised = unit_cell_descent(cell, u1, u2, start[0], start[1], change1, change2)
        snapped = where_positive(snapped, freed - promised, snapped)
        density = freed / fill(freed, freed.dtype(2.0) * cell.half_spacing[0] * cell.half_spacing[1])
        loss = where_positive(snapped, density, loss)
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
    snap_loss=snap_loss,
)
