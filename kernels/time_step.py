"""Stable time step from the condensed tangent of every element's own unit cell (docs/theory.md, section 7)."""

from functools import cache
from typing import Any

import warp as wp

from .cell import CellLaw
from .curve import odd_curve
from .element import (
    DIRECTOR_ROW,
    VELOCITY_ROW,
    corner_angles,
    element_positions,
    element_struct,
    element_vectors,
    hourglass_stiffnesses,
    skew_weights,
    surface_metric,
    twist_weights,
    yarn_strains,
)
from .lanes import (
    angle_of,
    div,
    dot,
    fill,
    lane_types,
    larger,
    magnitude,
    mul,
    spread,
    square_root,
    where_positive,
)
from .node import CLOCK_MEAN_STEP, CLOCK_STEP
from .sheet import BENDING_ISOTROPIC, SheetTraits, shear_friction_limit, sheet_struct


@wp.func
def shear_tangent(
    laws: Any,
    curved: bool,
    sticking: bool,
    stretch1: Any,
    stretch2: Any,
    sine: Any,
    cosine: Any,
    angle: Any,
    crossover_pressure: Any,
):
    """Second derivatives of the shear energy by (stretch 1, stretch 2, angle): C11, C12, C22, C13, C23, C33 [N/m].

    Then its first derivatives n_1, n_2, m. Friction (``sticking``) counts with all the moment that it can bear.
    """
    zero = fill(angle, 0.0)
    c11 = zero
    c12 = zero
    c22 = zero
    c13 = zero
    c23 = zero
    c33 = zero
    n1 = zero
    n2 = zero
    moment = zero
    if curved:
        moment, c33 = odd_curve(laws.shear.curve, angle)
        c33 = larger(c33, zero)
    else:
        # psi = 1/4 t G_12 (stretch1 stretch2 sin)^2
        half = angle.dtype(0.5) * laws.shear.stiffness
        product = stretch1 * stretch2
        c11 = half * (stretch2 * sine) * (stretch2 * sine)
        c12 = (angle.dtype(2.0) * half) * (product * sine * sine)
        c22 = half * (stretch1 * sine) * (stretch1 * sine)
        mixed = (angle.dtype(2.0) * half) * (product * sine * cosine)
        c13 = stretch2 * mixed
        c23 = stretch1 * mixed
        c33 = half * (product * product) * (cosine * cosine - sine * sine)
        n1 = stretch1 * c11
        n2 = stretch2 * c22
        moment = half * (product * product) * (sine * cosine)
    if sticking:
        limit = shear_friction_limit(laws, angle, crossover_pressure)
        c33 = c33 + spread(angle, laws.shear.friction_stiffness)
        moment = moment + where_positive(moment, limit, -limit)
    return c11, c12, c22, c13, c23, c33, n1, n2, moment


@wp.func
def largest_of_pencil(h11: Any, h12: Any, h22: Any, b11: Any, b12: Any, b22: Any):
    """Largest eigenvalue of H B, both 2 x 2 and symmetric, B positive definite."""
    two = h11.dtype(2.0)
    half_trace = h11.dtype(0.5) * (h11 * b11 + two * (h12 * b12) + h22 * b22)
    determinant = (h11 * h22 - h12 * h12) * (b11 * b22 - b12 * b12)
    return half_trace + square_root(larger(half_trace * half_trace - determinant, fill(h11, 0.0)))


@wp.func
def norm_squared(a00: Any, a01: Any, a02: Any, a03: Any, a11: Any, a12: Any, a13: Any, a22: Any, a23: Any, a33: Any):
    """Sum of the squared entries of a symmetric 4 x 4 matrix."""
    diagonal = a00 * a00 + a11 * a11 + a22 * a22 + a33 * a33
    rest = a01 * a01 + a02 * a02 + a03 * a03 + a12 * a12 + a13 * a13 + a23 * a23
    return diagonal + a00.dtype(2.0) * rest


