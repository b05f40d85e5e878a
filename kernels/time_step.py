"""Stable time step from the condensed tangent of every element's own unit cell (docs/theory.md, section 7)."""

from functools import cache

import warp as wp

from .element import (
    VELOCITY_ROW,
    element_positions,
    element_struct,
    element_vectors,
    surface_metric,
    yarn_displacements,
)
from .lanes import angle_of, cross, div, dot, lane_types, larger, magnitude, mul, spread, square_root
from .node import CLOCK_MEAN_STEP, CLOCK_STEP
from .sheet import shear_tangent_bound, sheet_struct
from .unit_cell import condensed_tangent, solve_unit_cell, unit_cell_struct


@cache
def element_frequency_kernel(real: type):
    """Square of each element's highest frequency, bounded from above [1/s^2]; one lane, any number of elements."""
    types = lane_types(real, 1)
    lanes, lanes3, vec3 = types.lanes, types.lanes3, types.vec3
    Elements, UnitCell, SheetLaws = element_struct(real, 1), unit_cell_struct(real), sheet_struct(real)

    @wp.kernel(module="unique", enable_backward=False)
    def element_frequencies(
        # In
        first: wp.int32,
        elements: Elements,
        cell: UnitCell,
        laws: SheetLaws,
        motion: wp.array2d(dtype=vec3),
        crimp_change: wp.array2d(dtype=lanes),
        inertia: wp.array2d(dtype=lanes),  # rows: inverse areal density with any added mass; constant part [1/s^2]
        clock: wp.array(dtype=wp.float64),
        steps_ahead: wp.int32,
        # Out
        squared_frequency: wp.array(dtype=lanes),
    ):
        e = first + wp.tid()
        a1, a2, mean_offset, x_hourglass = element_positions(elements, e, motion, lanes3())
        m11, m12, m22, normal, area_ratio = surface_metric(a1, a2)
        u1, u2, stretch1, stretch2 = yarn_displacements(cell, m11, m22)
        # where the present rate takes the yarns before the step is looked at again, twice as far for safety
        v1, v2, mean_velocity, v_hourglass = element_vectors(elements, e, motion[VELOCITY_ROW], lanes3())
        horizon = real(2.0) * real(clock[CLOCK_STEP]) * real(steps_ahead)
        u1 = u1 + (horizon * cell.half_spacing[0]) * (larger(dot(a1, v1), lanes()) / stretch1)
        u2 = u2 + (horizon * cell.half_spacing[1]) * (larger(dot(a2, v2), lanes()) / stretch2)
        w1, w2, force1, force2, crossover, residual, iterations = solve_unit_cell(
            cell, u1, u2, crimp_change[0, e], crimp_change[1, e]
        )
        k11, k12, k22 = condensed_tangent(cell, u1, u2, w1, w2, True)
        half = real(0.5)
        l1 = cell.half_spacing[0]
        l2 = cell.half_spacing[1]
        # dn/dlambda [N/m]
        c11 = (half * l1 / l2) * k11
        c22 = (half * l2 / l1) * k22
        c12 = half * k12
        bp1 = elements.shape_gradient[0, e]
        bp2 = elements.shape_gradient[1, e]
        bq1 = elements.shape_gradient[2, e]
        bq2 = elements.shape_gradient[3, e]
        two = real(2.0)
        b11 = two * (bp1 * bp1 + bq1 * bq1)
        b22 = two * (bp2 * bp2 + bq2 * bq2)
        b12 = two * (bp1 * bp2 + bq1 * bq2) * m12 / (stretch1 * stretch2)
        # largest eigenvalue of C B, both symmetric
        trace = c11 * b11 + two * (c12 * b12) + c22 * b22
        determinant = (c11 * c22 - c12 * c12) * (b11 * b22 - b12 * b12)
        root = square_root(larger(real(0.25) * trace * trace - determinant, lanes()))
        membrane = half * trace + root
        # tension stiffens the directions across the yarn
        tension1 = larger(force1 / ((two * l2) * stretch1), lanes())
        tension2 = larger(force2 / ((two * l1) * stretch2), lanes())
        geometric = tension1 * b11 + tension2 * b22
        angle = angle_of(m12, area_ratio, stretch1 * stretch2)
        pressure = crossover / lanes(two * l1 * l2)
        shear = two * shear_tangent_bound(laws, m11, m12, m22, area_ratio, angle, pressure) * (b11 / m11 + b22 / m22)
        # raised indices: in a sheared sheet the same curvature or slope costs more along the narrow diagonal
        metric_growth = (stretch1 * stretch2 + magnitude(m12)) / area_ratio
        squared_frequency[e] = (
            real(4.0) * inertia[0, e] * (larger(membrane, magnitude(trace - membrane)) + geometric + shear)
            + metric_growth * inertia[1, e]
        )

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
