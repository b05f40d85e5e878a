"""Bounds of the largest eigenvalue of small symmetric matrices, in lanes."""

from typing import Any

import warp as wp

from ..lanes import div, fill, larger, mul, square_root, where_positive  # noqa: F401 - operators of lanes


@wp.func
def largest_of_pencil(h11: Any, h12: Any, h22: Any, b11: Any, b12: Any, b22: Any):
    """Largest eigenvalue of H B, both 2 x 2 and symmetric, B positive definite."""
    two = h11.dtype(2.0)
    half_trace = h11.dtype(0.5) * (h11 * b11 + two * (h12 * b12) + h22 * b22)
    determinant = (h11 * h22 - h12 * h12) * (b11 * b22 - b12 * b12)
    return half_trace + square_root(larger(half_trace * half_trace - determinant, fill(h11, 0.0)))


@wp.func
def norm_squared(a00: Any, a01: Any, a02: Any, a03: Any, a11: Any, a12: Any, a13: Any, a22: Any, a23: Any, a33: Any):
    """Sum of the squared entries of a symmetric 4 x 4 matrix."""
    diagonal = a00 * a00 + a11 * a11 + a22 * a22 + a33 * a33
    rest = a01 * a01 + a02 * a02 + a03 * a03 + a12 * a12 + a13 * a13 + a23 * a23
    return diagonal + a00.dtype(2.0) * rest


@wp.func
def largest_in_plane(
    c11: Any,
    c12: Any,
    c22: Any,
    c13: Any,
    c23: Any,
    c33: Any,
    n1: Any,
    n2: Any,
    moment: Any,
    stretch1: Any,
    stretch2: Any,
    sine: Any,
    cosine: Any,
    b11: Any,
    b12: Any,
    b22: Any,
):
    """Bound of the largest |eigenvalue| of H (B x I) for motions in the tangent plane, at most 4.5 % above it.

    H is the 4 x 4 second derivative by (da_1, da_2) of an energy of the stretches and the shear angle: its tangent C on
    the strains, and the forces n_1, n_2 and the moment m on their curvature. A norm of H^16 is its bound.
    """
    one = fill(sine, 1.0)
    inverse1 = one / stretch1
    inverse2 = one / stretch2
    # blocks of H in the tangent frame (e_1, across e_1); e_2 = (sin, cos), and the angle falls along (-cos, sin)
    xx = c11
    xy = inverse1 * (c13 - moment * inverse1)
    yy = inverse1 * (n1 + c33 * inverse1)
    along = c22
    mixed = inverse2 * (c23 - moment * inverse2)
    across = inverse2 * (n2 + c33 * inverse2)
    square_sine = sine * sine
    product = sine * cosine
    square_cosine = cosine * cosine
    zz = along * square_sine + sine.dtype(2.0) * (mixed * product) + across * square_cosine
    zw = (along - across) * product + mixed * (square_cosine - square_sine)
    ww = along * square_cosine - sine.dtype(2.0) * (mixed * product) + across * square_sine
    angle2 = c33 * (inverse1 * inverse2)
    xz = c12 * sine + c13 * (cosine * inverse2)
    xw = c12 * cosine - c13 * (sine * inverse2)
    yz = c23 * (sine * inverse1) + angle2 * cosine
    yw = c23 * (cosine * inverse1) - angle2 * sine
    # A = L^T H L with B = L L^T
    l11 = square_root(b11)
    l21 = b12 / l11
    l22 = square_root(larger(b22 - l21 * l21, fill(sine, 0.0)))
    s11 = l11 * l11
    s12 = l11 * l21
    s22 = l21 * l21
    a00 = s11 * xx + sine.dtype(2.0) * (s12 * xz) + s22 * zz
    a01 = s11 * xy + s12 * (xw + yz) + s22 * zw
    a11 = s11 * yy + sine.dtype(2.0) * (s12 * yw) + s22 * ww
    a02 = l22 * (l11 * xz + l21 * zz)
    a03 = l22 * (l11 * xw + l21 * zw)
    a12 = l22 * (l11 * yz + l21 * zw)
    a13 = l22 * (l11 * yw + l21 * ww)
    l22 = l22 * l22
    a22 = l22 * zz
    a23 = l22 * zw
    a33 = l22 * ww
    # over its norm no eigenvalue is above one, and the largest not below a half: its powers fit any precision
    size = square_root(norm_squared(a00, a01, a02, a03, a11, a12, a13, a22, a23, a33))
    scaling = where_positive(size, one / size, one)
    a00 = a00 * scaling
    a01 = a01 * scaling
    a02 = a02 * scaling
    a03 = a03 * scaling
    a11 = a11 * scaling
    a12 = a12 * scaling
    a13 = a13 * scaling
    a22 = a22 * scaling
    a23 = a23 * scaling
    a33 = a33 * scaling
    squaring_count = int(4)  # noqa: UP018, a literal would be unrolled and take long to compile
    for _squaring in range(squaring_count):
        p00 = a00 * a00 + a01 * a01 + a02 * a02 + a03 * a03
        p01 = a00 * a01 + a01 * a11 + a02 * a12 + a03 * a13
        p02 = a00 * a02 + a01 * a12 + a02 * a22 + a03 * a23
        p03 = a00 * a03 + a01 * a13 + a02 * a23 + a03 * a33
        p11 = a01 * a01 + a11 * a11 + a12 * a12 + a13 * a13
        p12 = a01 * a02 + a11 * a12 + a12 * a22 + a13 * a23
        p13 = a01 * a03 + a11 * a13 + a12 * a23 + a13 * a33
        p22 = a02 * a02 + a12 * a12 + a22 * a22 + a23 * a23
        p23 = a02 * a03 + a12 * a13 + a22 * a23 + a23 * a33
        p33 = a03 * a03 + a13 * a13 + a23 * a23 + a33 * a33
        a00 = p00
        a01 = p01
        a02 = p02
        a03 = p03
        a11 = p11
        a12 = p12
        a13 = p13
        a22 = p22
        a23 = p23
        a33 = p33
    # the 16th root of |A^16|
    power = norm_squared(a00, a01, a02, a03, a11, a12, a13, a22, a23, a33)
    for _root in range(squaring_count + 1):
        power = square_root(power)
    return size * power
