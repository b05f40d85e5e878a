"""The 4-node Mindlin shell with one quadrature point: kinematics, resultants, nodal forces (docs/theory.md, 1 and 5).

With the diagonals p = x_1 - x_3 and q = x_2 - x_4 every linear field of a quadrilateral has the gradient
N_,alpha = b_p,alpha p + b_q,alpha q, so four numbers per element are all of its shape functions. The hourglass vector
is gamma.x = (x_1 - x_2 + x_3 - x_4) - c_p p - c_q q. The same two formulas serve positions and directors.
"""

from functools import cache
from typing import Any

import warp as wp

from .cell import CellLaw
from .lanes import (
    angle_of,
    cross,
    div,
    dot,
    fill,
    gather,
    inverses,
    lane_maximum,
    lane_types,
    larger,
    mul,
    pick,
    scale,
    spread,
    square_root,
    where_positive,
)
from .sheet import (
    BENDING_LOSS_ROW,
    BENDING_SLIP_ROW,
    BENDING_SPRING_ROW,
    SHEAR_LOSS_ROW,
    SHEAR_SLIP_ROW,
    SHEAR_SPRING_ROW,
    SheetTraits,
    bending_friction,
    bending_moments,
    compressive_force,
    current_thickness,
    moment_resultants,
    shear_friction,
    shear_resultants,
    sheet_struct,
    transverse_shear_forces,
)

# Rows of the cell report: iterations of this step, energy lost in snaps so far [J/m^2], worst relative residual so far.
CELL_REPORT_ROWS = ("iterations", "snap_loss", "worst_residual")
ITERATIONS_ROW = wp.constant(0)
SNAP_LOSS_ROW = wp.constant(1)
WORST_RESIDUAL_ROW = wp.constant(2)
# Rows of the corner array, eight per corner: force; director gradient; shear angle; thickness if tools meet it.
CORNER_ROW_COUNT = 32
ROWS_PER_CORNER = wp.constant(8)
COUPLE_ROW = wp.constant(3)
ANGLE_ROW = wp.constant(6)
THICKNESS_ROW = wp.constant(7)
# Vectors of the motion array of the nodes, three rows each; the remainder is what rounding cut off the position. Then
# one row for the mean shear angle of the elements around the node [rad].
MOTION_ROWS = ("position", "velocity", "director", "spin", "remainder")
POSITION_ROW = wp.constant(0)
VELOCITY_ROW = wp.constant(3)
DIRECTOR_ROW = wp.constant(6)
SPIN_ROW = wp.constant(9)
REMAINDER_ROW = wp.constant(12)
MEAN_ANGLE_ROW = wp.constant(15)
MOTION_ROW_COUNT = 16
# Rows of the node report, of which a run has the first three, four with loads, all where tools meet the current
# thickness: work done against friction so far, lost or held in the friction springs [J]; energy lost in damping so far
# [J]; work of what holds the node, and of the loads on it, so far [J]; half the current thickness of the sheet and its
# last change [m]; work of its change on the tools so far [J].
NODE_REPORT_ROWS = (
    "friction_work",
    "damping_loss",
    "support_work",
    "load_work",
    "half_thickness",
    "half_thickness_growth",
    "thickness_work",
)
FRICTION_ROW = wp.constant(0)
DAMPING_ROW = wp.constant(1)
SUPPORT_ROW = wp.constant(2)
LOAD_ROW = wp.constant(3)
HALF_THICKNESS_ROW = wp.constant(4)
GROWTH_ROW = wp.constant(5)
THICKNESS_WORK_ROW = wp.constant(6)