@wp.func
def largest_in_plane(
    c11: Any,
    c12: Any,
    c22: Any,
    c13: Any,
    c23: Any,
    c33: Any,
    n1: Any,
    n2: Any,
    moment: Any,
    stretch1: Any,
    stretch2: Any,
    sine: Any,
    cosine: Any,
    b11: Any,
    b12: Any,
    b22: Any,
):
    """Bound of the largest |eigenvalue| of H (B x I) for motions in the tangent plane, at most 4.5 % above it.

    H is the 4 x 4 second derivative by (da_1, da_2) of an energy of the stretches and the shear angle: its tangent C on
    the strains, and the forces n_1, n_2 and the moment m on their curvature. A norm of H^16 is its bound.
    """
    one = fill(sine, 1.0)
    inverse1 = one / stretch1
    inverse2 = one / stretch2
    # blocks of H in the tangent frame (e_1, across e_1); e_2 = (sin, cos), and the angle falls along (-cos, sin)
    xx = c11
    xy = inverse1 * (c13 - moment * inverse1)
    yy = inverse1 * (n1 + c33 * inverse1)
    along = c22
    mixed = inverse2 * (c23 - moment * inverse2)
    across = inverse2 * (n2 + c33 * inverse2)
    square_sine = sine * sine
    product = sine * cosine
    square_cosine = cosine * cosine
    zz = along * square_sine + sine.dtype(2.0) * (mixed * product) + across * square_cosine
    zw = (along - across) * product + mixed * (square_cosine - square_sine)
    ww = along * square_cosine - sine.dtype(2.0) * (mixed * product) + across * square_sine
    angle2 = c33 * (inverse1 * inverse2)
    xz = c12 * sine + c13 * (cosine * inverse2)
    xw = c12 * cosine - c13 * (sine * inverse2)
    yz = c23 * (sine * inverse1) + angle2 * cosine
    yw = c23 * (cosine * inverse1) - angle2 * sine
    # A = L^T H L with B = L L^T
    l11 = square_root(b11)
    l21 = b12 / l11
    l22 = square_root(larger(b22 - l21 * l21, fill(sine, 0.0)))
    s11 = l11 * l11
    s12 = l11 * l21
    s22 = l21 * l21
    a00 = s11 * xx + sine.dtype(2.0) * (s12 * xz) + s22 * zz
    a01 = s11 * xy + s12 * (xw + yz) + s22 * zw
    a11 = s11 * yy + sine.dtype(2.0) * (s12 * yw) + s22 * ww
    a02 = l22 * (l11 * xz + l21 * zz)
    a03 = l22 * (l11 * xw + l21 * zw)
    a12 = l22 * (l11 * yz + l21 * zw)
    a13 = l22 * (l11 * yw + l21 * ww)
    l22 = l22 * l22
    a22 = l22 * zz
    a23 = l22 * zw
    a33 = l22 * ww
    # over its norm no eigenvalue is above one, and the largest not below a half: its powers fit any precision
    size = square_root(norm_squared(a00, a01, a02, a03, a11, a12, a13, a22, a23, a33))
    scaling = where_positive(size, one / size, one)
    a00 = a00 * scaling
    a01 = a01 * scaling
    a02 = a02 * scaling
    a03 = a03 * scaling
    a11 = a11 * scaling
    a12 = a12 * scaling
    a13 = a13 * scaling
    a22 = a22 * scaling
    a23 = a23 * scaling
    a33 = a33 * scaling
    squaring_count = int(4)  # noqa: UP018, a literal would be unrolled and take long to compile
    for _squaring in range(squaring_count):
        p00 = a00 * a00 + a01 * a01 + a02 * a02 + a03 * a03
        p01 = a00 * a01 + a01 * a11 + a02 * a12 + a03 * a13
        p02 = a00 * a02 + a01 * a12 + a02 * a22 + a03 * a23
        p03 = a00 * a03 + a01 * a13 + a02 * a23 + a03 * a33
        p11 = a01 * a01 + a11 * a11 + a12 * a12 + a13 * a13
        p12 = a01 * a02 + a11 * a12 + a12 * a22 + a13 * a23
        p13 = a01 * a03 + a11 * a13 + a12 * a23 + a13 * a33
        p22 = a02 * a02 + a12 * a12 + a22 * a22 + a23 * a23
        p23 = a02 * a03 + a12 * a13 + a22 * a23 + a23 * a33
        p33 = a03 * a03 + a13 * a13 + a23 * a23 + a33 * a33
        a00 = p00
        a01 = p01
        a02 = p02
        a03 = p03
        a11 = p11
        a12 = p12
        a13 = p13
        a22 = p22
        a23 = p23
        a33 = p33
    # the 16th root of |A^16|
    power = norm_squared(a00, a01, a02, a03, a11, a12, a13, a22, a23, a33)
    for _root in range(squaring_count + 1):
        power = square_root(power)
    return size * power


