"""Bounds of the largest eigenvalue of small symmetric matrices, in lanes."""

from functools import cache
from typing import Any

import warp as wp

from ..lane_types import lane_types
from ..lanes import fill, larger, square_root, where_positive
from ..operators import add, div, mul, sub  # noqa: F401

# A norm of H^16 bounds the eigenvalues of H.
SQUARING_COUNT = 4


@cache
def symmetric2_struct(real: type, lane_count: int):
    """Symmetric 2 x 2 matrices, one per lane."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class Symmetric2:
        a11: lanes
        a12: lanes
        a22: lanes

    return Symmetric2


@cache
def symmetric4_struct(real: type, lane_count: int):
    """Symmetric 4 x 4 matrices, one per lane; rows and columns 0 and 1 belong to da_1, 2 and 3 to da_2."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class Symmetric4:
        a00: lanes
        a01: lanes
        a02: lanes
        a03: lanes
        a11: lanes
        a12: lanes
        a13: lanes
        a22: lanes
        a23: lanes
        a33: lanes

    return Symmetric4


@wp.func
def largest_of_pencil(h: Any, b: Any):
    """Largest eigenvalue of H B, both 2 x 2 and symmetric, B positive definite."""
    two = h.a11.dtype(2.0)
    half_trace = h.a11.dtype(0.5) * (h.a11 * b.a11 + two * (h.a12 * b.a12) + h.a22 * b.a22)
    determinant = (h.a11 * h.a22 - h.a12 * h.a12) * (b.a11 * b.a22 - b.a12 * b.a12)
    return half_trace + square_root(larger(half_trace * half_trace - determinant, fill(half_trace, 0.0)))


@wp.func
def norm_squared(a: Any):
    """Sum of the squared entries of a symmetric 4 x 4 matrix."""
    diagonal = a.a00 * a.a00 + a.a11 * a.a11 + a.a22 * a.a22 + a.a33 * a.a33
    rest = a.a01 * a.a01 + a.a02 * a.a02 + a.a03 * a.a03 + a.a12 * a.a12 + a.a13 * a.a13 + a.a23 * a.a23
    return diagonal + diagonal.dtype(2.0) * rest


@wp.func
def scaled(a: Any, scaling: Any):
    """Every entry times ``scaling``."""
    a.a00 = a.a00 * scaling
    a.a01 = a.a01 * scaling
    a.a02 = a.a02 * scaling
    a.a03 = a.a03 * scaling
    a.a11 = a.a11 * scaling
    a.a12 = a.a12 * scaling
    a.a13 = a.a13 * scaling
    a.a22 = a.a22 * scaling
    a.a23 = a.a23 * scaling
    a.a33 = a.a33 * scaling
    return a


@wp.func
def squared(a: Any):
    """The matrix times itself."""
    p = type(a)()
    p.a00 = a.a00 * a.a00 + a.a01 * a.a01 + a.a02 * a.a02 + a.a03 * a.a03
    p.a01 = a.a00 * a.a01 + a.a01 * a.a11 + a.a02 * a.a12 + a.a03 * a.a13
    p.a02 = a.a00 * a.a02 + a.a01 * a.a12 + a.a02 * a.a22 + a.a03 * a.a23
    p.a03 = a.a00 * a.a03 + a.a01 * a.a13 + a.a02 * a.a23 + a.a03 * a.a33
    p.a11 = a.a01 * a.a01 + a.a11 * a.a11 + a.a12 * a.a12 + a.a13 * a.a13
    p.a12 = a.a01 * a.a02 + a.a11 * a.a12 + a.a12 * a.a22 + a.a13 * a.a23
    p.a13 = a.a01 * a.a03 + a.a11 * a.a13 + a.a12 * a.a23 + a.a13 * a.a33
    p.a22 = a.a02 * a.a02 + a.a12 * a.a12 + a.a22 * a.a22 + a.a23 * a.a23
    p.a23 = a.a02 * a.a03 + a.a12 * a.a13 + a.a22 * a.a23 + a.a23 * a.a33
    p.a33 = a.a03 * a.a03 + a.a13 * a.a13 + a.a23 * a.a23 + a.a33 * a.a33
    return p


