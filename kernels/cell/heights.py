"""Equilibrium of the heights of a plain-weave cell: a safeguarded Newton iteration of third order (theory, section 2).

Pairs of values are the rows (warp, weft) of a matrix. A contact that is far stiffer than the yarns lets w_1 and w_2
change only together, and its force is a small difference of both times a large number. So the sum w_1 + w_2 is an
unknown of its own, CLOSING, whose changes are computed without that difference.
"""

from typing import Any

import warp as wp

from ..angles import angles_of
from ..lane_types import ALL_LANE_TYPES, GPU_LANE_COUNT
from ..lanes import fill, from_rows, inverses, lane_maximum, larger, magnitude, smaller, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from .law import MAXIMUM_ITERATIONS
from .yarn import (
    ELONGATION,
    MOMENT,
    STIFFNESS,
    strained_forces,
    yarn_chord,
    yarn_expansion,
    yarn_forces,
    yarn_remainder,
)

# Row of w_1 + w_2 in a step.
CLOSING = wp.constant(2)
# Steps that end where a yarn becomes taut: one for each yarn. Where rounding hides the kink, more would never arrive.
KINKS_MINDED = wp.constant(2)


@wp.func
def contact_stiffness(cell: Any, closing: Any):
    """Stiffness of the contact element: a unilateral one has none where ``closing`` = w_1 + w_2 is positive."""
    stiffness = fill(closing, cell.contact_stiffness)
    if cell.unilateral == 1:
        stiffness = where_positive(closing, fill(closing, 0.0), stiffness)
    return stiffness


@wp.func
def rounded_closing(cell: Any, w: Any):
    """w_1 + w_2 as far as it is known: within its rounding it is zero, where yarns touch without force."""
    closing = w[0] + w[1]
    known = magnitude(closing) - cell.resolution * (magnitude(w[0]) + magnitude(w[1]))
    return where_positive(known, closing, fill(closing, 0.0))


for _types in ALL_LANE_TYPES:
    if _types.real is wp.float32 and _types.lane_count > GPU_LANE_COUNT:

        @wp.func
        def forces_of_both(cell: Any, u1: _types.lanes, u2: _types.lanes, w: Any):
            """``yarn_forces`` of warp, then of weft.

            Both angles in one loop here, so that neither chain of sums waits for the other. On a GPU that takes 16
            registers more, and sixteen numbers of double precision have two registers each, so that they wait less.
            """
            elongation1, x1, h1, inverse1, sine1, beside1 = yarn_chord(cell, 0, u1, w[0])
            elongation2, x2, h2, inverse2, sine2, beside2 = yarn_chord(cell, 1, u2, w[1])
            rotation1, rotation2 = angles_of(sine1, beside1, sine2, beside2)
            by_u1, by_w1, hessian1, elastic1, size1, state1 = strained_forces(
                cell, 0, elongation1, rotation1, x1, h1, inverse1
            )
            by_u2, by_w2, hessian2, elastic2, size2, state2 = strained_forces(
                cell, 1, elongation2, rotation2, x2, h2, inverse2
            )
            return by_u1, by_w1, hessian1, elastic1, size1, state1, by_u2, by_w2, hessian2, elastic2, size2, state2
    else:

        @wp.func
        def forces_of_both(cell: Any, u1: _types.lanes, u2: _types.lanes, w: Any):
            by_u1, by_w1, hessian1, elastic1, size1, state1 = yarn_forces(cell, 0, u1, w[0])
            by_u2, by_w2, hessian2, elastic2, size2, state2 = yarn_forces(cell, 1, u2, w[1])
            return by_u1, by_w1, hessian1, elastic1, size1, state1, by_u2, by_w2, hessian2, elastic2, size2, state2


@wp.func
def yarn_pair(cell: Any, u1: Any, u2: Any, w: Any):
    """``yarn_forces`` of both: dPi/du, dPi/dw, d2Pi/dw2, its positive part, sizes; state of warp, state of weft.

    Only for ``solve_unit_cell``: the compiler puts a function with several callers in none of them, its answers then
    go through memory in every iteration, and that made the step of a thrown sheet 12 % slower (16 lanes, float64).
    """
    by_u1, by_w1, hessian1, elastic1, size1, state1, by_u2, by_w2, hessian2, elastic2, size2, state2 = forces_of_both(
        cell, u1, u2, w
    )
    return (
        from_rows(by_u1, by_u2),
        from_rows(by_w1, by_w2),
        from_rows(hessian1, hessian2),
        from_rows(elastic1, elastic2),
        from_rows(size1, size2),
        state1,
        state2,
    )


