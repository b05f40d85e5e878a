"""The plain-weave unit cell: warp beam, weft beam and contact element (docs/theory.md, section 2).

Energy of the half cell, per yarn k (1 = warp, 2 = weft), with chord X_k = L_k + u_k, H_k = h_k + w_k:

    Pi = sum_k [ 1/2 (EA_k/l0_k) (l_k - l0_k)^2 + 1/2 (3 EI_k/l0_k) phi_k^2 ] + 1/2 k_c (w_1 + w_2)^2

u_k is prescribed by the shell (yarn stretch), w_k is found by a safeguarded Newton iteration on dPi/dw = 0, whose
matrix is the Hessian of Pi, that is K = K_E + K_G, equation (2) of the paper after the prescribed rows of equation (3)
are taken out. In compression the yarn is a buckled bundle: its axial stiffness is ``compressive_stiffness``.
"""

from functools import cache
from typing import Any

import warp as wp

from ..lanes import angle_of, fill, inverses, lane_maximum, larger, magnitude, smaller, square_root, where_positive
from ..operators import div, mul  # noqa: F401
from .law import CellLaw

MAXIMUM_ITERATIONS = 40
# A height change in one step beyond this share of the crimp heights is a snap: the energy that it frees is booked.
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
        contact_stiffness: real  # E_3 A_3 / L_3 of the half cell [N/m]
        unilateral: wp.int32  # 1: the yarns may separate
        tolerance: real  # residual relative to the forces that it balances
        resolution: real  # share of the cancelling parts of the elongation that counts as size of the residual
        stiffness_floor: real  # of a slack yarn, in the Newton matrix only [N/m]
        force_floor: real  # smallest force that the residual is compared with [N]

    return PlainWeave


@wp.func
def yarn_strain(cell: Any, k: int, u: Any, w: Any):
    """Elongation l - l0 and rotation phi of yarn k's chord, the chord (X, H, 1/l), and the size of what cancels.

    Both are written so that nothing cancels: l - l0 = (l^2 - l0^2)/(l + l0), and sin(phi) l l0 = L w - h u.
    """
    half_spacing = cell.half_spacing[k]
    crimp_height = cell.crimp_height[k]
    chord_length = cell.chord_length[k]
    x = fill(u, half_spacing) + u
    h = fill(u, crimp_height) + w
    length = square_root(x * x + h * h)
    along = u * (u.dtype(2.0) * fill(u, half_spacing) + u)
    across = w * (u.dtype(2.0) * fill(u, crimp_height) + w)
    inverse_length, inverse_sum = inverses(length, length + fill(u, chord_length))
    elongation = (along + across) * inverse_sum
    parts = (magnitude(along) + magnitude(across)) * inverse_sum
    rotation = angle_of(half_spacing * w - crimp_height * u, half_spacing * x + crimp_height * h, chord_length * length)
    return elongation, rotation, x, h, inverse_length, parts


@wp.func
def yarn_axial_stiffness(cell: Any, k: int, elongation: Any):
    return where_positive(
        elongation, fill(elongation, cell.tensile_stiffness[k]), fill(elongation, cell.compressive_stiffness[k])
    )


@wp.func
def yarn_forces(cell: Any, k: int, u: Any, w: Any):
    """Forces of yarn k alone, and what its higher derivatives are made of.

    Returns dPi/du, dPi/dw, d2Pi/dw2, its positive part, the size of the terms of dPi/dw; elongation, axial stiffness,
    moment, cosine and sine of the chord, 1/l.
    """
    elongation, rotation, x, h, inverse_length, parts = yarn_strain(cell, k, u, w)
    stiffness = yarn_axial_stiffness(cell, k, elongation)
    axial = stiffness * elongation
    moment = cell.rotation_stiffness[k] * rotation
    cosine = x * inverse_length
    sine = h * inverse_length
    shear = moment * inverse_length
    by_u = axial * cosine - shear * sine
    by_w = axial * sine + shear * cosine
    # d2Pi/dw2: elastic part K_E, geometric part K_G
    turning = cosine * inverse_length
    elastic = stiffness * sine * sine + cell.rotation_stiffness[k] * turning * turning
    geometric = (axial * cosine - u.dtype(2.0) * shear * sine) * turning
    # what the residual is compared with: the terms themselves, and what rounding leaves of the elongation
    size = magnitude(axial * sine) + magnitude(shear * cosine) + cell.resolution * stiffness * parts * magnitude(sine)
    return by_u, by_w, elastic + geometric, elastic, size, elongation, stiffness, moment, cosine, sine, inverse_length


