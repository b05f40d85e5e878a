"""The 4-node Mindlin shell with one quadrature point: its kinematics (docs/theory.md, 1 and 5).

With the diagonals p = x_1 - x_3 and q = x_2 - x_4 every linear field of a quadrilateral has the gradient
N_,alpha = b_p,alpha p + b_q,alpha q, so four numbers per element define its shape functions. The hourglass vector is
gamma.x = (x_1 - x_2 + x_3 - x_4) - c_p p - c_q q. The same two formulas apply to positions and directors.

Common data of a block of elements are in structs of lanes: ``Shape``, its shape functions; ``Vectors`` x of the
positions and d of the directors; ``Membrane`` m; ``Bend`` b, its curvatures and transverse shears.
"""

from functools import cache
from typing import Any

import warp as wp

from ..angles import angle_of
from ..lane_types import lane_types
from ..lanes import cross, dot, fill, from_rows, inverses, pick, scale, square_root
from ..operators import add, div, mul, sub  # noqa: F401
from ..records import SCALAR, gather4, vector_of
from ..rows import CurvatureRow, GradientRow, MotionRow, OffsetRow, TransverseShearRow


@cache
def element_struct(real: type, lane_count: int):
    """Constant element data; arrays are [row, block of lanes]."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Elements:
        corner_node: wp.array2d(dtype=types.indices)  # 4 rows: first entry of the node in the flat motion array
        node_stride: wp.int32  # entries between two of its rows
        looks_ahead: wp.int32  # 1: the rows of the next block are fetched while one is computed
        shape_gradient: wp.array2d(dtype=types.lanes)  # rows: see GradientRow
        hourglass_offset: wp.array2d(dtype=types.lanes)  # rows: see OffsetRow
        area: wp.array(dtype=types.lanes)  # reference area [m^2]; 0 for padding
        yarn_inertia: wp.array(dtype=types.lanes)  # areal density over 4 max B, of motions that stretch yarns [kg]
        initial_curvature: wp.array2d(dtype=types.lanes)  # rows: see CurvatureRow; not read for a flat sheet
        initial_transverse_shear: wp.array2d(dtype=types.lanes)  # rows: see TransverseShearRow
        initial_hourglass: wp.array2d(dtype=types.lanes)  # rows: see HourglassRow

    return Elements


@cache
def shape_struct(real: type, lane_count: int):
    """Shape functions of a block of elements."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class Shape:
        bp1: lanes  # gradient of p and q along warp and weft [1/m]
        bp2: lanes
        bq1: lanes
        bq2: lanes
        offset_p: lanes  # c_p, c_q
        offset_q: lanes

    return Shape


@cache
def vectors_struct(real: type, lane_count: int):
    """A vector field on a block of elements, given at their corners: positions, directors or velocities."""
    lanes3 = lane_types(real, lane_count).lanes3

    @wp.struct
    class Vectors:
        by1: lanes3  # derivative along the warp: a_1 of the positions
        by2: lanes3  # along the weft
        mean: lanes3
        hourglass: lanes3  # hourglass vector

    return Vectors


@cache
def membrane_struct(real: type, lane_count: int):
    """Metric and membrane strains of a block of elements."""
    types = lane_types(real, lane_count)
    lanes = types.lanes

    @wp.struct
    class Membrane:
        normal: types.lanes3  # a1 x a2
        m11: lanes  # metric of a1 and a2
        m12: lanes
        m22: lanes
        area_ratio: lanes  # J = |a1 x a2|
        inverse_ratio: lanes  # 1/J
        strain1: lanes  # stretches - 1
        strain2: lanes
        stretch1: lanes
        stretch2: lanes
        angle: lanes  # shear angle [rad]

    return Membrane