@wp.func
def residual_size(cell: Any, sizes: Any, crossover: Any):
    """Reference force of the residual. Before a step the crossover force may be rounding, and does not count."""
    return larger(sizes[0], sizes[1]) + magnitude(crossover) + fill(crossover, cell.force_floor)


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
    return from_rows(own1, own2), definite


@wp.func
def yielding(own: Any, stiffness: Any, inverse: Any, force: Any, pressed: Any):
    """-H^-1 of forces on w_1, w_2, for these and their sum; ``own`` of the yarns, 1/det H = ``inverse``.

    ``pressed`` is ``force`` plus that of the contact, which is the same on both yarns and no part of their difference.
    """
    apart = stiffness * (force[1] - force[0])
    pressed1 = own[1] * pressed[0]
    pressed2 = own[0] * pressed[1]
    return from_rows((apart - pressed1) * inverse, -((apart + pressed2) * inverse), -((pressed1 + pressed2) * inverse))


@wp.func
def settled_closing(own: Any, inverse: Any, force: Any, closing: Any):
    """w_1 + w_2 after Newton's step, without the difference of both: exact for any ``closing`` of a linear cell."""
    return (own[0] * own[1] * closing - own[1] * force[0] - own[0] * force[1]) * inverse


@wp.func
def pair_expansion(cell: Any, state1: Any, state2: Any):
    """``yarn_expansion`` of both: uw, uww, www."""
    uw1, uww1, www1 = yarn_expansion(cell, 0, state1)
    uw2, uww2, www2 = yarn_expansion(cell, 1, state2)
    return from_rows(uw1, uw2), from_rows(uww1, uww2), from_rows(www1, www2)


@wp.func
def follow_strains(own: Any, stiffness: Any, inverse: Any, uw: Any):
    """Derivatives of w_1 and w_2 by u_1 and u_2 in equilibrium, -H^-1 Pi_wu: w_1 by both, w_2 by both."""
    warp = uw[0] * inverse
    weft = uw[1] * inverse
    return from_rows(-((own[1] + stiffness) * warp), stiffness * weft, stiffness * warp, -((own[0] + stiffness) * weft))


@wp.func
def third_order(cell: Any, state1: Any, state2: Any, own: Any, stiffness: Any, inverse: Any, newton: Any):
    """What the third derivatives add to Newton's step, -H^-1 Pi_www d d/2, the derivatives uw, uww, and dw/du."""
    half = inverse.dtype(0.5)
    uw, uww, www = pair_expansion(cell, state1, state2)
    bent = from_rows(half * www[0] * newton[0] * newton[0], half * www[1] * newton[1] * newton[1])
    return yielding(own, stiffness, inverse, bent, bent), uw, uww, follow_strains(own, stiffness, inverse, uw)


@wp.func
def twice_squared_ratio(newton: Any, extra: Any):
    """Size of what the third derivatives add to Newton's step, over the size of that: twice its square."""
    added = magnitude(extra[0]) + magnitude(extra[1])
    ratio = added / (magnitude(newton[0]) + magnitude(newton[1]) + fill(added, 1.0e-37))
    return ratio.dtype(2.0) * ratio * ratio