@wp.func
def yarn_expansion(
    cell: Any, k: int, elongation: Any, stiffness: Any, moment: Any, cosine: Any, sine: Any, inverse_length: Any
):
    """Further derivatives of yarn k's energy, from what ``yarn_forces`` tells: uw, uww, www."""
    one = fill(moment, 1.0)
    two = moment.dtype(2.0)
    four = moment.dtype(4.0)
    bending = cell.rotation_stiffness[k] * inverse_length * inverse_length
    shear = moment * inverse_length * inverse_length
    along = stiffness - stiffness * elongation * inverse_length - two * bending
    c2 = cosine * cosine
    s2 = sine * sine
    turning = cosine * inverse_length
    twice_shear = two * shear * inverse_length
    uw = cosine * sine * (along + bending) - shear * (c2 - s2)
    uww = turning * (c2 - two * s2) * along + twice_shear * sine * (four * c2 - one)
    www = moment.dtype(3.0) * turning * cosine * sine * along + twice_shear * cosine * (four * s2 - one)
    return uw, uww, www


@wp.func
def yarn_remainder(
    cell: Any,
    k: int,
    elongation: Any,
    stiffness: Any,
    moment: Any,
    cosine: Any,
    sine: Any,
    inverse_length: Any,
    step: Any,
):
    """What a step in w adds to dPi/dw of yarn k beyond the third derivative, and how the size of its terms changes.

    Beyond it are d4Pi/dw4, and another stiffness where the yarn goes from tension to compression or back.
    """
    bend = cosine * step * inverse_length
    stretched = elongation + sine * step + step.dtype(0.5) * cosine * bend * step
    passed = larger(where_positive(elongation, -stretched, stretched), fill(step, 0.0))
    jump = wp.abs(cell.tensile_stiffness[k] - cell.compressive_stiffness[k])
    fourth = step.dtype(2.0) * (stiffness + cell.rotation_stiffness[k] * inverse_length * inverse_length)
    beyond = fourth * bend * bend * magnitude(step) + jump * passed * magnitude(sine)
    axial = stiffness * sine
    turning = inverse_length * cosine
    before = magnitude(axial * elongation) + magnitude(turning * moment)
    after = magnitude(axial * stretched) + magnitude(turning * (moment + cell.rotation_stiffness[k] * bend))
    return beyond, after - before


@wp.func
def contact_active(cell: Any, closing: Any):
    """1 where the contact element carries force: everywhere if bilateral, where yarns are pressed if unilateral."""
    active = fill(closing, 1.0)
    if cell.unilateral == 1:
        active = where_positive(closing, active, fill(closing, 0.0))
    return active


