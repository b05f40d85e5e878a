"""Kernel: nodal forces and director gradients of every element (docs/theory.md, 1 to 5)."""

from functools import cache
from typing import Any

import warp as wp

from ..cell.law import CellLaw
from ..lanes import (  # noqa: F401 - operators of lanes
    angle_of,
    div,
    dot,
    fill,
    inverses,
    lane_maximum,
    lane_types,
    larger,
    mul,
    scale,
    where_positive,
)
from ..rows import ROWS_PER_CORNER, CellReportRow, CornerRow, GradientRow, MotionRow, OffsetRow, SlipRow
from .bending import bending_friction, bending_moments, transverse_shear_forces
from .hourglass import hourglass_stiffnesses, hourglass_strains, twist_weights
from .kinematics import (
    corner_angles,
    corner_difference,
    element_positions,
    element_strains,
    element_struct,
    element_vectors,
    skew_weights,
    surface_metric,
    yarn_strains,
)
from .laws import SheetTraits, sheet_struct
from .shear import moment_resultants, shear_friction, shear_resultants
from .thickness import compressive_force, current_thickness


@wp.func
def store_corners(
    target: Any,
    row: int,
    e: int,
    diagonal_p: Any,
    diagonal_q: Any,
    hourglass: Any,
    mean: Any,
    offset_p: Any,
    offset_q: Any,
):
    """Nodal values from the conjugates of p, q, the hourglass vector and the mean, with the minus sign of a force."""
    one = fill(offset_p, 1.0)
    for i in range(3):
        target[row + i, e] = -(diagonal_p[i] + (one - offset_p) * hourglass[i] + mean[i])
        target[row + 1 * ROWS_PER_CORNER + i, e] = -(diagonal_q[i] - (one + offset_q) * hourglass[i] + mean[i])
        target[row + 2 * ROWS_PER_CORNER + i, e] = diagonal_p[i] - (one + offset_p) * hourglass[i] - mean[i]
        target[row + 3 * ROWS_PER_CORNER + i, e] = diagonal_q[i] + (one - offset_q) * hourglass[i] - mean[i]