@wp.func
def pair_remainder(cell: Any, state1: Any, state2: Any, closing: Any, closed: Any, step: Any):
    """``yarn_remainder`` of both: change of dPi/dw beyond the third derivatives, change of sizes, elongations after."""
    beyond1, change1, stretched1 = yarn_remainder(cell, 0, state1, step[0])
    beyond2, change2, stretched2 = yarn_remainder(cell, 1, state2, step[1])
    beyond = beyond1 + beyond2
    if cell.unilateral == 1:
        beyond = beyond + cell.contact_stiffness * larger(where_positive(closing, -closed, closed), fill(closing, 0.0))
    return beyond, from_rows(change1, change2), from_rows(stretched1, stretched2)


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
def until_taut(jump: Any, elongation: Any, stretched: Any, curvature: Any):
    """Share of a step after which its slope is zero if a member becomes taut on the way; 1 if it does not.

    The energy along the step is two parabolas, of ``curvature`` and, in addition, of ``jump``: the member is as much
    stiffer then.
    """
    one = fill(elongation, 1.0)
    least = fill(elongation, 1.0e-37)
    stretch = larger(stretched - elongation, least)
    slack = -(elongation / stretch)
    beyond = curvature / larger(curvature + jump * stretch * stretch, least)
    share = where_positive(stretched, slack + (one - slack) * beyond, one)
    return where_positive(elongation, one, share)


@wp.func
def yarn_jump(cell: Any, k: int):
    """What yarn k is stiffer in tension."""
    jump = cell.tensile_stiffness[k] - cell.compressive_stiffness[k]
    return wp.max(jump, type(jump)(0.0))


@wp.func
def drawn(state1: Any, state2: Any):
    """Elongations of both yarns."""
    return from_rows(state1[ELONGATION], state2[ELONGATION])


@wp.func
def short_of_kinks(
    cell: Any, iteration: int, elongation: Any, stretched: Any, closing: Any, own: Any, stiffness: Any, newton: Any
):
    """Newton's step; one of the first, as far as is best for both stiffnesses if a slack yarn becomes taut in it.

    Likewise if yarns that were apart meet.

    Only where other lanes wait: on a GPU it would take 20 registers more.
    """
    step = newton
    if iteration < KINKS_MINDED and len(newton[0]) > 1:
        closed = newton[CLOSING]
        curvature = own[0] * newton[0] * newton[0] + own[1] * newton[1] * newton[1] + stiffness * closed * closed
        share = until_taut(yarn_jump(cell, 0), elongation[0], stretched[0], curvature)
        share = smaller(share, until_taut(yarn_jump(cell, 1), elongation[1], stretched[1], curvature))
        if cell.unilateral == 1:
            share = smaller(share, until_taut(cell.contact_stiffness, -closing, -(closing + closed), curvature))
        step = from_rows(share * newton[0], share * newton[1], share * closed)
    return step


@wp.func
def advanced(w: Any, closing: Any, unfinished: Any, change: Any):
    """Heights and closing after a step where ``unfinished`` > 0."""
    heights = type(w)()
    for k in range(2):
        heights[k] = where_positive(unfinished, w[k] + change[k], w[k])
    return heights, where_positive(unfinished, closing + change[CLOSING], closing)


@wp.func
def along_step(force: Any, pressure: Any, step: Any):
    """Work of dPi/dw over a step: ``force`` of the yarns, ``pressure`` of the contact."""
    return force[0] * step[0] + force[1] * step[1] + pressure * step[CLOSING]


@wp.func
def energy_after(cell: Any, state1: Any, state2: Any, force: Any, pressure: Any, closing: Any, newton: Any, extra: Any):
    """Twice Pi after the last step, from the states of the yarns before it: to the fourth order g d_1 + 2/3 g d_2."""
    bent1 = state1[MOMENT] * state1[MOMENT] * fill(closing, cell.inverse_rotation_stiffness[0])
    bent2 = state2[MOMENT] * state2[MOMENT] * fill(closing, cell.inverse_rotation_stiffness[1])
    drawn1 = state1[STIFFNESS] * state1[ELONGATION] * state1[ELONGATION]
    drawn2 = state2[STIFFNESS] * state2[ELONGATION] * state2[ELONGATION]
    change = along_step(force, pressure, newton) + closing.dtype(2.0 / 3.0) * along_step(force, pressure, extra)
    return (drawn1 + drawn2) + (bent1 + bent2) + pressure * closing + change


