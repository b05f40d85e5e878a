"""Kernel: nodal forces and couples of every element (docs/theory.md, 1 to 5)."""

from functools import cache
from typing import Any

import warp as wp

from ..cell.law import CellLaw
from ..cell.surplus import take_back_function
from ..fetching import expect, expect_next, expect_rows
from ..lane_types import GPU_LANE_COUNT, lane_types, step_options
from ..lanes import fill, negative, scale, where_positive
from ..laws.contract import device_law
from ..operators import add, div, mul, sub  # noqa: F401
from ..records import store_record3, store_record4
from ..rows import CORNER_ROW_COUNT, ROWS_PER_CORNER, CellReportRow, CornerRow, MotionRow
from .bending import bending_friction, resultants_struct, transverse_shear
from .hourglass import stabilisation_function, warping_moments
from .kinematics import (
    bend_function,
    corner_difference,
    mean_angles,
    membrane_function,
    shape_functions,
    shape_struct,
    skew_weights,
    vectors_functions,
    vectors_struct,
)
from .laws import SheetTraits, sheet_struct
from .membrane import add_compression, cell_answer_function, membrane_resultants, shear_moment_function
from .thickness import current_thickness


@cache
def resist_bending_function(traits: SheetTraits):
    """Function that fills ``Resultants`` beyond the membrane: bending and transverse shear; writes the slip."""
    bending_resultants, bending_slides = device_law(traits.bending).resultants, traits.bending_friction
    skewed = traits.skewed

    @wp.func
    def resist_bending(laws: Any, block: int, shape: Any, m: Any, b: Any, slip: Any, r: Any):
        # those of the membrane
        t11 = r.t11
        t12 = r.t12
        t22 = r.t22
        r = bending_resultants(laws, m, b, r)
        if wp.static(bending_slides):
            r = bending_friction(laws, block, m, b, slip, r)
        r.t11 = t11 + r.t11
        r.t12 = t12 + r.t12
        r.t22 = t22 + r.t22
        r = transverse_shear(laws, m, b, r)
        if wp.static(skewed):
            skew11, skew12, skew13, skew21, skew22, skew23 = skew_weights(shape)
            half = skew11.dtype(0.5)
            r.moment11 = r.moment11 + skew11 * r.shear_force1 + skew21 * r.shear_force2
            r.moment12 = r.moment12 + half * (skew12 * r.shear_force1 + skew22 * r.shear_force2)
            r.moment22 = r.moment22 + skew13 * r.shear_force1 + skew23 * r.shear_force2
        return r

    return resist_bending


@wp.func
def scaled_shape(shape: Any, area: Any):
    """Shape functions with gradients times the area."""
    shape.bp1 = area * shape.bp1
    shape.bp2 = area * shape.bp2
    shape.bq1 = area * shape.bq1
    shape.bq2 = area * shape.bq2
    return shape


@cache
def store_corners_function(has_scalar: bool):
    """Function that stores nodal vectors, signed as forces, and with ``has_scalar`` the same scalar at all corners."""

    @wp.func
    def store_corners(target: Any, row: int, block: int, shape: Any, v: Any, scalar: Any):
        """``v``: conjugates of both derivatives, of the hourglass vector and of the mean."""
        diagonal_p = corner_difference(shape.bp1, shape.bp2, v.by1, v.by2)
        diagonal_q = corner_difference(shape.bq1, shape.bq2, v.by1, v.by2)
        one = fill(shape.offset_p, 1.0)
        for corner in range(4):
            value = v.mean
            if corner == 0:
                value = negative(diagonal_p + scale(one - shape.offset_p, v.hourglass) + v.mean)
            elif corner == 1:
                value = negative(diagonal_q - scale(one + shape.offset_q, v.hourglass) + v.mean)
            elif corner == 2:
                value = diagonal_p - scale(one + shape.offset_p, v.hourglass) - v.mean
            else:
                value = diagonal_q + scale(one - shape.offset_q, v.hourglass) - v.mean
            if wp.static(has_scalar):
                store_record4(target, CORNER_ROW_COUNT, row + corner * ROWS_PER_CORNER, block, value, scalar)
            else:
                store_record3(target, CORNER_ROW_COUNT, row + corner * ROWS_PER_CORNER, block, value)

    return store_corners