@cache
def element_struct(real: type, lane_count: int):
    """Constant element data; arrays are [row, block of lanes]."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Elements:
        corner_node: wp.array2d(dtype=types.indices)  # 4 rows: first entry of the node in the flat motion array
        node_stride: wp.int32  # entries between two of its rows
        shape_gradient: wp.array2d(dtype=types.lanes)  # b_p1, b_p2, b_q1, b_q2 [1/m]
        hourglass_offset: wp.array2d(dtype=types.lanes)  # c_p, c_q
        area: wp.array(dtype=types.lanes)  # reference area [m^2]; 0 for padding
        initial_curvature: wp.array2d(dtype=types.lanes)  # k11, k12, k22 [1/m]; of a flat sheet none is read
        initial_transverse_shear: wp.array2d(dtype=types.lanes)  # g1, g2
        initial_hourglass: wp.array2d(dtype=types.lanes)  # warping [m], director along a1, a2

    return Elements


@wp.func
def corner_difference(gradient_p: Any, gradient_q: Any, p: Any, q: Any):
    """Derivative of a bilinear field along one yarn, from its two diagonals."""
    return scale(gradient_p, p) + scale(gradient_q, q)


@wp.func
def corner_vectors(elements: Any, e: int, v1: Any, v2: Any, v3: Any, v4: Any):
    """Derivatives along warp and weft, mean, and hourglass vector of a vector field given at the four corners."""
    p = v1 - v3
    q = v2 - v4
    along1 = corner_difference(elements.shape_gradient[0, e], elements.shape_gradient[2, e], p, q)
    along2 = corner_difference(elements.shape_gradient[1, e], elements.shape_gradient[3, e], p, q)
    odd = (v1 - v2) + (v3 - v4)
    hourglass = odd - corner_difference(elements.hourglass_offset[0, e], elements.hourglass_offset[1, e], p, q)
    return along1, along2, (v1 + v2 + v3 + v4) / v1.dtype(4.0), hourglass


@wp.func
def corner_vector(elements: Any, e: int, corner: int, motion: Any, row: int):
    """The vector in ``row`` of the motion array at one corner."""
    return gather(motion, elements.corner_node[corner, e], row * elements.node_stride, elements.node_stride)


@wp.func
def element_vectors(elements: Any, e: int, motion: Any, row: int):
    """``corner_vectors`` of the vectors in ``row`` of the motion array."""
    return corner_vectors(
        elements,
        e,
        corner_vector(elements, e, 0, motion, row),
        corner_vector(elements, e, 1, motion, row),
        corner_vector(elements, e, 2, motion, row),
        corner_vector(elements, e, 3, motion, row),
    )


@wp.func
def element_positions(elements: Any, e: int, motion: Any):
    """``corner_vectors`` of the positions relative to the first corner, with the part that rounding cut off.

    In single precision a position 0.2 m from the origin is rounded to 15 nm, a strain of several 1e-6 across an element
    of 5 mm: the remainder that the time integration keeps makes differences exact to their own rounding.
    """
    x1 = corner_vector(elements, e, 0, motion, POSITION_ROW)
    r1 = corner_vector(elements, e, 0, motion, REMAINDER_ROW)
    v2 = (corner_vector(elements, e, 1, motion, POSITION_ROW) - x1) + (
        corner_vector(elements, e, 1, motion, REMAINDER_ROW) - r1
    )
    v3 = (corner_vector(elements, e, 2, motion, POSITION_ROW) - x1) + (
        corner_vector(elements, e, 2, motion, REMAINDER_ROW) - r1
    )
    v4 = (corner_vector(elements, e, 3, motion, POSITION_ROW) - x1) + (
        corner_vector(elements, e, 3, motion, REMAINDER_ROW) - r1
    )
    return corner_vectors(elements, e, type(x1)(), v2, v3, v4)


@wp.func
def surface_metric(a1: Any, a2: Any):
    """Metric m11, m12, m22 of the yarn vectors, their cross product, and its length J, the area ratio."""
    normal = cross(a1, a2)
    return dot(a1, a1), dot(a1, a2), dot(a2, a2), normal, square_root(dot(normal, normal))


@wp.func
def skew_weights(elements: Any, e: int):
    """Weights of k11, k12, k22 in the corrections of g1 and of g2, six in all [m].

    1/4 [b_p (c_p k(p, p) + c_q k(p, q)) - b_q (c_p k(p, q) + c_q k(q, q))], p, q the flat diagonals. A constant
    curvature with its own normals would have just minus this a.d in the middle of a quadrilateral that is no
    parallelogram: both are means over the corners, but not at the same place.
    """
    bp1 = elements.shape_gradient[0, e]
    bp2 = elements.shape_gradient[1, e]
    bq1 = elements.shape_gradient[2, e]
    bq2 = elements.shape_gradient[3, e]
    offset_p = elements.hourglass_offset[0, e]
    offset_q = elements.hourglass_offset[1, e]
    inverse = fill(bp1, 1.0) / (bp1 * bq2 - bp2 * bq1)
    p1 = bq2 * inverse
    p2 = -(bq1 * inverse)
    q1 = -(bp2 * inverse)
    q2 = bp1 * inverse
    quarter = bp1.dtype(0.25)
    # k(p, o) and k(q, o) with the offset o = c_p p + c_q q
    along1 = quarter * (offset_p * p1 + offset_q * q1)
    along2 = quarter * (offset_p * p2 + offset_q * q2)
    po11 = p1 * along1
    po12 = p1 * along2 + p2 * along1
    po22 = p2 * along2
    qo11 = q1 * along1
    qo12 = q1 * along2 + q2 * along1
    qo22 = q2 * along2
    return (
        bp1 * po11 - bq1 * qo11,
        bp1 * po12 - bq1 * qo12,
        bp1 * po22 - bq1 * qo22,
        bp2 * po11 - bq2 * qo11,
        bp2 * po12 - bq2 * qo12,
        bp2 * po22 - bq2 * qo22,
    )


@wp.func
def element_strains(
    elements: Any, e: int, flat: bool, skewed: bool, a1: Any, a2: Any, d1: Any, d2: Any, mean_director: Any
):
    """Curvatures k11, k12, k22 and transverse shears g1, g2, minus their initial values."""
    k11 = dot(a1, d1)
    k22 = dot(a2, d2)
    k12 = k11.dtype(0.5) * (dot(a1, d2) + dot(a2, d1))
    g1 = dot(a1, mean_director)
    g2 = dot(a2, mean_director)
    if not flat:
        k11 = k11 - elements.initial_curvature[0, e]
        k12 = k12 - elements.initial_curvature[1, e]
        k22 = k22 - elements.initial_curvature[2, e]
        g1 = g1 - elements.initial_transverse_shear[0, e]
        g2 = g2 - elements.initial_transverse_shear[1, e]
    if skewed:
        skew11, skew12, skew13, skew21, skew22, skew23 = skew_weights(elements, e)
        g1 = g1 + skew11 * k11 + skew12 * k12 + skew13 * k22
        g2 = g2 + skew21 * k11 + skew22 * k12 + skew23 * k22
    return k11, k12, k22, g1, g2


@wp.func
def corner_angles(elements: Any, e: int, motion: Any, angle: Any):
    """Sum over the corners of angle - mean and of its square, where mean is that of the elements around the corner."""
    difference = type(angle)()
    square = type(angle)()
    for corner in range(4):
        mean = pick(motion, elements.corner_node[corner, e], MEAN_ANGLE_ROW * elements.node_stride)
        difference = difference + (angle - mean)
        square = square + (angle - mean) * (angle - mean)
    return difference, square


@wp.func
def hourglass_stiffnesses(elements: Any, laws: Any, e: int):
    """Coefficients per reference area: in-plane [N/m^3], warping [N/m^3], directors [N/m^3 * m^2].

    Each is a share of the exact stiffness of the mode on a square; the sum of squared gradients carries the size.
    """
    bp1 = elements.shape_gradient[0, e]
    bp2 = elements.shape_gradient[1, e]
    bq1 = elements.shape_gradient[2, e]
    bq2 = elements.shape_gradient[3, e]
    squares = bp1.dtype(2.0) * (bp1 * bp1 + bp2 * bp2 + bq1 * bq1 + bq2 * bq2)
    return laws.hourglass_in_plane * squares, laws.hourglass_warping * squares, laws.hourglass_director * squares


@wp.func
def twist_weights(elements: Any, e: int):
    """Weights of k11, k12, k22 in the natural twist [(1 - c_p^2) k(p, p) - (1 - c_q^2) k(q, q)]/16, p, q the diagonals.

    On a parallelogram that is k(xi, eta); in general it is what a constant curvature takes out of x_h/4.
    """
    bp1 = elements.shape_gradient[0, e]
    bp2 = elements.shape_gradient[1, e]
    bq1 = elements.shape_gradient[2, e]
    bq2 = elements.shape_gradient[3, e]
    inverse = fill(bp1, 1.0) / (bp1 * bq2 - bp2 * bq1)
    square = bp1.dtype(0.0625) * inverse * inverse
    offset_p = elements.hourglass_offset[0, e]
    offset_q = elements.hourglass_offset[1, e]
    # (p q) is the inverse of the gradients: p = (b_q2, -b_q1)/det, q = (-b_p2, b_p1)/det
    weight_p = square - square * offset_p * offset_p
    weight_q = square - square * offset_q * offset_q
    return (
        weight_p * bq2 * bq2 - weight_q * bp2 * bp2,
        bp1.dtype(2.0) * (weight_q * bp1 * bp2 - weight_p * bq1 * bq2),
        weight_p * bq1 * bq1 - weight_q * bp1 * bp1,
    )


@wp.func
def hourglass_strains(
    elements: Any,
    e: int,
    flat: bool,
    a1: Any,
    a2: Any,
    mean_director: Any,
    x_hourglass: Any,
    d_hourglass: Any,
    k11: Any,
    k12: Any,
    k22: Any,
):
    """Warping freed of twist [m], and the director hourglass along a1 and a2, minus their initial values.

    x_h/4 . d + k(xi, eta) is the part of the transverse shear that varies over the element: zero in a pure twist.
    """
    weight11, weight12, weight22 = twist_weights(elements, e)
    warping = k11.dtype(0.25) * dot(x_hourglass, mean_director) + weight11 * k11 + weight12 * k12 + weight22 * k22
    along1 = dot(d_hourglass, a1)
    along2 = dot(d_hourglass, a2)
    if not flat:
        warping = warping - elements.initial_hourglass[0, e]
        along1 = along1 - elements.initial_hourglass[1, e]
        along2 = along2 - elements.initial_hourglass[2, e]
    return warping, along1, along2


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


@wp.func
def yarn_strains(m11: Any, m22: Any):
    """lambda_k - 1 of both yarns, without cancellation, and the stretches lambda_k."""
    one = fill(m11, 1.0)
    stretch1 = square_root(m11)
    stretch2 = square_root(m22)
    inverse1, inverse2 = inverses(stretch1 + one, stretch2 + one)
    return (m11 - one) * inverse1, (m22 - one) * inverse2, stretch1, stretch2


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
        cell_report: wp.array2d(dtype=lanes),  # rows: see CELL_REPORT_ROWS
        slip: wp.array2d(dtype=lanes),  # rows: see SLIP_ROWS; not touched without friction inside the sheet
        corner_force: wp.array2d(dtype=lanes),
    ):
        e = first_block + wp.tid()
        a1, a2, mean_offset, x_hourglass = element_positions(elements, e, motion)
        d1, d2, mean_director, d_hourglass = element_vectors(elements, e, motion, DIRECTOR_ROW)

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
        cell_report[ITERATIONS_ROW, e] = iterations
        cell_report[WORST_RESIDUAL_ROW, e] = larger(cell_report[WORST_RESIDUAL_ROW, e], residual)
        if wp.static(unknown_count > 0):
            freed = snap_loss(cell, strain1, strain2, angle, start, unknowns)
            if lane_maximum(freed) > real(0.0):
                cell_report[SNAP_LOSS_ROW, e] = cell_report[SNAP_LOSS_ROW, e] + freed
        inverse1, inverse2 = inverses(stretch1, stretch2)
        inverse_ratio = lanes(real(1.0)) / area_ratio
        t11 = (warp_force + compressive_force(laws, stretch1)) * inverse1
        t22 = (weft_force + compressive_force(laws, stretch2)) * inverse2

        # in-plane shear, and the in-plane bending of the yarns, which resists a shear angle that varies
        # (b_p x b_q) is 1/(2 area); the area itself is zero in padding elements
        inverse_area = real(2.0) * (
            elements.shape_gradient[0, e] * elements.shape_gradient[3, e]
            - elements.shape_gradient[1, e] * elements.shape_gradient[2, e]
        )
        moment, linear12 = shear_resultants(laws, curved_shear, m12, angle)
        if wp.static(cell_shears):
            moment = moment + cell_moment
        difference, square = corner_angles(elements, e, motion, angle)
        moment = moment + (laws.in_plane_bending_stiffness * inverse_area) * difference
        if wp.static(shear_slides):
            turned, spring, lost = shear_friction(
                laws, angle, slip[SHEAR_SLIP_ROW, e], slip[SHEAR_SPRING_ROW, e], pressure
            )
            slip[SHEAR_SLIP_ROW, e] = turned
            slip[SHEAR_SPRING_ROW, e] = spring
            slip[SHEAR_LOSS_ROW, e] = slip[SHEAR_LOSS_ROW, e] + lost
            moment = moment + laws.shear.friction_stiffness * spring
        shear11, shear12, shear22 = moment_resultants(moment, m12, inverse1, inverse2, inverse_ratio)
        shear12 = shear12 + linear12
        for corner in range(4):
            corner_force[ANGLE_ROW + ROWS_PER_CORNER * corner, e] = angle
        if wp.static(follows_thickness):
            # nodes with fewer neighbours read a padding element, which must add nothing
            thickness = where_positive(elements.area[e], current_thickness(laws, area_ratio, pressure), lanes())
            for corner in range(4):
                corner_force[THICKNESS_ROW + ROWS_PER_CORNER * corner, e] = thickness

        # bending and transverse shear
        k11, k12, k22, g1, g2 = element_strains(elements, e, flat, skewed, a1, a2, d1, d2, mean_director)
        moment11, moment12, moment22, bend11, bend12, bend22 = bending_moments(
            laws, bending_kind, m11, m12, m22, inverse_ratio, k11, k12, k22
        )
        if wp.static(bending_slides):
            warp_slip, warp_spring, warp_loss = bending_friction(
                laws, 0, k11 / m11, slip[BENDING_SLIP_ROW, e], slip[BENDING_SPRING_ROW, e]
            )
            weft_slip, weft_spring, weft_loss = bending_friction(
                laws, 1, k22 / m22, slip[BENDING_SLIP_ROW + 1, e], slip[BENDING_SPRING_ROW + 1, e]
            )
            slip[BENDING_SLIP_ROW, e] = warp_slip
            slip[BENDING_SLIP_ROW + 1, e] = weft_slip
            slip[BENDING_SPRING_ROW, e] = warp_spring
            slip[BENDING_SPRING_ROW + 1, e] = weft_spring
            warp_moment = laws.bending.friction_stiffness[0] * warp_spring
            weft_moment = laws.bending.friction_stiffness[1] * weft_spring
            slip[BENDING_LOSS_ROW, e] = slip[BENDING_LOSS_ROW, e] + warp_loss + weft_loss
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
        bp1 = area * elements.shape_gradient[0, e]
        bp2 = area * elements.shape_gradient[1, e]
        bq1 = area * elements.shape_gradient[2, e]
        bq2 = area * elements.shape_gradient[3, e]
        offset_p = elements.hourglass_offset[0, e]
        offset_q = elements.hourglass_offset[1, e]
        store_corners(
            corner_force, 0, e,
            corner_difference(bp1, bp2, p1, p2), corner_difference(bq1, bq2, p1, p2),
            scale(area, x_stabilising), lanes3(), offset_p, offset_q,
        )  # fmt: skip
        store_corners(
            corner_force, COUPLE_ROW, e,
            corner_difference(bp1, bp2, r1, r2), corner_difference(bq1, bq2, r1, r2),
            scale(area, d_stabilising), scale(real(0.25) * area, mean_conjugate), offset_p, offset_q,
        )  # fmt: skip

    return element_forces