@cache
def bend_struct(real: type, lane_count: int):
    """Curvatures and transverse shears of a block of elements, minus their initial values."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class Bend:
        k11: lanes  # [1/m]
        k12: lanes
        k22: lanes
        g1: lanes
        g2: lanes

    return Bend


@wp.func
def shape_functions(elements: Any, block: int, shape: Any):
    """``Shape`` of a block, into an empty one."""
    shape.bp1 = elements.shape_gradient[GradientRow.bp1, block]
    shape.bp2 = elements.shape_gradient[GradientRow.bp2, block]
    shape.bq1 = elements.shape_gradient[GradientRow.bq1, block]
    shape.bq2 = elements.shape_gradient[GradientRow.bq2, block]
    shape.offset_p = elements.hourglass_offset[OffsetRow.p, block]
    shape.offset_q = elements.hourglass_offset[OffsetRow.q, block]
    return shape


@wp.func
def corner_difference(gradient_p: Any, gradient_q: Any, p: Any, q: Any):
    """Derivative of a bilinear field along one yarn, from its two diagonals."""
    return scale(gradient_p, p) + scale(gradient_q, q)


@wp.func
def corner_piece(elements: Any, block: int, corner: int, motion: Any, row: int):
    """The vector in ``row`` of the motion array at one corner, and the scalar behind it."""
    return gather4(motion, elements.corner_node[corner, block], row * elements.node_stride, elements.node_stride)


@wp.func
def corner_vector(elements: Any, block: int, corner: int, motion: Any, row: int):
    """The vector in ``row`` of the motion array at one corner."""
    return vector_of(corner_piece(elements, block, corner, motion, row))


@wp.func
def corner_vectors(shape: Any, v1: Any, v2: Any, v3: Any, v4: Any):
    """Derivatives along warp and weft, mean, and hourglass vector of a vector field given at the four corners."""
    p = v1 - v3
    q = v2 - v4
    by1 = corner_difference(shape.bp1, shape.bq1, p, q)
    by2 = corner_difference(shape.bp2, shape.bq2, p, q)
    odd = (v1 - v2) + (v3 - v4)
    hourglass = odd - corner_difference(shape.offset_p, shape.offset_q, p, q)
    return by1, by2, (v1 + v2 + v3 + v4) / v1.dtype(4.0), hourglass


@wp.func
def element_vectors(elements: Any, block: int, shape: Any, motion: Any, row: int):
    """``corner_vectors`` of the vectors in ``row`` of the motion array."""
    return corner_vectors(
        shape,
        corner_vector(elements, block, 0, motion, row),
        corner_vector(elements, block, 1, motion, row),
        corner_vector(elements, block, 2, motion, row),
        corner_vector(elements, block, 3, motion, row),
    )


@wp.func
def element_positions(elements: Any, block: int, shape: Any, motion: Any):
    """``corner_vectors`` of the positions relative to the first corner, including their rounding errors; mean angles.

    In single precision a position 0.2 m from the origin is rounded to 15 nm, a strain of several 1e-6 across an element
    of 5 mm: with the remainder from the time integration, differences are exact to their own rounding.

    Written out: with a function per corner the compiler generates slower gathers. The mean shear angles at the corners
    lie behind the positions, so that lanes have them for nothing.
    """
    p1 = corner_piece(elements, block, 0, motion, MotionRow.position)
    p2 = corner_piece(elements, block, 1, motion, MotionRow.position)
    p3 = corner_piece(elements, block, 2, motion, MotionRow.position)
    p4 = corner_piece(elements, block, 3, motion, MotionRow.position)
    x1 = vector_of(p1)
    r1 = corner_vector(elements, block, 0, motion, MotionRow.remainder)
    v2 = (vector_of(p2) - x1) + (corner_vector(elements, block, 1, motion, MotionRow.remainder) - r1)
    v3 = (vector_of(p3) - x1) + (corner_vector(elements, block, 2, motion, MotionRow.remainder) - r1)
    v4 = (vector_of(p4) - x1) + (corner_vector(elements, block, 3, motion, MotionRow.remainder) - r1)
    by1, by2, mean, hourglass = corner_vectors(shape, type(x1)(), v2, v3, v4)
    return by1, by2, mean, hourglass, from_rows(p1[SCALAR], p2[SCALAR], p3[SCALAR], p4[SCALAR])


@cache
def vectors_functions(real: type, lane_count: int):
    """Functions for the ``Vectors`` of the positions, with ``mean_angles``, and for those of any row of the motion."""
    Vectors = vectors_struct(real, lane_count)

    @wp.func
    def vectors(elements: Any, block: int, shape: Any, motion: Any, row: int):
        by1, by2, mean, hourglass = element_vectors(elements, block, shape, motion, row)
        return Vectors(by1, by2, mean, hourglass)

    @wp.func
    def positions(elements: Any, block: int, shape: Any, motion: Any):
        by1, by2, mean, hourglass, angles = element_positions(elements, block, shape, motion)
        return Vectors(by1, by2, mean, hourglass), angles

    return positions, vectors


@wp.func
def yarn_strains(m11: Any, m22: Any):
    """lambda_k - 1 of both yarns, without cancellation, and the stretches lambda_k."""
    one = fill(m11, 1.0)
    stretch1 = square_root(m11)
    stretch2 = square_root(m22)
    inverse1, inverse2 = inverses(stretch1 + one, stretch2 + one)
    return (m11 - one) * inverse1, (m22 - one) * inverse2, stretch1, stretch2


@cache
def membrane_function(real: type, lane_count: int):
    """Function for the ``Membrane`` of a block, from the convected yarn vectors."""
    Membrane = membrane_struct(real, lane_count)

    @wp.func
    def stretch_membrane(a1: Any, a2: Any):
        normal = cross(a1, a2)
        m11 = dot(a1, a1)
        m12 = dot(a1, a2)
        m22 = dot(a2, a2)
        area_ratio = square_root(dot(normal, normal))
        strain1, strain2, stretch1, stretch2 = yarn_strains(m11, m22)
        return Membrane(
            normal, m11, m12, m22, area_ratio, fill(area_ratio, 1.0) / area_ratio,
            strain1, strain2, stretch1, stretch2, angle_of(m12, area_ratio, stretch1 * stretch2),
        )  # fmt: skip

    return stretch_membrane


@wp.func
def skew_weights(shape: Any):
    """Weights of k11, k12, k22 in the corrections of g1 and of g2, six in all [m].

    1/4 [b_p (c_p k(p, p) + c_q k(p, q)) - b_q (c_p k(p, q) + c_q k(q, q))], p, q the flat diagonals. A surface of
    constant curvature with its own normals would have minus this a.d at the centre of a quadrilateral that is not a
    parallelogram: both are means over the corners, but at different points.
    """
    bp1 = shape.bp1
    bp2 = shape.bp2
    bq1 = shape.bq1
    bq2 = shape.bq2
    inverse = fill(bp1, 1.0) / (bp1 * bq2 - bp2 * bq1)
    p1 = bq2 * inverse
    p2 = -(bq1 * inverse)
    q1 = -(bp2 * inverse)
    q2 = bp1 * inverse
    quarter = bp1.dtype(0.25)
    # k(p, o) and k(q, o) with the offset o = c_p p + c_q q
    along1 = quarter * (shape.offset_p * p1 + shape.offset_q * q1)
    along2 = quarter * (shape.offset_p * p2 + shape.offset_q * q2)
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


@cache
def bend_function(real: type, lane_count: int, flat: bool, skewed: bool):
    """Function for the ``Bend``; flat elements have no initial values, skewed ones a correction of the shears."""
    Bend = bend_struct(real, lane_count)

    @wp.func
    def bend(elements: Any, block: int, shape: Any, x: Any, d: Any):
        k11 = dot(x.by1, d.by1)
        k22 = dot(x.by2, d.by2)
        k12 = k11.dtype(0.5) * (dot(x.by1, d.by2) + dot(x.by2, d.by1))
        g1 = dot(x.by1, d.mean)
        g2 = dot(x.by2, d.mean)
        if wp.static(not flat):
            k11 = k11 - elements.initial_curvature[CurvatureRow.k11, block]
            k12 = k12 - elements.initial_curvature[CurvatureRow.k12, block]
            k22 = k22 - elements.initial_curvature[CurvatureRow.k22, block]
            g1 = g1 - elements.initial_transverse_shear[TransverseShearRow.g1, block]
            g2 = g2 - elements.initial_transverse_shear[TransverseShearRow.g2, block]
        if wp.static(skewed):
            skew11, skew12, skew13, skew21, skew22, skew23 = skew_weights(shape)
            g1 = g1 + skew11 * k11 + skew12 * k12 + skew13 * k22
            g2 = g2 + skew21 * k11 + skew22 * k12 + skew23 * k22
        return Bend(k11, k12, k22, g1, g2)

    return bend


@wp.func
def mean_angle(elements: Any, block: int, corner: int, motion: Any):
    """Mean shear angle at one corner."""
    return pick(motion, elements.corner_node[corner, block], MotionRow.mean_angle * elements.node_stride)


@wp.func
def mean_angles(elements: Any, block: int, motion: Any):
    """Mean shear angles at the corners, a row for each, as ``positions`` returns them too."""
    return from_rows(
        mean_angle(elements, block, 0, motion),
        mean_angle(elements, block, 1, motion),
        mean_angle(elements, block, 2, motion),
        mean_angle(elements, block, 3, motion),
    )


@wp.func
def corner_angles(means: Any, angle: Any):
    """Sum over the corners of angle - mean and of its square, where mean is that of the elements around the corner."""
    difference = fill(angle, 0.0)
    square = fill(angle, 0.0)
    for corner in range(4):
        difference = difference + (angle - means[corner])
        square = square + (angle - means[corner]) * (angle - means[corner])
    return difference, square
