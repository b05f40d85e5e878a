"""Stabilisation of the one-point element against its hourglass modes (docs/theory.md, section 5)."""

from typing import Any

import warp as wp

from ..lanes import (  # noqa: F401 - operators of lanes
    div,
    dot,
    fill,
    mul,
)
from ..rows import GradientRow, HourglassRow, OffsetRow


@wp.func
def hourglass_stiffnesses(elements: Any, laws: Any, e: int):
    """Coefficients per reference area: in-plane [N/m^3], warping [N/m^3], directors [N/m^3 * m^2].

    Each is a share of the exact stiffness of the mode on a square; the sum of squared gradients carries the size.
    """
    bp1 = elements.shape_gradient[GradientRow.p1, e]
    bp2 = elements.shape_gradient[GradientRow.p2, e]
    bq1 = elements.shape_gradient[GradientRow.q1, e]
    bq2 = elements.shape_gradient[GradientRow.q2, e]
    squares = bp1.dtype(2.0) * (bp1 * bp1 + bp2 * bp2 + bq1 * bq1 + bq2 * bq2)
    return laws.hourglass_in_plane * squares, laws.hourglass_warping * squares, laws.hourglass_director * squares


@wp.func
def twist_weights(elements: Any, e: int):
    """Weights of k11, k12, k22 in the natural twist [(1 - c_p^2) k(p, p) - (1 - c_q^2) k(q, q)]/16, p, q the diagonals.

    On a parallelogram that is k(xi, eta); in general it is what a constant curvature takes out of x_h/4.
    """
    bp1 = elements.shape_gradient[GradientRow.p1, e]
    bp2 = elements.shape_gradient[GradientRow.p2, e]
    bq1 = elements.shape_gradient[GradientRow.q1, e]
    bq2 = elements.shape_gradient[GradientRow.q2, e]
    inverse = fill(bp1, 1.0) / (bp1 * bq2 - bp2 * bq1)
    square = bp1.dtype(0.0625) * inverse * inverse
    offset_p = elements.hourglass_offset[OffsetRow.p, e]
    offset_q = elements.hourglass_offset[OffsetRow.q, e]
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
        warping = warping - elements.initial_hourglass[HourglassRow.warping, e]
        along1 = along1 - elements.initial_hourglass[HourglassRow.director1, e]
        along2 = along2 - elements.initial_hourglass[HourglassRow.director2, e]
    return warping, along1, along2
