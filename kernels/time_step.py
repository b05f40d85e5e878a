"""Stable time step from the condensed tangent of every element's own unit cell (docs/theory.md, section 7)."""

from functools import cache
from typing import Any

import warp as wp

from .cell import CellLaw
from .element import (
    VELOCITY_ROW,
    element_positions,
    element_struct,
    element_vectors,
    surface_metric,
    yarn_strains,
)
from .lanes import angle_of, cross, div, dot, lane_types, larger, magnitude, mul, spread, square_root
from .node import CLOCK_MEAN_STEP, CLOCK_STEP
from .sheet import shear_tangent_bound, sheet_struct


@wp.func
def spectral_radius_bound(a: Any):
    """|A^16|^(1/16) in the Frobenius norm: never below the largest |eigenvalue| of a 3 x 3 matrix, at most 4 % above.

    The 4 % hold where A is similar to a symmetric matrix. A NaN stays one.
    """
    size = a.dtype(0.0)
    for i in range(3):
        size = size + wp.dot(a[i], a[i])
    size = wp.sqrt(size)
    bound = size
    # the logarithm keeps single precision from overflowing
    if size > a.dtype(0.0):
        power = a / size
        bound_log = wp.log(size)
        share = a.dtype(1.0)
        for _k in range(4):
            power = power * power
            share = a.dtype(0.5) * share
            norm = wp.sqrt(wp.dot(power[0], power[0]) + wp.dot(power[1], power[1]) + wp.dot(power[2], power[2]))
            bound_log = bound_log + share * wp.log(norm)
            power = power / norm
        bound = wp.exp(bound_log)
    return bound


@cache
def element_frequency_kernel(real: type, cell: CellLaw):
    """Square of each element's highest frequency, bounded from above [1/s^2]; one lane, any number of elements."""
    types = lane_types(real, 1)
    lanes, lanes3, vec3 = types.lanes, types.lanes3, types.vec3
    Elements, UnitCell, SheetLaws = element_struct(real, 1), cell.parameters(real), sheet_struct(real)
    unknown_count, state_count, cell_shears = cell.unknown_count, cell.stable_state_count, cell.depends_on_shear
    Unknowns = wp.types.matrix((cell.row_count, 1), real)
    mat33 = wp.types.matrix((3, 3), real)
    stable_tangent = cell.stable_tangent

    @wp.kernel(module="unique", enable_backward=False)
    def element_frequencies(
        # In
        first: wp.int32,
        elements: Elements,
        cell: UnitCell,
        laws: SheetLaws,
        motion: wp.array2d(dtype=vec3),
        cell_unknowns: wp.array2d(dtype=lanes),
        inertia: wp.array2d(dtype=lanes),  # rows: inverse areal density with any added mass; constant part [1/s^2]
        clock: wp.array(dtype=wp.float64),
        steps_ahead: wp.int32,
        # Out
        squared_frequency: wp.array(dtype=lanes),
    ):
        e = first + wp.tid()
        a1, a2, mean_offset, x_hourglass = element_positions(elements, e, motion, lanes3())
        m11, m12, m22, normal, area_ratio = surface_metric(a1, a2)
        strain1, strain2, stretch1, stretch2 = yarn_strains(m11, m22)
        angle = angle_of(m12, area_ratio, stretch1 * stretch2)
        # where the present rate takes the yarns before the step is looked at again, twice as far for safety
        v1, v2, mean_velocity, v_hourglass = element_vectors(elements, e, motion[VELOCITY_ROW], lanes3())
        horizon = real(2.0) * real(clock[CLOCK_STEP]) * real(steps_ahead)
        strain1 = strain1 + horizon * (larger(dot(a1, v1), lanes()) / stretch1)
        strain2 = strain2 + horizon * (larger(dot(a2, v2), lanes()) / stretch2)
        angle_ahead = angle
        if wp.static(cell_shears):
            # dgamma/da_1 = (a_2 - a_1 m12/m11)/J
            rate = (dot(a2, v1) - dot(a1, v1) * m12 / m11 + dot(a1, v2) - dot(a2, v2) * m12 / m22) / area_ratio
            angle_ahead = angle + horizon * rate
        start = Unknowns()
        for k in range(unknown_count):
            start[k] = cell_unknowns[k, e]
        bp1 = elements.shape_gradient[0, e]
        bp2 = elements.shape_gradient[1, e]
        bq1 = elements.shape_gradient[2, e]
        bq2 = elements.shape_gradient[3, e]
        half = real(0.5)
        two = real(2.0)
        sum11 = two * (bp1 * bp1 + bq1 * bq1)
        sum22 = two * (bp2 * bp2 + bq2 * bq2)
        sum12 = two * (bp1 * bp2 + bq1 * bq2)
        b12 = sum12 * m12 / (stretch1 * stretch2)
        highest = lanes()
        pressure = lanes()
        for state in range(state_count):
            c11, c12, c22, c13, c23, c33, force1, force2, moment, pressed = stable_tangent(
                cell, strain1, strain2, angle_ahead, start, state
            )
            membrane = lanes()
            if wp.static(cell_shears):
                # the same with the angle as the third strain, whose gradients across the yarns are 1/lambda long
                b13 = sum12 * area_ratio / (stretch1 * m22)
                b23 = sum12 * area_ratio / (stretch2 * m11)
                b33 = sum11 / m11 + sum22 / m22 - two * sum12 * m12 / (m11 * m22)
                stiffness = mat33(c11[0], c12[0], c13[0], c12[0], c22[0], c23[0], c13[0], c23[0], c33[0])
                gram = mat33(sum11[0], b12[0], b13[0], b12[0], sum22[0], b23[0], b13[0], b23[0], b33[0])
                membrane = lanes(spectral_radius_bound(stiffness * gram))
            else:
                # largest eigenvalue of C B, both symmetric
                trace = c11 * sum11 + two * (c12 * b12) + c22 * sum22
                determinant = (c11 * c22 - c12 * c12) * (sum11 * sum22 - b12 * b12)
                root = square_root(larger(real(0.25) * trace * trace - determinant, lanes()))
                membrane = half * trace + root
                membrane = larger(membrane, magnitude(trace - membrane))
            # tension stiffens the directions across the yarn, a moment those in which the angle is not linear
            membrane = membrane + larger(force1 / stretch1, lanes()) * sum11
            membrane = membrane + larger(force2 / stretch2, lanes()) * sum22
            if wp.static(cell_shears):
                turning = magnitude(moment) * (lanes(real(1.0)) + magnitude(m12) / area_ratio)
                membrane = membrane + two * turning * (sum11 / m11 + sum22 / m22)
            highest = larger(highest, membrane)
            pressure = larger(pressure, pressed)
        tangent_bound = shear_tangent_bound(laws, m11, m12, m22, area_ratio, angle, pressure)
        shear = two * tangent_bound * (sum11 / m11 + sum22 / m22)
        # raised indices: in a sheared sheet the same curvature or slope costs more along the narrow diagonal
        metric_growth = (stretch1 * stretch2 + magnitude(m12)) / area_ratio
        squared_frequency[e] = real(4.0) * inertia[0, e] * (highest + shear) + metric_growth * inertia[1, e]

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
    """The next time step: a share of 2/omega, growing by at most 2 % per refresh."""

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
        limit = wp.min(safety * wp.float64(2.0) / wp.sqrt(wp.float64(largest)), largest_step)
        old = clock[CLOCK_STEP]
        new = wp.min(limit, wp.float64(1.02) * old)
        clock[CLOCK_STEP] = new
        clock[CLOCK_MEAN_STEP] = wp.float64(0.5) * (old + new)

    return set_step