@wp.func
def solve_unit_cell(cell: Any, u1: Any, u2: Any, start1: Any, start2: Any):
    """Height changes (w1, w2) that make Pi stationary, by Newton's method from (start1, start2).

    The last step is one of third order (Chebyshev's: Newton's step d, minus H^-1 Pi_www d d/2), and no evaluation
    follows it: the forces are taken along to second order. It is the last as soon as the estimate of what it leaves is
    within the tolerance; from one time step to the next that mostly is the first.

    Safeguards, all per lane: where the Hessian is not positive definite its geometric part is left out; a step is at
    most a quarter of the chord; a step that overshoots (the directional derivative changes sign and keeps more than
    half its size) is taken back in part, by a Newton step along it, so that the point stays between two known slopes.

    Returns w1, w2, F1 = dPi/du1, F2, crossover force of the half cell, relative residual, iterations.
    """
    w1 = start1
    w2 = start2
    zero = fill(u1, 0.0)
    one = fill(u1, 1.0)
    half = u1.dtype(0.5)
    two = u1.dtype(2.0)
    step1 = zero
    step2 = zero
    slope = zero  # directional derivative at the start of the step, <= 0
    force1 = zero
    force2 = zero
    stiffness = zero
    residual = one
    iterations = zero
    tolerance = fill(u1, cell.tolerance)
    for iteration in range(MAXIMUM_ITERATIONS + 1):
        by_u1, by_w1, hessian1, elastic1, size1, elongation1, axial1, moment1, cosine1, sine1, inverse1 = yarn_forces(
            cell, 0, u1, w1
        )
        by_u2, by_w2, hessian2, elastic2, size2, elongation2, axial2, moment2, cosine2, sine2, inverse2 = yarn_forces(
            cell, 1, u2, w2
        )
        stiffness = cell.contact_stiffness * contact_active(cell, -(w1 + w2))
        crossover = -(stiffness * (w1 + w2))
        gradient1 = by_w1 - crossover
        gradient2 = by_w2 - crossover
        least = fill(u1, cell.force_floor) + cell.resolution * stiffness * (magnitude(w1) + magnitude(w2))
        size = larger(size1, size2) + magnitude(crossover) + least
        # Newton step with a positive definite matrix
        # (h1 + k)(h2 + k) - k^2, written so that a stiff contact does not cancel it
        determinant = hessian1 * hessian2 + stiffness * (hessian1 + hessian2)
        definite = smaller(determinant, hessian1 + stiffness)
        # a slack yarn without bending stiffness has none: the least that keeps the matrix regular
        own1 = where_positive(definite, hessian1, elastic1 + fill(u1, cell.stiffness_floor))
        own2 = where_positive(definite, hessian2, elastic2 + fill(u1, cell.stiffness_floor))
        diagonal1 = own1 + stiffness
        diagonal2 = own2 + stiffness
        inverse, inverse_size = inverses(own1 * own2 + stiffness * (own1 + own2), size)
        residual = larger(magnitude(gradient1), magnitude(gradient2)) * inverse_size
        newton1 = (stiffness * gradient2 - diagonal2 * gradient1) * inverse
        newton2 = (stiffness * gradient1 - diagonal1 * gradient2) * inverse
        # what the third derivatives add to it
        uw1, uww1, www1 = yarn_expansion(cell, 0, elongation1, axial1, moment1, cosine1, sine1, inverse1)
        uw2, uww2, www2 = yarn_expansion(cell, 1, elongation2, axial2, moment2, cosine2, sine2, inverse2)
        bent1 = half * www1 * newton1 * newton1
        bent2 = half * www2 * newton2 * newton2
        extra1 = (stiffness * bent2 - diagonal2 * bent1) * inverse
        extra2 = (stiffness * bent1 - diagonal1 * bent2) * inverse
        last1 = newton1 + extra1
        last2 = newton2 + extra2
        # what both leave: the ratio of the two parts once more, and what no third derivative knows
        ratio = (magnitude(extra1) + magnitude(extra2)) / (magnitude(newton1) + magnitude(newton2) + fill(u1, 1.0e-37))
        beyond1, change1 = yarn_remainder(cell, 0, elongation1, axial1, moment1, cosine1, sine1, inverse1, last1)
        beyond2, change2 = yarn_remainder(cell, 1, elongation2, axial2, moment2, cosine2, sine2, inverse2, last2)
        beyond = beyond1 + beyond2
        if cell.unilateral == 1:
            closing = w1 + w2
            closed = closing + last1 + last2
            beyond = beyond + cell.contact_stiffness * larger(where_positive(-closing, closed, -closed), zero)
        pressed = magnitude(crossover - stiffness * (last1 + last2))
        size_after = larger(size1 + change1, size2 + change2) + pressed + least
        remainder = (two * residual * size * ratio * ratio + beyond) / smaller(size, size_after)
        better = where_positive(definite, residual - remainder, zero)
        remainder = where_positive(better, remainder, residual)
        # a NaN compares false, and is caught by the caller; it must not stall the other lanes
        unfinished = where_positive(remainder - tolerance, one, zero)
        if iteration == MAXIMUM_ITERATIONS or lane_maximum(unfinished) == u1.dtype(0.0):
            last1 = where_positive(better, last1, zero)
            last2 = where_positive(better, last2, zero)
            w1 = w1 + last1
            w2 = w2 + last2
            force1 = by_u1 + (uw1 + half * uww1 * last1) * last1
            force2 = by_u2 + (uw2 + half * uww2 * last2) * last2
            residual = remainder
            break
        iterations = iterations + unfinished
        limit1 = fill(u1, u1.dtype(0.25) * cell.chord_length[0])
        limit2 = fill(u1, u1.dtype(0.25) * cell.chord_length[1])
        shrink = smaller(
            one,
            smaller(
                limit1 / (magnitude(newton1) + u1.dtype(1.0e-3) * limit1),
                limit2 / (magnitude(newton2) + u1.dtype(1.0e-3) * limit2),
            ),
        )
        newton1 = shrink * newton1
        newton2 = shrink * newton2
        # overshoot of the previous step: a Newton step back along it, with the stiffness met here
        rise = gradient1 * step1 + gradient2 * step2
        overshoot = rise + half * slope
        curvature = diagonal1 * step1 * step1 + diagonal2 * step2 * step2 + two * stiffness * step1 * step2
        back = smaller(larger(rise / larger(curvature, fill(u1, 1.0e-37)), fill(u1, 0.0625)), fill(u1, 0.9375))
        slope = where_positive(overshoot, (one - back) * slope, gradient1 * newton1 + gradient2 * newton2)
        w1 = where_positive(unfinished, w1 + where_positive(overshoot, -(back * step1), newton1), w1)
        w2 = where_positive(unfinished, w2 + where_positive(overshoot, -(back * step2), newton2), w2)
        step1 = where_positive(overshoot, (one - back) * step1, newton1)
        step2 = where_positive(overshoot, (one - back) * step2, newton2)
    return w1, w2, force1, force2, -(stiffness * (w1 + w2)), residual, iterations


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
    by_u1, by_w1, hessian1, elastic1, size1, el1, k1, m1, c1, s1, i1 = yarn_forces(cell, 0, u1, w1)
    by_u2, by_w2, hessian2, elastic2, size2, el2, k2, m2, c2, s2, i2 = yarn_forces(cell, 1, u2, w2)
    closing = cell.contact_stiffness * contact_active(cell, -(w1 + w2)) * (w1 + w2)
    return -((by_w1 + closing) * change1 + (by_w2 + closing) * change2)