# Terms that couple positions and directors, as shares of the leading ones: proven bounds (docs/theory.md, section 7,
# *Coupled terms*), all but those of the yarns rounded up. Transverse shear by the tilt: of positions, linear and
# squared; of positions and directors.
TILT_STIFFENING = wp.constant(4.4)  # proven: 1 + sqrt 2 = 2.42
TILT_SQUARE_STIFFENING = wp.constant(8.5)  # proven: 1 + 2 sqrt 2 + (1 + sqrt 2)/2 = 5.04
TILT_COUPLING = wp.constant(5.4)  # proven: sqrt 5 = 2.24
# Bending by the curvature: of positions, squared; of positions and directors.
CURVATURE_STIFFENING = wp.constant(24.0)  # proven: 13.72
CURVATURE_COUPLING = wp.constant(7.4)  # proven: 5.17
YARN_CURVATURE_STIFFENING = wp.constant(19.0)
YARN_CURVATURE_COUPLING = wp.constant(6.0)
# The warping takes a quarter of x_h.d, and the mean d of four corners is at most half of their norm.
MEAN_WARPING = wp.constant(0.125)
# A step that shrinks goes to this share of the limit, so that it need not shrink again at once.
STEP_MARGIN = wp.constant(0.98)
# A step grows by one factor per refresh as soon as the limit is the other one above it.
STEP_GROWTH = wp.constant(1.02)
STEP_SLACK = wp.constant(1.05)


@cache
def step_bounds_struct(real: type):
    """What bounds a stable step beside the state, as a Warp struct."""

    @wp.struct
    class StepBounds:
        cell: wp.types.vector(3, real)  # largest stiffness of the cell along warp and weft, and in shear [N/m]
        bending: real  # largest bending stiffness of any curvature [N m]
        contact_frequency: real  # squared, of the contact springs [1/s^2]
        steps_ahead: wp.int32  # steps until the next look

    return StepBounds


def frequency_lane_count(lane_count: int, cell: CellLaw) -> int:
    """Lanes of ``element_frequency_kernel`` in a run with ``lane_count``: a cell that takes lane by lane gains none."""
    return 1 if cell.lane_by_lane else lane_count