@wp.func
def in_tangent_plane(t: Any, m: Any, sine: Any, cosine: Any, h: Any):
    """Second derivative h with respect to (da_1, da_2) in the tangent plane, frame (e_1, across e_1), of ``Tangent`` t.

    C acts on the strains, the forces n_1, n_2 and the moment m on their second derivatives; e_2 = (sin, cos), and the
    angle decreases along (-cos, sin).
    """
    one = fill(sine, 1.0)
    two = sine.dtype(2.0)
    inverse1 = one / m.stretch1
    inverse2 = one / m.stretch2
    along = t.c22
    mixed = inverse2 * (t.c23 - t.moment * inverse2)
    across = inverse2 * (t.n2 + t.c33 * inverse2)
    square_sine = sine * sine
    product = sine * cosine
    square_cosine = cosine * cosine
    angle2 = t.c33 * (inverse1 * inverse2)
    h.a00 = t.c11
    h.a01 = inverse1 * (t.c13 - t.moment * inverse1)
    h.a11 = inverse1 * (t.n1 + t.c33 * inverse1)
    h.a22 = along * square_sine + two * (mixed * product) + across * square_cosine
    h.a23 = (along - across) * product + mixed * (square_cosine - square_sine)
    h.a33 = along * square_cosine - two * (mixed * product) + across * square_sine
    h.a02 = t.c12 * sine + t.c13 * (cosine * inverse2)
    h.a03 = t.c12 * cosine - t.c13 * (sine * inverse2)
    h.a12 = t.c23 * (sine * inverse1) + angle2 * cosine
    h.a13 = t.c23 * (cosine * inverse1) - angle2 * sine
    return h


@wp.func
def congruent(h: Any, b: Any):
    """A = (L x I)^T H (L x I) with B = L L^T, 2 x 2; its eigenvalues are those of H (B x I)."""
    two = b.a11.dtype(2.0)
    l11 = square_root(b.a11)
    l21 = b.a12 / l11
    l22 = square_root(larger(b.a22 - l21 * l21, fill(l21, 0.0)))
    s11 = l11 * l11
    s12 = l11 * l21
    s22 = l21 * l21
    a = type(h)()
    a.a00 = s11 * h.a00 + two * (s12 * h.a02) + s22 * h.a22
    a.a01 = s11 * h.a01 + s12 * (h.a03 + h.a12) + s22 * h.a23
    a.a11 = s11 * h.a11 + two * (s12 * h.a13) + s22 * h.a33
    a.a02 = l22 * (l11 * h.a02 + l21 * h.a22)
    a.a03 = l22 * (l11 * h.a03 + l21 * h.a23)
    a.a12 = l22 * (l11 * h.a12 + l21 * h.a23)
    a.a13 = l22 * (l11 * h.a13 + l21 * h.a33)
    square22 = l22 * l22
    a.a22 = square22 * h.a22
    a.a23 = square22 * h.a23
    a.a33 = square22 * h.a33
    return a


@wp.func
def largest_in_plane(h: Any, b: Any):
    """Bound of the largest |eigenvalue| of H (B x I), 4 x 4 and 2 x 2, at most 4.5 % above it: a norm of H^16."""
    a = congruent(h, b)
    # divided by its norm, no eigenvalue is above one, and the largest not below a half: powers fit any precision
    size = square_root(norm_squared(a))
    one = fill(size, 1.0)
    a = scaled(a, where_positive(size, one / size, one))
    squaring_count = int(SQUARING_COUNT)  # a constant would be unrolled, which is slow to compile
    for _squaring in range(squaring_count):
        a = squared(a)
    # the 16th root of |A^16|
    power = norm_squared(a)
    for _root in range(squaring_count + 1):
        power = square_root(power)
    return size * power