@cache
def element_force_kernel(real: type, lane_count: int, cell: CellLaw, traits: SheetTraits):
    """Kernel of one launch per step: nodal forces and director gradients of every element."""
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    Elements, UnitCell, SheetLaws = element_struct(real, lane_count), cell.parameters(real), sheet_struct(real)
    row_count, unknown_count = cell.row_count, cell.unknown_count
    Unknowns = wp.types.matrix((row_count, lane_count), real)
    solve, snap_loss, cell_shears = cell.solve, cell.snap_loss, cell.depends_on_shear
    flat, skewed, curved_shear, bending_kind = traits.flat, traits.skewed, traits.curved_shear, traits.bending
    shear_slides, bending_slides = traits.shear_friction, traits.bending_friction
    follows_thickness = traits.follows_thickness

    @wp.kernel(module="unique", enable_backward=False)
    def element_forces(
        # In
        first_block: wp.int32,
        elements: Elements,
        cell: UnitCell,
        laws: SheetLaws,
        motion: wp.array(dtype=real),
        # Out
        cell_unknowns: wp.array2d(dtype=lanes),
        cell_report: wp.array2d(dtype=lanes),  # rows: see CellReportRow
        slip: wp.array2d(dtype=lanes),  # rows: see SlipRow; not touched without friction inside the sheet
        corner_force: wp.array2d(dtype=lanes),
    ):
        e = first_block + wp.tid()
        a1, a2, mean_offset, x_hourglass = element_positions(elements, e, motion)
        d1, d2, mean_director, d_hourglass = element_vectors(elements, e, motion, MotionRow.director)

        m11, m12, m22, normal, area_ratio = surface_metric(a1, a2)

        # membrane: the unit cell
        strain1, strain2, stretch1, stretch2 = yarn_strains(m11, m22)
        angle = angle_of(m12, area_ratio, stretch1 * stretch2)
        start = Unknowns()
        for k in range(unknown_count):
            start[k] = cell_unknowns[k, e]
        unknowns, warp_force, weft_force, cell_moment, pressure, residual, iterations = solve(
            cell, strain1, strain2, angle, start
        )
        for k in range(unknown_count):
            cell_unknowns[k, e] = unknowns[k]
        cell_report[CellReportRow.iterations, e] = iterations
        cell_report[CellReportRow.worst_residual, e] = larger(cell_report[CellReportRow.worst_residual, e], residual)
        if wp.static(unknown_count > 0):
            freed = snap_loss(cell, strain1, strain2, angle, start, unknowns)
            if lane_maximum(freed) > real(0.0):
                cell_report[CellReportRow.snap_loss, e] = cell_report[CellReportRow.snap_loss, e] + freed
        inverse1, inverse2 = inverses(stretch1, stretch2)
        inverse_ratio = lanes(real(1.0)) / area_ratio
        t11 = (warp_force + compressive_force(laws, stretch1)) * inverse1
        t22 = (weft_force + compressive_force(laws, stretch2)) * inverse2

        # in-plane shear, and the in-plane bending of the yarns, which resists a shear angle that varies
        # (b_p x b_q) is 1/(2 area); the area itself is zero in padding elements
        inverse_area = real(2.0) * (
            elements.shape_gradient[GradientRow.p1, e] * elements.shape_gradient[GradientRow.q2, e]
            - elements.shape_gradient[GradientRow.p2, e] * elements.shape_gradient[GradientRow.q1, e]
        )
        moment, linear12 = shear_resultants(laws, curved_shear, m12, angle)
        if wp.static(cell_shears):
            moment = moment + cell_moment
        difference, square = corner_angles(elements, e, motion, angle)
        moment = moment + (laws.in_plane_bending_stiffness * inverse_area) * difference
        if wp.static(shear_slides):
            turned, spring, lost = shear_friction(
                laws, angle, slip[SlipRow.shear_slip, e], slip[SlipRow.shear_spring, e], pressure
            )
            slip[SlipRow.shear_slip, e] = turned
            slip[SlipRow.shear_spring, e] = spring
            slip[SlipRow.shear_friction_loss, e] = slip[SlipRow.shear_friction_loss, e] + lost
            moment = moment + laws.shear.friction_stiffness * spring
        shear11, shear12, shear22 = moment_resultants(moment, m12, inverse1, inverse2, inverse_ratio)
        shear12 = shear12 + linear12
        for corner in range(4):
            corner_force[CornerRow.angle + ROWS_PER_CORNER * corner, e] = angle
        if wp.static(follows_thickness):
            # nodes with fewer neighbours read a padding element, which must add nothing
            thickness = where_positive(elements.area[e], current_thickness(laws, area_ratio, pressure), lanes())
            for corner in range(4):
                corner_force[CornerRow.thickness + ROWS_PER_CORNER * corner, e] = thickness

        # bending and transverse shear
        k11, k12, k22, g1, g2 = element_strains(elements, e, flat, skewed, a1, a2, d1, d2, mean_director)
        moment11, moment12, moment22, bend11, bend12, bend22 = bending_moments(
            laws, bending_kind, m11, m12, m22, inverse_ratio, k11, k12, k22
        )
        if wp.static(bending_slides):
            warp_slip, warp_spring, warp_loss = bending_friction(
                laws, 0, k11 / m11, slip[SlipRow.warp_bending_slip, e], slip[SlipRow.warp_bending_spring, e]
            )
            weft_slip, weft_spring, weft_loss = bending_friction(
                laws, 1, k22 / m22, slip[SlipRow.weft_bending_slip, e], slip[SlipRow.weft_bending_spring, e]
            )
            slip[SlipRow.warp_bending_slip, e] = warp_slip
            slip[SlipRow.weft_bending_slip, e] = weft_slip
            slip[SlipRow.warp_bending_spring, e] = warp_spring
            slip[SlipRow.weft_bending_spring, e] = weft_spring
            warp_moment = laws.bending.friction_stiffness[0] * warp_spring
            weft_moment = laws.bending.friction_stiffness[1] * weft_spring
            slip[SlipRow.bending_friction_loss, e] = slip[SlipRow.bending_friction_loss, e] + warp_loss + weft_loss
            moment11 = moment11 + warp_moment / m11
            moment22 = moment22 + weft_moment / m22
            bend11 = bend11 - real(2.0) * warp_moment * k11 / (m11 * m11)
            bend22 = bend22 - real(2.0) * weft_moment * k22 / (m22 * m22)
        q1, q2, slide11, slide12, slide22 = transverse_shear_forces(
            laws, m11, m12, m22, area_ratio, inverse_ratio, g1, g2
        )
        if wp.static(skewed):
            skew11, skew12, skew13, skew21, skew22, skew23 = skew_weights(elements, e)
            moment11 = moment11 + skew11 * q1 + skew21 * q2
            moment12 = moment12 + real(0.5) * (skew12 * q1 + skew22 * q2)
            moment22 = moment22 + skew13 * q1 + skew23 * q2
        t11 = t11 + shear11 + bend11 + slide11
        t12 = shear12 + bend12 + slide12
        t22 = t22 + shear22 + bend22 + slide22

        # stabilisation
        in_plane, warping_stiffness, director_stiffness = hourglass_stiffnesses(elements, laws, e)
        warping, twist1, twist2 = hourglass_strains(
            elements, e, flat, a1, a2, mean_director, x_hourglass, d_hourglass, k11, k12, k22
        )
        warping_force = warping_stiffness * warping
        weight11, weight12, weight22 = twist_weights(elements, e)
        moment11 = moment11 + weight11 * warping_force
        moment12 = moment12 + real(0.5) * weight12 * warping_force
        moment22 = moment22 + weight22 * warping_force
        twist1 = director_stiffness * twist1
        twist2 = director_stiffness * twist2
        unit_normal = scale(inverse_ratio, normal)
        height = dot(x_hourglass, unit_normal)
        # the in-plane part |x_h|^2 - (x_h.n)^2 turns with the normal: height * (x_h . a^alpha) n
        height1 = dot(x_hourglass, a1)
        height2 = dot(x_hourglass, a2)
        tilt = in_plane * height * inverse_ratio * inverse_ratio
        normal1 = tilt * (m22 * height1 - m12 * height2)
        normal2 = tilt * (m11 * height2 - m12 * height1)

        # dpsi/da_alpha, dpsi/dd_alpha, dpsi/d(mean director), dpsi/d(hourglass vectors)
        p1 = (
            scale(t11, a1)
            + scale(t12, a2)
            + scale(moment11, d1)
            + scale(moment12, d2)
            + scale(q1, mean_director)
            + scale(twist1, d_hourglass)
            + scale(normal1, unit_normal)
        )
        p2 = (
            scale(t12, a1)
            + scale(t22, a2)
            + scale(moment12, d1)
            + scale(moment22, d2)
            + scale(q2, mean_director)
            + scale(twist2, d_hourglass)
            + scale(normal2, unit_normal)
        )
        r1 = scale(moment11, a1) + scale(moment12, a2)
        r2 = scale(moment12, a1) + scale(moment22, a2)
        quarter_warping = real(0.25) * warping_force
        x_stabilising = scale(in_plane, x_hourglass - scale(height, unit_normal)) + scale(
            quarter_warping, mean_director
        )
        d_stabilising = scale(twist1, a1) + scale(twist2, a2)
        mean_conjugate = scale(q1, a1) + scale(q2, a2) + scale(quarter_warping, x_hourglass)

        area = elements.area[e]
        bp1 = area * elements.shape_gradient[GradientRow.p1, e]
        bp2 = area * elements.shape_gradient[GradientRow.p2, e]
        bq1 = area * elements.shape_gradient[GradientRow.q1, e]
        bq2 = area * elements.shape_gradient[GradientRow.q2, e]
        offset_p = elements.hourglass_offset[OffsetRow.p, e]
        offset_q = elements.hourglass_offset[OffsetRow.q, e]
        store_corners(
            corner_force, CornerRow.force, e,
            corner_difference(bp1, bp2, p1, p2), corner_difference(bq1, bq2, p1, p2),
            scale(area, x_stabilising), lanes3(), offset_p, offset_q,
        )  # fmt: skip
        store_corners(
            corner_force, CornerRow.couple, e,
            corner_difference(bp1, bp2, r1, r2), corner_difference(bq1, bq2, r1, r2),
            scale(area, d_stabilising), scale(real(0.25) * area, mean_conjugate), offset_p, offset_q,
        )  # fmt: skip

    return element_forces