@wp.func
def force_conjugates(area: Any, x: Any, d: Any, r: Any, h: Any, v: Any):
    """dpsi/da_alpha, and that of the hourglass vector times the area, into empty ``Vectors`` v."""
    v.by1 = (
        scale(r.t11, x.by1)
        + scale(r.t12, x.by2)
        + scale(r.moment11, d.by1)
        + scale(r.moment12, d.by2)
        + scale(r.shear_force1, d.mean)
        + scale(h.director_force1, d.hourglass)
        + scale(h.normal1, h.unit_normal)
    )
    v.by2 = (
        scale(r.t12, x.by1)
        + scale(r.t22, x.by2)
        + scale(r.moment12, d.by1)
        + scale(r.moment22, d.by2)
        + scale(r.shear_force2, d.mean)
        + scale(h.director_force2, d.hourglass)
        + scale(h.normal2, h.unit_normal)
    )
    quarter_warping = area.dtype(0.25) * h.warping_force
    by_hourglass = scale(h.in_plane, x.hourglass - scale(h.height, h.unit_normal))
    v.hourglass = scale(area, by_hourglass + scale(quarter_warping, d.mean))
    # the energy does not depend on the mean of the positions
    return v


@wp.func
def couple_conjugates(area: Any, x: Any, r: Any, h: Any, v: Any):
    """dpsi/dd_alpha, and those of the hourglass vector and the mean times the area, into empty ``Vectors`` v."""
    v.by1 = scale(r.moment11, x.by1) + scale(r.moment12, x.by2)
    v.by2 = scale(r.moment12, x.by1) + scale(r.moment22, x.by2)
    quarter = area.dtype(0.25)
    v.hourglass = scale(area, scale(h.director_force1, x.by1) + scale(h.director_force2, x.by2))
    by_mean = scale(r.shear_force1, x.by1) + scale(r.shear_force2, x.by2)
    by_mean = by_mean + scale(quarter * h.warping_force, x.hourglass)
    v.mean = scale(quarter * area, by_mean)
    return v


@cache
def expectations_function(lane_count: int, cell: CellLaw, traits: SheetTraits):
    """Function that starts to fetch: on a GPU what is read after the cell has written, else what the next block reads.

    Positions and directors come row by row of the mesh, which a processor sees by itself.
    """
    ahead, flat, shears = lane_count > GPU_LANE_COUNT, traits.flat, cell.depends_on_shear
    kept_count, angle = cell.kept_row_count, int(CellReportRow.shear_angle)  # the first row that some cells do without

    @wp.func
    def expect_late(elements: Any, block: int, cell_report: Any):
        expect_rows(cell_report, 0, angle, block)
        if wp.static(shears):
            expect_rows(cell_report, angle, 2, block)
        expect(elements.yarn_inertia, block)
        expect(elements.area, block)

    @wp.func
    def expect_next_block(elements: Any, block: int, cell_unknowns: Any, cell_report: Any):
        expect_next(elements.corner_node, 0, 4, block)
        expect_next(elements.shape_gradient, 0, 4, block)
        expect_next(elements.hourglass_offset, 0, 2, block)
        expect_next(elements.area, block)
        expect_next(elements.yarn_inertia, block)
        if wp.static(not flat):
            expect_next(elements.initial_curvature, 0, 3, block)
            expect_next(elements.initial_transverse_shear, 0, 2, block)
            expect_next(elements.initial_hourglass, 0, 3, block)
        expect_next(cell_unknowns, 0, kept_count, block)
        expect_next(cell_report, 0, angle, block)
        if wp.static(shears):
            expect_next(cell_report, angle, 2, block)

    @wp.func
    def expect_what_is_read(elements: Any, block: int, cell_unknowns: Any, cell_report: Any):
        if wp.static(not ahead):
            expect_late(elements, block, cell_report)
        elif elements.looks_ahead == 1:
            expect_next_block(elements, block, cell_unknowns, cell_report)

    return expect_what_is_read


