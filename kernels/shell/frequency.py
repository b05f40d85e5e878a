"""Stable time step from the condensed tangent of every element's own unit cell (docs/theory.md, section 7)."""

from functools import cache

import warp as wp

from ..cell.law import CellLaw
from ..lanes import angle_of, div, dot, lane_types, larger, magnitude, mul, square_root, where_positive  # noqa: F401 - operators of lanes
from ..rows import ClockEntry, CurvatureRow, GradientRow, InertiaRow, MotionRow, OffsetRow, TransverseShearRow
from .eigenvalue import largest_in_plane, largest_of_pencil
from .hourglass import hourglass_stiffnesses, twist_weights
from .kinematics import (
    corner_angles,
    element_positions,
    element_struct,
    element_vectors,
    skew_weights,
    surface_metric,
    yarn_strains,
)
from .laws import SheetTraits, sheet_struct
from .shear import shear_tangent


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
        inertia: wp.array2d(dtype=lanes),  # rows: see InertiaRow
        clock: wp.array(dtype=wp.float64),
        # Out
        squared_frequency: wp.array(dtype=lanes),
    ):
        e = first + wp.tid()
        a1, a2, mean_offset, x_hourglass = element_positions(elements, e, motion)
        d1, d2, mean_director, d_hourglass = element_vectors(elements, e, motion, MotionRow.director)
        m11, m12, m22, normal, area_ratio = surface_metric(a1, a2)
        strain1, strain2, stretch1, stretch2 = yarn_strains(m11, m22)
        bp1 = elements.shape_gradient[GradientRow.p1, e]
        bp2 = elements.shape_gradient[GradientRow.p2, e]
        bq1 = elements.shape_gradient[GradientRow.q1, e]
        bq2 = elements.shape_gradient[GradientRow.q2, e]
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
        v1, v2, mean_velocity, v_hourglass = element_vectors(elements, e, motion, MotionRow.velocity)
        horizon = two * real(clock[ClockEntry.step]) * real(bounds.steps_ahead)
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
            k11 = elements.initial_curvature[CurvatureRow.k11, e]
            k12 = elements.initial_curvature[CurvatureRow.k12, e]
            k22 = elements.initial_curvature[CurvatureRow.k22, e]
            g1 = elements.initial_transverse_shear[TransverseShearRow.g1, e]
            g2 = elements.initial_transverse_shear[TransverseShearRow.g2, e]
            curvature = two * (curvature + raising * raising * (k11 * k11 + two * (k12 * k12) + k22 * k22))
            tilt = two * (tilt + raising * (g1 * g1 + g2 * g2))
        curvature = square_root(larger(curvature, zero))
        tilt = square_root(larger(tilt, zero))
        x_odd = square_root(dot(x_hourglass, x_hourglass))
        d_odd = square_root(dot(d_hourglass, d_hourglass))
        root_gradient = square_root(gradient)
        lean = tilt + curvature / root_gradient + real(0.25) * d_odd
        radius = inertia[InertiaRow.inverse_squared_radius, e]
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
        tilting = slope_positions * tilt * (lanes(real(4.4)) + real(8.5) * tilt)
        slope_coupling = square_root(slope_positions * mean_directors) * (one + real(5.4) * tilt)

        # bending couples positions and director gradients
        bending = (bounds.bending * area_ratio) * gradient
        bending_positions = (real(24.0) * bending) * (curvature * curvature)
        bending_coupling = (real(7.4) * bending) * (inverse_radius * curvature)
        bending_directors = bending * radius
        constraint = mean_directors * tilt * lean + bending_directors * curvature * lean / root_gradient

        # hourglass modes; x_h has the norm ``length``, the warping takes a quarter of it and ``twist`` of the curvature
        in_plane_stiffness, warping_stiffness, director_stiffness = hourglass_stiffnesses(elements, laws, e)
        offset_p = elements.hourglass_offset[OffsetRow.p, e]
        offset_q = elements.hourglass_offset[OffsetRow.q, e]
        length = square_root(lanes(real(4.0)) + two * (offset_p * offset_p + offset_q * offset_q))
        weight11, weight12, weight22 = twist_weights(elements, e)
        twist = square_root(squares * (weight11 * weight11 + half * weight12 * weight12 + weight22 * weight22))
        root_metric = square_root(largest_metric)
        tipping = x_odd * root_gradient
        in_plane_odd = in_plane_stiffness * length * (length + two * tipping * (one + tipping))
        warp_positions = real(0.25) * length + twist * root_metric * curvature
        warp_directors = inverse_radius * (twist * root_metric + real(0.125) * x_odd)
        warp = real(0.25) * x_odd + twist * curvature / root_gradient
        warp_coupling = warp_positions * warp_directors + warp * inverse_radius * (
            real(0.125) * length + twist * root_gradient
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
        squared_frequency[e] = real(4.0) * inertia[InertiaRow.inverse_areal_density, e] * largest + lanes(
            bounds.contact_frequency
        )

    return element_frequencies