@wp.func
def yarn_hessian(cell: Any, k: int, u: Any, w: Any, in_tension: bool):
    """Second derivatives (uu, uw, ww) of yarn k's energy; ``in_tension``: with its stiffness in tension in any case."""
    elongation, rotation, x, h, inverse_length, parts = yarn_strain(cell, k, u, w)
    stiffness = yarn_axial_stiffness(cell, k, elongation)
    axial = stiffness * elongation * inverse_length
    if in_tension:
        stiffness = fill(u, cell.tensile_stiffness[k])
        axial = larger(axial, fill(u, 0.0))
    bending = cell.rotation_stiffness[k] * inverse_length * inverse_length
    moment = cell.rotation_stiffness[k] * rotation * inverse_length * inverse_length
    c = x * inverse_length
    s = h * inverse_length
    twice = u.dtype(2.0) * moment * c * s
    uu = stiffness * c * c + axial * s * s + bending * s * s + twice
    uw = (stiffness - axial - bending) * c * s - moment * (c * c - s * s)
    ww = stiffness * s * s + axial * c * c + bending * c * c - twice
    return uu, uw, ww


@wp.func
def condensed_tangent(cell: Any, u1: Any, u2: Any, w1: Any, w2: Any, in_tension: bool):
    """(K11, K12, K22) [N/m]: derivative of (F1, F2) by (u1, u2) with w in equilibrium, H_uu - H_uw H_ww^-1 H_wu.

    ``in_tension`` gives what the cell becomes as soon as its yarns are pulled, for stable steps.
    """
    uu1, uw1, ww1 = yarn_hessian(cell, 0, u1, w1, in_tension)
    uu2, uw2, ww2 = yarn_hessian(cell, 1, u2, w2, in_tension)
    stiffness = cell.contact_stiffness * contact_active(cell, -(w1 + w2))
    determinant = ww1 * ww2 + stiffness * (ww1 + ww2)
    # straight yarns without bending stiffness: nothing holds w, and nothing couples it to u
    determinant = where_positive(magnitude(determinant), determinant, fill(determinant, 1.0))
    k11 = uu1 - uw1 * uw1 * (ww2 + stiffness) / determinant
    k22 = uu2 - uw2 * uw2 * (ww1 + stiffness) / determinant
    k12 = uw1 * uw2 * stiffness / determinant
    return k11, k12, k22