@wp.func
def safeguarded(cell: Any, force: Any, pressure: Any, own: Any, stiffness: Any, newton: Any, step: Any, slope: Any):
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
    # overshoot of the previous step: a Newton step back along it, with the current stiffness
    rise = along_step(force, pressure, step)
    overshoot = rise + slope.dtype(0.5) * slope
    curvature = own[0] * step[0] * step[0] + own[1] * step[1] * step[1] + stiffness * step[CLOSING] * step[CLOSING]
    back = smaller(larger(rise / larger(curvature, fill(rise, 1.0e-37)), fill(rise, 0.0625)), fill(rise, 0.9375))
    new_slope = where_positive(overshoot, (one - back) * slope, shrink * along_step(force, pressure, newton))
    change = type(step)()
    direction = type(step)()
    for k in range(3):
        change[k] = where_positive(overshoot, -(back * step[k]), shrink * newton[k])
        direction[k] = where_positive(overshoot, (one - back) * step[k], shrink * newton[k])
    return change, direction, new_slope


@wp.func
def solve_unit_cell(cell: Any, u1: Any, u2: Any, start: Any):
    """Height changes w that make Pi stationary, by Newton's method from ``start``.

    The last step is of third order (Chebyshev's: Newton's step d, minus H^-1 Pi_www d d/2), without an evaluation
    after it: the forces are extrapolated to second order. A step is the last as soon as the estimated residual after it
    is within the tolerance; from one time step to the next that is usually the first. Rounding of w leaves a residual
    before the last step, not in the extrapolated forces.

    Safeguards, all per lane: where the Hessian is not positive definite its geometric part is dropped; a step is at
    most a quarter of the chord; one of the first two ends where a slack yarn becomes taut; a step that overshoots (the
    directional derivative changes sign and keeps more than half its size) is partly undone, by a Newton step along it,
    so that the point stays between two known slopes. A NaN compares false and is caught by the caller; it must not
    stall the other lanes.

    Returns w, dPi/du, crossover force of the half cell, 2 Pi, relative residual, iterations, and dw/du.
    """
    w = start
    zero = fill(u1, 0.0)
    closing = rounded_closing(cell, w)
    step = from_rows(zero, zero, zero)
    slope = zero  # directional derivative at the start of the step, <= 0
    force = type(start)()
    crossover = zero
    energy = zero
    residual = fill(u1, 1.0)
    iterations = zero
    for iteration in range(MAXIMUM_ITERATIONS + 1):
        by_u, by_w, hessian, elastic, sizes, state1, state2 = yarn_pair(cell, u1, u2, w)
        stiffness = contact_stiffness(cell, closing)
        pressure = stiffness * closing
        own, definite = regular_parts(cell, hessian, elastic, stiffness)
        size = residual_size(cell, sizes, zero)
        inverse, inverse_size = inverses(own[0] * own[1] + stiffness * (own[0] + own[1]), size)
        unbalanced = larger(magnitude(by_w[0] + pressure), magnitude(by_w[1] + pressure))
        residual = unbalanced * inverse_size
        newton = yielding(own, stiffness, inverse, by_w, from_rows(by_w[0] + pressure, by_w[1] + pressure))
        extra, uw, uww, slopes = third_order(cell, state1, state2, own, stiffness, inverse, newton)
        closed = settled_closing(own, inverse, by_w, closing) + extra[CLOSING]
        # residual after both: the ratio of the two parts once more, and terms beyond the third derivatives
        beyond, changes, stretched = pair_remainder(cell, state1, state2, closing, closed, newton + extra)
        size = smaller(size, residual_size(cell, sizes + changes, stiffness * closed))
        remainder = (unbalanced * twice_squared_ratio(newton, extra) + beyond) / size
        better = where_positive(definite, residual - remainder, zero)
        remainder = where_positive(better, remainder, residual)
        unfinished = where_positive(remainder - fill(u1, cell.tolerance), fill(u1, 1.0), zero)
        if iteration == MAXIMUM_ITERATIONS or lane_maximum(unfinished) == u1.dtype(0.0):
            energy = energy_after(cell, state1, state2, by_w, pressure, closing, newton, extra)
            w, force = last_step(w, newton + extra, better, by_u, uw, uww)
            crossover = -(stiffness * where_positive(better, closed, closing))
            residual = remainder
            break
        iterations = iterations + unfinished
        newton = short_of_kinks(cell, iteration, drawn(state1, state2), stretched, closing, own, stiffness, newton)
        change, step, slope = safeguarded(cell, by_w, pressure, own, stiffness, newton, step, slope)
        w, closing = advanced(w, closing, unfinished, change)
    return w, force, crossover, energy, residual, iterations, slopes
