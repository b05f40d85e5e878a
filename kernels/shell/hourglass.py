"""Stabilisation of the one-point element against its hourglass modes (docs/theory.md, section 5)."""

from functools import cache
from typing import Any

import warp as wp

from ..lane_types import lane_types
from ..lanes import dot, fill, scale
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import HourglassRow


@wp.func
def hourglass_stiffnesses(laws: Any, shape: Any):
    """Coefficients per reference area: in-plane [N/m^3], warping [N/m^3], directors [N/m].

    Each is a share of the exact stiffness of the mode on a square; the sum of squared gradients gives the size.
    """
    bp1 = shape.bp1
    bp2 = shape.bp2
    bq1 = shape.bq1
    bq2 = shape.bq2
    squares = bp1.dtype(2.0) * (bp1 * bp1 + bp2 * bp2 + bq1 * bq1 + bq2 * bq2)
    return laws.hourglass_in_plane * squares, laws.hourglass_warping * squares, laws.hourglass_director * squares


@wp.func
def twist_weights(shape: Any):
    """Weights of k11, k12, k22 in the natural twist [(1 - c_p^2) k(p, p) - (1 - c_q^2) k(q, q)]/16, p, q the diagonals.

    On a parallelogram that is k(xi, eta); in general it is the effect of a constant curvature on x_h/4.
    """
    bp1 = shape.bp1
    bp2 = shape.bp2
    bq1 = shape.bq1
    bq2 = shape.bq2
    offset_p = shape.offset_p
    offset_q = shape.offset_q
    inverse = fill(bp1, 1.0) / (bp1 * bq2 - bp2 * bq1)
    square = bp1.dtype(0.0625) * inverse * inverse
    # (p q) is the inverse of the gradients: p = (b_q2, -b_q1)/det, q = (-b_p2, b_p1)/det
    weight_p = square - square * offset_p * offset_p
    weight_q = square - square * offset_q * offset_q
    return (
        weight_p * bq2 * bq2 - weight_q * bp2 * bp2,
        bp1.dtype(2.0) * (weight_q * bp1 * bp2 - weight_p * bq1 * bq2),
        weight_p * bq1 * bq1 - weight_q * bp1 * bp1,
    )


@cache
def hourglass_function(flat: bool):
    """Function for the hourglass strains; flat elements have no initial values."""

    @wp.func
    def hourglass_strains(elements: Any, block: int, shape: Any, x: Any, d: Any, b: Any):
        """Warping freed of twist [m], and the director hourglass along a1 and a2, minus their initial values.

        x_h/4 . d + k(xi, eta) is the part of the transverse shear that varies over the element; zero in pure twist.
        """
        weight11, weight12, weight22 = twist_weights(shape)
        warping = weight11.dtype(0.25) * dot(x.hourglass, d.mean)
        warping = warping + weight11 * b.k11 + weight12 * b.k12 + weight22 * b.k22
        director1 = dot(d.hourglass, x.by1)
        director2 = dot(d.hourglass, x.by2)
        if wp.static(not flat):
            warping = warping - elements.initial_hourglass[HourglassRow.warping, block]
            director1 = director1 - elements.initial_hourglass[HourglassRow.director1, block]
            director2 = director2 - elements.initial_hourglass[HourglassRow.director2, block]
        return warping, director1, director2

    return hourglass_strains


@cache
def stabilisation_struct(real: type, lane_count: int):
    """Forces against the hourglass modes of a block of elements, per reference area."""
    types = lane_types(real, lane_count)
    lanes = types.lanes

    @wp.struct
    class Stabilisation:
        unit_normal: types.lanes3
        height: lanes  # x_h.n [m]
        in_plane: lanes  # stiffness against the part of x_h within the plane [N/m^3]
        warping_force: lanes  # [N/m^2]
        director_force1: lanes  # against the director hourglass along a1 and a2 [N/m]
        director_force2: lanes
        normal1: lanes  # part of dpsi/da_alpha along the normal [N/m]
        normal2: lanes

    return Stabilisation


@cache
def stabilisation_function(real: type, lane_count: int, flat: bool):
    """Function for the ``Stabilisation`` of a block."""
    Stabilisation, hourglass_strains = stabilisation_struct(real, lane_count), hourglass_function(flat)

    @wp.func
    def stabilise(elements: Any, laws: Any, block: int, shape: Any, x: Any, d: Any, m: Any, b: Any):
        in_plane, warping_stiffness, director_stiffness = hourglass_stiffnesses(laws, shape)
        warping, director1, director2 = hourglass_strains(elements, block, shape, x, d, b)
        unit_normal = scale(m.inverse_ratio, m.normal)
        height = dot(x.hourglass, unit_normal)
        # the in-plane part |x_h|^2 - (x_h.n)^2 turns with the normal: height * (x_h . a^alpha) n
        height1 = dot(x.hourglass, x.by1)
        height2 = dot(x.hourglass, x.by2)
        tilt = in_plane * height * m.inverse_ratio * m.inverse_ratio
        return Stabilisation(
            unit_normal, height, in_plane, warping_stiffness * warping,
            director_stiffness * director1, director_stiffness * director2,
            tilt * (m.m22 * height1 - m.m12 * height2), tilt * (m.m11 * height2 - m.m12 * height1),
        )  # fmt: skip

    return stabilise


@wp.func
def warping_moments(shape: Any, warping_force: Any, r: Any):
    """Add the moments of the warping force to the ``Resultants`` r."""
    weight11, weight12, weight22 = twist_weights(shape)
    r.moment11 = r.moment11 + weight11 * warping_force
    r.moment12 = r.moment12 + weight11.dtype(0.5) * weight12 * warping_force
    r.moment22 = r.moment22 + weight22 * warping_force
    return r