# --- the contract of kernels/cell/law.py


@wp.func
def solve(cell: Any, strain1: Any, strain2: Any, angle: Any, start: Any):
    u1 = cell.half_spacing[0] * strain1
    u2 = cell.half_spacing[1] * strain2
    w1, w2, force1, force2, crossover, residual, iterations = solve_unit_cell(cell, u1, u2, start[0], start[1])
    half = u1.dtype(0.5)
    return (
        wp.matrix_from_rows(w1, w2),
        (half / cell.half_spacing[1]) * force1,
        (half / cell.half_spacing[0]) * force2,
        fill(u1, 0.0),
        (half / (cell.half_spacing[0] * cell.half_spacing[1])) * crossover,
        residual,
        iterations,
    )


@wp.func
def energies(cell: Any, strain1: Any, strain2: Any, angle: Any, q: Any, area: Any):
    warp, weft, bending, contact = unit_cell_energies(
        cell, cell.half_spacing[0] * strain1, cell.half_spacing[1] * strain2, q[0], q[1]
    )
    cells = area / fill(area, area.dtype(2.0) * cell.half_spacing[0] * cell.half_spacing[1])
    return wp.matrix_from_rows(cells * warp, cells * weft, cells * bending, cells * contact)


@wp.func
def per_width(cell: Any, k11: Any, k12: Any, k22: Any):
    """C11, C12, C22 of dn = C dlambda from dF = K du, and what depends on the shear angle: nothing [N/m]."""
    half = k11.dtype(0.5)
    l1 = cell.half_spacing[0]
    l2 = cell.half_spacing[1]
    zero = fill(k11, 0.0)
    return (half * l1 / l2) * k11, half * k12, (half * l2 / l1) * k22, zero, zero, zero


@wp.func
def tangent(cell: Any, strain1: Any, strain2: Any, angle: Any, q: Any):
    k11, k12, k22 = condensed_tangent(
        cell, cell.half_spacing[0] * strain1, cell.half_spacing[1] * strain2, q[0], q[1], False
    )
    return per_width(cell, k11, k12, k22)


@wp.func
def stable_tangent(cell: Any, strain1: Any, strain2: Any, angle: Any, q: Any, state: int):
    solution, n1, n2, m, pressure, residual, iterations = solve(cell, strain1, strain2, angle, q)
    k11, k12, k22 = condensed_tangent(
        cell, cell.half_spacing[0] * strain1, cell.half_spacing[1] * strain2, solution[0], solution[1], True
    )
    c11, c12, c22, c13, c23, c33 = per_width(cell, k11, k12, k22)
    return c11, c12, c22, c13, c23, c33, n1, n2, m, pressure


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
        # a fast but steady change frees 1/2 dw.H dw, half of what the gradient at its start promises, and the
        # work of the forces contains that; a snap starts near an equilibrium and frees far more
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
