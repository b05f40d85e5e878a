"""Angles in lanes without trigonometric calls."""

from typing import Any

import numpy as np
import warp as wp

from .lane_types import ALL_LANE_TYPES
from .lanes import fill, larger, magnitude, smaller, where_positive
from .operators import add, div, mul, sub  # noqa: F401

_RIGHT_ANGLE = wp.constant(wp.float64(0.5 * np.pi))


def arctangent_coefficients(term_count: int, largest_square: float = 1.0) -> list[float]:
    """Coefficients c_k of atan(x)/x = sum c_k x^(2k) for 0 <= x^2 <= ``largest_square``, near-minimax (Chebyshev)."""
    chebyshev = np.polynomial.Chebyshev.interpolate(
        lambda z: np.where(
            z > 1e-12, np.arctan(np.sqrt(np.abs(z))) / np.sqrt(np.maximum(np.abs(z), 1e-300)), 1 - z / 3
        ),
        term_count - 1,
        domain=[0.0, largest_square],
    )
    return chebyshev.convert(kind=np.polynomial.Polynomial).coef.tolist()


# The error is 3e-9 with ten terms, 1e-15 with twenty.
_SINGLE_ARCTANGENT = wp.types.vector(10, wp.float32)(*arctangent_coefficients(10))
_DOUBLE_ARCTANGENT = wp.types.vector(20, wp.float64)(*arctangent_coefficients(20))


@wp.func
def polynomial(x: Any, coefficients: Any):
    """Polynomial in ``x``; an even number of ``coefficients``, the constant first.

    Even and odd powers are separate: two chains of half the length, whose multiply-adds are independent.
    """
    square = mul(x, x)
    even = type(x)()
    odd = type(x)()
    for k in range(len(coefficients) // 2):
        even = mul(even, square) + fill(x, coefficients[len(coefficients) - 2 - 2 * k])
        odd = mul(odd, square) + fill(x, coefficients[len(coefficients) - 1 - 2 * k])
    return even + mul(x, odd)


for _types in ALL_LANE_TYPES:
    if _types.real is wp.float32:

        @wp.func
        def arctangent_ratio(square: _types.lanes):
            """atan(x)/x of ``square`` = x^2 up to 1, to the precision of the lanes."""
            return polynomial(square, _SINGLE_ARCTANGENT)
    else:

        @wp.func
        def arctangent_ratio(square: _types.lanes):
            """atan(x)/x of ``square`` = x^2 up to 1, to the precision of the lanes."""
            return polynomial(square, _DOUBLE_ARCTANGENT)


@wp.func
def angle_of(sine: Any, cosine: Any, radius: Any):
    """atan2(sine, cosine), where ``radius`` = sqrt(sine^2 + cosine^2), to a few round-offs up to 170 degrees.

    Twice the arctangent of tan(x/2) = sine/(radius + cosine), or of its reciprocal beyond a right angle: one division,
    no root, no branch.
    """
    size = magnitude(sine)
    beside = radius + cosine
    tangent = div(smaller(size, beside), larger(size, beside))
    half = mul(tangent, arctangent_ratio(mul(tangent, tangent)))
    half = where_positive(size - beside, fill(half, half.dtype(_RIGHT_ANGLE)) - half, half)
    return where_positive(sine, half + half, -(half + half))
