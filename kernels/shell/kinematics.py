"""The 4-node Mindlin shell with one quadrature point: kinematics, resultants, nodal forces (docs/theory.md, 1 and 5).

With the diagonals p = x_1 - x_3 and q = x_2 - x_4 every linear field of a quadrilateral has the gradient
N_,alpha = b_p,alpha p + b_q,alpha q, so four numbers per element are all of its shape functions. The hourglass vector
is gamma.x = (x_1 - x_2 + x_3 - x_4) - c_p p - c_q q. The same two formulas serve positions and directors.
"""

from functools import cache
from typing import Any

import warp as wp

from ..lanes import (  # noqa: F401 - operators of lanes
    cross,
    div,
    dot,
    fill,
    gather,
    inverses,
    lane_types,
    mul,
    pick,
    scale,
    square_root,
)
from ..rows import CurvatureRow, GradientRow, MotionRow, OffsetRow, TransverseShearRow


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
    along1 = corner_difference(
        elements.shape_gradient[GradientRow.p1, e], elements.shape_gradient[GradientRow.q1, e], p, q
    )
    along2 = corner_difference(
        elements.shape_gradient[GradientRow.p2, e], elements.shape_gradient[GradientRow.q2, e], p, q
    )
    odd = (v1 - v2) + (v3 - v4)
    hourglass = odd - corner_difference(
        elements.hourglass_offset[OffsetRow.p, e], elements.hourglass_offset[OffsetRow.q, e], p, q
    )
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
    x1 = corner_vector(elements, e, 0, motion, MotionRow.position)
    r1 = corner_vector(elements, e, 0, motion, MotionRow.remainder)
    v2 = (corner_vector(elements, e, 1, motion, MotionRow.position) - x1) + (
        corner_vector(elements, e, 1, motion, MotionRow.remainder) - r1
    )
    v3 = (corner_vector(elements, e, 2, motion, MotionRow.position) - x1) + (
        corner_vector(elements, e, 2, motion, MotionRow.remainder) - r1
    )
    v4 = (corner_vector(elements, e, 3, motion, MotionRow.position) - x1) + (
        corner_vector(elements, e, 3, motion, MotionRow.remainder) - r1
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
    bp1 = elements.shape_gradient[GradientRow.p1, e]
    bp2 = elements.shape_gradient[GradientRow.p2, e]
    bq1 = elements.shape_gradient[GradientRow.q1, e]
    bq2 = elements.shape_gradient[GradientRow.q2, e]
    offset_p = elements.hourglass_offset[OffsetRow.p, e]
    offset_q = elements.hourglass_offset[OffsetRow.q, e]
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
        k11 = k11 - elements.initial_curvature[CurvatureRow.k11, e]
        k12 = k12 - elements.initial_curvature[CurvatureRow.k12, e]
        k22 = k22 - elements.initial_curvature[CurvatureRow.k22, e]
        g1 = g1 - elements.initial_transverse_shear[TransverseShearRow.g1, e]
        g2 = g2 - elements.initial_transverse_shear[TransverseShearRow.g2, e]
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
        mean = pick(motion, elements.corner_node[corner, e], MotionRow.mean_angle * elements.node_stride)
        difference = difference + (angle - mean)
        square = square + (angle - mean) * (angle - mean)
    return difference, square


@wp.func
def yarn_strains(m11: Any, m22: Any):
    """lambda_k - 1 of both yarns, without cancellation, and the stretches lambda_k."""
    one = fill(m11, 1.0)
    stretch1 = square_root(m11)
    stretch2 = square_root(m22)
    inverse1, inverse2 = inverses(stretch1 + one, stretch2 + one)
    return (m11 - one) * inverse1, (m22 - one) * inverse2, stretch1, stretch2
