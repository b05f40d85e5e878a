"""Kernel: nodal forces and couples of every element (docs/theory.md, 1 to 5)."""

from functools import cache
from typing import Any

import warp as wp

from ..cell.law import CellLaw
from ..cell.surplus import take_back_function
from ..lanes import expect, expect_rows, fill, lane_types, scale, step_options, where_positive
from ..laws.contract import device_law
from ..operators import div, mul  # noqa: F401
from ..rows import ROWS_PER_CORNER, CellReportRow, CornerRow, MotionRow
from .bending import bending_friction, resultants_struct, transverse_shear
from .hourglass import stabilisation_function, warping_moments
from .kinematics import (
    bend_function,
    corner_difference,
    membrane_function,
    shape_functions,
    shape_struct,
    skew_weights,
    vectors_functions,
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


@wp.func
def store_corners(target: Any, row: int, block: int, shape: Any, by1: Any, by2: Any, hourglass: Any, mean: Any):
    """Nodal values from the conjugates of both derivatives, the hourglass vector and the mean, signed as forces."""
    diagonal_p = corner_difference(shape.bp1, shape.bp2, by1, by2)
    diagonal_q = corner_difference(shape.bq1, shape.bq2, by1, by2)
    offset_p = shape.offset_p
    offset_q = shape.offset_q
    one = fill(offset_p, 1.0)
    for i in range(3):
        target[row + i, block] = -(diagonal_p[i] + (one - offset_p) * hourglass[i] + mean[i])
        target[row + 1 * ROWS_PER_CORNER + i, block] = -(diagonal_q[i] - (one + offset_q) * hourglass[i] + mean[i])
        target[row + 2 * ROWS_PER_CORNER + i, block] = diagonal_p[i] - (one + offset_p) * hourglass[i] - mean[i]
        target[row + 3 * ROWS_PER_CORNER + i, block] = diagonal_q[i] + (one - offset_q) * hourglass[i] - mean[i]


@wp.func
def assemble_forces(corner_force: Any, block: int, shape: Any, area: Any, x: Any, d: Any, r: Any, h: Any):
    """Forces at the corners, from dpsi/da_alpha and dpsi/dx_h; ``shape`` is scaled by the area."""
    by_a1 = (
        scale(r.t11, x.by1)
        + scale(r.t12, x.by2)
        + scale(r.moment11, d.by1)
        + scale(r.moment12, d.by2)
        + scale(r.shear_force1, d.mean)
        + scale(h.director_force1, d.hourglass)
        + scale(h.normal1, h.unit_normal)
    )
    by_a2 = (
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
    by_hourglass = by_hourglass + scale(quarter_warping, d.mean)
    # the energy does not depend on the mean of the positions
    mean = type(by_hourglass)()
    store_corners(corner_force, CornerRow.force, block, shape, by_a1, by_a2, scale(area, by_hourglass), mean)


@wp.func
def assemble_couples(corner_force: Any, block: int, shape: Any, area: Any, x: Any, r: Any, h: Any):
    """Couples at the corners, from dpsi/dd_alpha, dpsi/dd_h and dpsi/d(mean director)."""
    by_d1 = scale(r.moment11, x.by1) + scale(r.moment12, x.by2)
    by_d2 = scale(r.moment12, x.by1) + scale(r.moment22, x.by2)
    quarter = area.dtype(0.25)
    by_hourglass = scale(h.director_force1, x.by1) + scale(h.director_force2, x.by2)
    by_mean = scale(r.shear_force1, x.by1) + scale(r.shear_force2, x.by2)
    by_mean = by_mean + scale(quarter * h.warping_force, x.hourglass)
    mean = scale(quarter * area, by_mean)
    store_corners(corner_force, CornerRow.couple, block, shape, by_d1, by_d2, scale(area, by_hourglass), mean)


@wp.func
def store_everywhere(corner_force: Any, row: int, block: int, value: Any):
    """Store the same scalar at all corners."""
    for corner in range(4):
        corner_force[row + ROWS_PER_CORNER * corner, block] = value


@wp.func
def expect_what_is_read_late(elements: Any, block: int, cell_report: Any):
    """On a GPU, start to fetch what is read after the cell has written its unknowns."""
    expect_rows(cell_report, 0, wp.static(CellReportRow.row_count()), block)
    expect(elements.yarn_inertia, block)
    expect(elements.area, block)


@cache
def element_force_kernel(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """Kernel, launched once per step: nodal forces and couples of every element."""
    lanes, layout = lane_types(real, lane_count).lanes, (real, lane_count)
    Sheet, Shape, Resultants = sheet_struct(*layout, cell, traits), shape_struct(*layout), resultants_struct(*layout)
    positions, vectors = vectors_functions(*layout)
    stretch_membrane, bend = membrane_function(*layout), bend_function(*layout, traits.flat, traits.skewed)
    answer_cell, shear_moment = cell_answer_function(*layout, cell), shear_moment_function(cell, traits)
    resist_bending, stabilise = resist_bending_function(traits), stabilisation_function(*layout, traits.flat)
    take_back, follows_thickness = take_back_function(real, cell), traits.follows_thickness

    @wp.kernel(module="unique", enable_backward=False, module_options=step_options(real))
    def element_forces(
        # In
        first_block: wp.int32,
        sheet: Sheet,
        motion: wp.array(dtype=real),
        clock: wp.array(dtype=wp.float64),
        # Out
        cell_unknowns: wp.array2d(dtype=lanes),
        cell_report: wp.array2d(dtype=lanes),  # rows: see CellReportRow
        slip: wp.array2d(dtype=lanes),  # rows: see SlipRow; not touched without friction inside the sheet
        corner_force: wp.array2d(dtype=lanes),  # rows: see CornerRow
    ):
        block = first_block + wp.tid()
        elements = sheet.elements
        laws = sheet.laws
        expect_what_is_read_late(elements, block, cell_report)
        shape = shape_functions(elements, block, Shape())
        x = positions(elements, block, shape, motion)
        d = vectors(elements, block, shape, motion, MotionRow.director)
        m = stretch_membrane(x.by1, x.by2)

        answer = answer_cell(sheet.cell, block, m, cell_unknowns, cell_report)
        answer = add_compression(laws, m, answer)
        answer = take_back(elements.yarn_inertia, block, m, clock, answer, cell_report)
        # once more: reading them again is cheaper than keeping them while the cell iterates
        shape = shape_functions(elements, block, Shape())
        area = elements.area[block]
        moment, shear12 = shear_moment(elements, laws, block, shape, m, answer, motion, slip)
        r = membrane_resultants(laws, m, answer, moment, shear12, Resultants())
        store_everywhere(corner_force, CornerRow.angle, block, m.angle)
        if wp.static(follows_thickness):
            # nodes with fewer neighbours read a padding element, which must add nothing
            thickness = where_positive(area, current_thickness(laws, m.area_ratio, answer.pressure), lanes())
            store_everywhere(corner_force, CornerRow.thickness, block, thickness)

        b = bend(elements, block, shape, x, d)
        r = resist_bending(laws, block, shape, m, b, slip, r)
        h = stabilise(elements, laws, block, shape, x, d, m, b)
        r = warping_moments(shape, h.warping_force, r)

        weights = scaled_shape(shape, area)
        assemble_forces(corner_force, block, weights, area, x, d, r, h)
        assemble_couples(corner_force, block, weights, area, x, r, h)

    return element_forces