@cache
def element_frequency_kernel(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """Square of each element's highest frequency, bounded from above [1/s^2].

    The bound is the largest eigenvalue of a 2 x 2 matrix of norms: of the second derivatives by the positions, by the
    directors, and of those that couple both, each over the lumped masses. In a flat element the first falls apart into
    motions in the plane, across it, and hourglass modes, of which the largest counts.
    """
    lanes = lane_types(real, lane_count).lanes
    Elements, UnitCell, SheetLaws = element_struct(real, lane_count), cell.parameters(real), sheet_struct(real)
    unknown_count, state_count, cell_shears = cell.unknown_count, cell.stable_state_count, cell.depends_on_shear
    Unknowns, StepBounds = wp.types.matrix((cell.row_count, lane_count), real), step_bounds_struct(real)
    stable_tangent = cell.stable_tangent
    flat, skewed, curved_shear, shear_slides = traits.flat, traits.skewed, traits.curved_shear, traits.shear_friction
    isotropic = traits.bending == int(BENDING_ISOTROPIC)

    @wp.kernel(module="unique", enable_backward=False)
    def element_frequencies(
        # In
        first: wp.int32,
        elements: Elements,
        cell: UnitCell,
        laws: SheetLaws,
        bounds: StepBounds,
        motion: wp.array(dtype=real),
        cell_unknowns: wp.array2d(dtype=lanes),
        inertia: wp.array2d(dtype=lanes),  # rows: inverse areal density with any added mass; inverse squared radius
        clock: wp.array(dtype=wp.float64),
        # Out
        squared_frequency: wp.array(dtype=lanes),
    ):
        e = first + wp.tid()
        a1, a2, mean_offset, x_hourglass = element_positions(elements, e, motion)
        d1, d2, mean_director, d_hourglass = element_vectors(elements, e, motion, DIRECTOR_ROW)
        m11, m12, m22, normal, area_ratio = surface_metric(a1, a2)
        strain1, strain2, stretch1, stretch2 = yarn_strains(m11, m22)
        bp1 = elements.shape_gradient[0, e]
        bp2 = elements.shape_gradient[1, e]
        bq1 = elements.shape_gradient[2, e]
        bq2 = elements.shape_gradient[3, e]
        zero = lanes()
        one = lanes(real(1.0))
        half = real(0.5)
        two = real(2.0)
        b11 = two * (bp1 * bp1 + bq1 * bq1)
        b22 = two * (bp2 * bp2 + bq2 * bq2)
        b12 = two * (bp1 * bp2 + bq1 * bq2)
        inverse_product = one / (stretch1 * stretch2)
        sine = m12 * inverse_product
        cosine = area_ratio * inverse_product
        angle = angle_of(m12, area_ratio, stretch1 * stretch2)

        # in the plane; where the present rate takes the yarns before the next look, twice as far for safety
        v1, v2, mean_velocity, v_hourglass = element_vectors(elements, e, motion, VELOCITY_ROW)
        horizon = two * real(clock[CLOCK_STEP]) * real(bounds.steps_ahead)
        strain1 = strain1 + horizon * (larger(dot(a1, v1), zero) / stretch1)
        strain2 = strain2 + horizon * (larger(dot(a2, v2), zero) / stretch2)
        angle_ahead = angle
        if wp.static(cell_shears):
            # dgamma/da_1 = (a_2 - a_1 m12/m11)/J
            rate = (dot(a2, v1) - dot(a1, v1) * m12 / m11 + dot(a1, v2) - dot(a2, v2) * m12 / m22) / area_ratio
            angle_ahead = angle + horizon * rate
        start = Unknowns()
        for k in range(unknown_count):
            start[k] = cell_unknowns[k, e]
        bundling = (two * laws.in_plane_bending_stiffness) * (bp1 * bq2 - bp2 * bq1)
        difference, square = corner_angles(elements, e, motion, angle)
        bundled = bundling * difference
        metric11 = m22 / (area_ratio * area_ratio)
        metric12 = -(m12 / (area_ratio * area_ratio))
        metric22 = m11 / (area_ratio * area_ratio)
        slope = laws.transverse_shear_stiffness * area_ratio
        in_plane = zero
        across = zero
        for state in range(state_count):
            c11, c12, c22, c13, c23, c33, n1, n2, turning, pressure = stable_tangent(
                cell, strain1, strain2, angle_ahead, start, state
            )
            # a tangent that no state of the cell can have comes from differences across a kink, where a yarn goes slack
            beyond = larger(magnitude(c11) - lanes(bounds.cell[0]), magnitude(c22) - lanes(bounds.cell[1]))
            beyond = larger(beyond, magnitude(c12) - lanes(wp.sqrt(bounds.cell[0] * bounds.cell[1])))
            if wp.static(cell_shears):
                beyond = larger(beyond, magnitude(c33) - lanes(bounds.cell[2]))
                beyond = larger(beyond, magnitude(c13) - lanes(wp.sqrt(bounds.cell[0] * bounds.cell[2])))
                beyond = larger(beyond, magnitude(c23) - lanes(wp.sqrt(bounds.cell[1] * bounds.cell[2])))
                c13 = where_positive(beyond, zero, c13)
                c23 = where_positive(beyond, zero, c23)
                c33 = where_positive(beyond, lanes(bounds.cell[2]), c33)
            c11 = where_positive(beyond, lanes(bounds.cell[0]), c11)
            c12 = where_positive(beyond, zero, c12)
            c22 = where_positive(beyond, lanes(bounds.cell[1]), c22)
            s11, s12, s22, s13, s23, s33, pull1, pull2, moment = shear_tangent(
                laws, curved_shear, shear_slides, stretch1, stretch2, sine, cosine, angle, pressure
            )
            if wp.static(cell_shears):
                s13 = s13 + c13
                s23 = s23 + c23
                s33 = s33 + c33
                moment = moment + turning
            n1 = larger(n1, zero) + pull1
            n2 = larger(n2, zero) + pull2
            moment = moment + bundled
            in_plane = larger(
                in_plane,
                largest_in_plane(
                    c11 + s11 + lanes(laws.compressive_stiffness),
                    c12 + s12,
                    c22 + s22 + lanes(laws.compressive_stiffness),
                    s13, s23, s33 + real(4.0) * bundling, n1, n2, moment,
                    stretch1, stretch2, sine, cosine, b11, b12, b22,
                ),
            )  # fmt: skip
            # across the plane: tension, shear and transverse shear
            turn = moment / area_ratio
            across = larger(
                across,
                largest_of_pencil(
                    n1 / stretch1 - turn * m12 / m11 + slope * metric11,
                    turn + slope * metric12,
                    n2 / stretch2 - turn * m12 / m22 + slope * metric22,
                    b11, b12, b22,
                ),
            )  # fmt: skip

        # what couples positions and directors: curvature [1/m], tilt of the directors, hourglass vectors; sizes in the
        # current metric
        gradient = largest_of_pencil(metric11, metric12, metric22, b11, b12, b22)
        squares = b11 + b22
        tilt1 = dot(a1, mean_director)
        tilt2 = dot(a2, mean_director)
        curvature = metric11 * dot(d1, d1) + two * (metric12 * dot(d1, d2)) + metric22 * dot(d2, d2)
        tilt = metric11 * tilt1 * tilt1 + two * (metric12 * tilt1 * tilt2) + metric22 * tilt2 * tilt2
        if wp.static(not flat):
            raising = metric11 + metric22
            k11 = elements.initial_curvature[0, e]
            k12 = elements.initial_curvature[1, e]
            k22 = elements.initial_curvature[2, e]
            g1 = elements.initial_transverse_shear[0, e]
            g2 = elements.initial_transverse_shear[1, e]
            curvature = two * (curvature + raising * raising * (k11 * k11 + two * (k12 * k12) + k22 * k22))
            tilt = two * (tilt + raising * (g1 * g1 + g2 * g2))
        curvature = square_root(larger(curvature, zero))
        tilt = square_root(larger(tilt, zero))
        x_odd = square_root(dot(x_hourglass, x_hourglass))
        d_odd = square_root(dot(d_hourglass, d_hourglass))
        root_gradient = square_root(gradient)
        lean = tilt + curvature / root_gradient + real(0.25) * d_odd
        radius = inertia[1, e]
        inverse_radius = square_root(radius)
        largest_metric = m11 + m22

        # transverse shear couples slopes and mean directors, by the directors' full length in a flat element too
        slope_positions = slope * gradient
        half_directors = lanes(half)
        if wp.static(skewed):
            skew11, skew12, skew13, skew21, skew22, skew23 = skew_weights(elements, e)
            skew = skew11 * skew11 + skew13 * skew13 + skew21 * skew21 + skew23 * skew23
            skew = skew + half * (skew12 * skew12 + skew22 * skew22)
            half_directors = half_directors + square_root(skew * gradient * largest_metric)
        mean_directors = slope * half_directors * half_directors * radius
        tilting = slope_positions * tilt * (lanes(real(TILT_STIFFENING)) + real(TILT_SQUARE_STIFFENING) * tilt)
        slope_coupling = square_root(slope_positions * mean_directors) * (one + real(TILT_COUPLING) * tilt)

        # bending couples positions and director gradients
        bending = bounds.bending * area_ratio
        stiffening = real(CURVATURE_STIFFENING)
        bent_coupling = real(CURVATURE_COUPLING)
        if wp.static(not isotropic):
            # these laws hold no J; oblique yarns share the curvature along the diagonal between them
            bending = bounds.bending * (one + magnitude(sine))
            stiffening = real(YARN_CURVATURE_STIFFENING)
            bent_coupling = real(YARN_CURVATURE_COUPLING)
        bending = bending * gradient
        bending_positions = (stiffening * bending) * (curvature * curvature)
        bending_coupling = (bent_coupling * bending) * (inverse_radius * curvature)
        bending_directors = bending * radius
        constraint = mean_directors * tilt * lean + bending_directors * curvature * lean / root_gradient

        # hourglass modes; x_h has the norm ``length``, the warping takes a quarter of it and ``twist`` of the curvature
        in_plane_stiffness, warping_stiffness, director_stiffness = hourglass_stiffnesses(elements, laws, e)
        offset_p = elements.hourglass_offset[0, e]
        offset_q = elements.hourglass_offset[1, e]
        length = square_root(lanes(real(4.0)) + two * (offset_p * offset_p + offset_q * offset_q))
        weight11, weight12, weight22 = twist_weights(elements, e)
        twist = square_root(squares * (weight11 * weight11 + half * weight12 * weight12 + weight22 * weight22))
        root_metric = square_root(largest_metric)
        tipping = x_odd * root_gradient
        in_plane_odd = in_plane_stiffness * length * (length + two * tipping * (one + tipping))
        warp_positions = real(0.25) * length + twist * root_metric * curvature
        warp_directors = inverse_radius * (twist * root_metric + real(MEAN_WARPING) * x_odd)
        warp = real(0.25) * x_odd + twist * curvature / root_gradient
        warp_coupling = warp_positions * warp_directors + warp * inverse_radius * (
            real(MEAN_WARPING) * length + twist * root_gradient
        )
        root_squares = square_root(squares)
        odd_positions = root_squares * d_odd
        odd_directors = inverse_radius * (length * root_metric)

        # in a flat element slopes with mean directors, and warping with director gradients, move by themselves
        positions = (
            larger(
                larger(in_plane, across) + tilting,
                larger(in_plane_odd, warping_stiffness * warp_positions * warp_positions),
            )
            + bending_positions
            + director_stiffness * odd_positions * odd_positions
        )
        directors = (
            larger(
                larger(mean_directors, bending_directors + warping_stiffness * warp_directors * warp_directors),
                director_stiffness * odd_directors * odd_directors,
            )
            + constraint
        )
        coupling = (
            larger(slope_coupling, warping_stiffness * warp_coupling)
            + bending_coupling
            + (two * director_stiffness) * (odd_positions * odd_directors)
        )
        mean = half * (positions + directors)
        difference = half * (positions - directors)
        largest = mean + square_root(difference * difference + coupling * coupling)
        squared_frequency[e] = real(4.0) * inertia[0, e] * largest + lanes(bounds.contact_frequency)

    return element_frequencies


@cache
def partial_maximum_kernel(real: type):
    """Largest entry of each group; a NaN becomes infinity, so that the step shrinks to nothing and the run stops."""
    lanes = lane_types(real, 1).lanes

    @wp.kernel(module="unique", enable_backward=False)
    def partial_maximum(group_size: wp.int32, values: wp.array(dtype=lanes), maxima: wp.array(dtype=real)):
        group = wp.tid()
        largest = real(0.0)
        for i in range(group * group_size, wp.min((group + 1) * group_size, values.shape[0])):
            value = values[i][0]
            # written so that a NaN, and infinity after it, stays
            largest = wp.where(value <= largest, largest, wp.where(value == value, value, real(wp.inf)))
        maxima[group] = largest

    return partial_maximum


@cache
def set_step_kernel(real: type):
    """The next time step: kept as long as it is stable and not far below what is, for every change costs energy.

    Central differences with a constant step keep an energy of their own; each change of the step breaks it, and since
    the stable step follows the state, the breaks add up.
    """

    @wp.kernel(module="unique", enable_backward=False)
    def set_step(
        maxima: wp.array(dtype=real),
        safety: wp.float64,
        largest_step: wp.float64,
        clock: wp.array(dtype=wp.float64),
    ):
        largest = real(0.0)
        for i in range(maxima.shape[0]):
            largest = wp.where(maxima[i] <= largest, largest, maxima[i])
        stable = safety * wp.float64(2.0) / wp.sqrt(wp.float64(largest))
        old = clock[CLOCK_STEP]
        new = old
        if not wp.min(stable, largest_step) >= old:  # a NaN shrinks the step too, and so stops the run
            new = wp.min(wp.float64(STEP_MARGIN) * stable, largest_step)
        elif stable > wp.float64(STEP_SLACK) * old:
            new = wp.min(wp.float64(STEP_GROWTH) * old, largest_step)
        clock[CLOCK_STEP] = new
        clock[CLOCK_MEAN_STEP] = wp.float64(0.5) * (old + new)

    return set_step