@cache
def element_force_function(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """Function for the nodal forces and couples of one block of elements."""
    lanes, layout = lane_types(real, lane_count).lanes, (real, lane_count)
    Sheet, Shape, Resultants = sheet_struct(*layout, cell, traits), shape_struct(*layout), resultants_struct(*layout)
    Vectors = vectors_struct(*layout)
    positions, vectors = vectors_functions(*layout)
    stretch_membrane, bend = membrane_function(*layout), bend_function(*layout, traits.flat, traits.skewed)
    answer_cell, shear_moment = cell_answer_function(*layout, cell), shear_moment_function(cell, traits)
    resist_bending, stabilise = resist_bending_function(traits), stabilisation_function(*layout, traits.flat)
    expect_what_is_read = expectations_function(lane_count, cell, traits)
    take_back, follows_thickness = take_back_function(real, cell), traits.follows_thickness
    # sooner than to keep them in memory while the cell iterates; in double precision it is not
    reads_late = lane_count > GPU_LANE_COUNT and real is wp.float32
    store_forces, store_couples = store_corners_function(follows_thickness), store_corners_function(True)

    @wp.func
    def forces_of_block(
        # In
        block: wp.int32,
        sheet: Sheet,
        motion: wp.array(dtype=real),
        clock: wp.array(dtype=wp.float64),
        # Out
        cell_unknowns: wp.array2d(dtype=lanes),
        cell_report: wp.array2d(dtype=lanes),  # rows: see CellReportRow
        slip: wp.array2d(dtype=lanes),  # rows: see SlipRow; not touched without friction inside the sheet
        corner_force: wp.array2d(dtype=lanes),  # rows: see CornerRow
    ):
        elements = sheet.elements
        laws = sheet.laws
        expect_what_is_read(elements, block, cell_unknowns, cell_report)
        shape = shape_functions(elements, block, Shape())
        x, means = positions(elements, block, shape, motion)
        if wp.static(not reads_late):
            d = vectors(elements, block, shape, motion, MotionRow.director)
        m = stretch_membrane(x.by1, x.by2)

        answer = answer_cell(sheet.cell, block, m, cell_unknowns, cell_report)
        answer = add_compression(laws, m, answer)
        answer = take_back(elements.yarn_inertia, block, m, clock, answer, cell_report)
        # once more: reading them again is cheaper than keeping them while the cell iterates
        shape = shape_functions(elements, block, Shape())
        area = elements.area[block]
        if wp.static(lane_count == GPU_LANE_COUNT):
            means = mean_angles(elements, block, motion)  # read only now: they need registers
        if wp.static(reads_late):
            d = vectors(elements, block, shape, motion, MotionRow.director)  # so do these
        moment, shear12 = shear_moment(laws, block, shape, m, answer, means, slip)
        r = membrane_resultants(laws, m, answer, moment, shear12, Resultants())
        thickness = lanes()
        if wp.static(follows_thickness):
            # nodes with fewer neighbours read a padding element, which must add nothing
            thickness = where_positive(area, current_thickness(laws, m.area_ratio, answer.pressure), thickness)

        b = bend(elements, block, shape, x, d)
        r = resist_bending(laws, block, shape, m, b, slip, r)
        h = stabilise(elements, laws, block, shape, x, d, m, b)
        r = warping_moments(shape, h.warping_force, r)

        weights = scaled_shape(shape, area)
        forces = force_conjugates(area, x, d, r, h, Vectors())
        store_forces(corner_force, CornerRow.force, block, weights, forces, thickness)
        couples = couple_conjugates(area, x, r, h, Vectors())
        store_couples(corner_force, CornerRow.couple, block, weights, couples, m.angle)

    return forces_of_block


@cache
def element_force_kernel(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """Kernel, launched once per step: nodal forces and couples of every element."""
    lanes, Sheet = lane_types(real, lane_count).lanes, sheet_struct(real, lane_count, cell, traits)
    forces_of_block = element_force_function(real, lane_count, cell, traits)

    @wp.kernel(module="unique", enable_backward=False, module_options=step_options(real))
    def element_forces(
        # In
        first_block: wp.int32,
        sheet: Sheet,
        motion: wp.array(dtype=real),
        clock: wp.array(dtype=wp.float64),
        # Out
        cell_unknowns: wp.array2d(dtype=lanes),
        cell_report: wp.array2d(dtype=lanes),
        slip: wp.array2d(dtype=lanes),
        corner_force: wp.array2d(dtype=lanes),
    ):
        block = first_block + wp.tid()
        forces_of_block(block, sheet, motion, clock, cell_unknowns, cell_report, slip, corner_force)

    return element_forces
