"""Angles in lanes without trigonometric calls."""

from typing import Any

import numpy as np
import warp as wp

from .lane_types import ALL_LANE_TYPES, GPU_LANE_COUNT, LaneTypes
from .lanes import fill, from_rows, larger, magnitude, smaller, where_positive
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
_TERMS = {real: arctangent_coefficients(count) for real, count in ((wp.float32, 10), (wp.float64, 20))}
_SINGLE_ARCTANGENT = wp.types.vector(10, wp.float32)(*_TERMS[wp.float32])
_DOUBLE_ARCTANGENT = wp.types.vector(20, wp.float64)(*_TERMS[wp.float64])


def _polynomials(types: LaneTypes) -> str:
    """C++ of the polynomials in every row of ``square``, all in one loop, so that none waits for the others.

    A loop that stays one keeps few values alive, and has nothing but sums and products in it: an index of Warp's is
    computed and checked in every turn.
    """
    scalar, coefficients = f"wp::{types.real.__name__}", _TERMS[types.real]
    return f"""
        using Row = {scalar} __attribute__((ext_vector_type({types.lane_count})));
        static constexpr {scalar} c[] = {{{", ".join(f"{scalar}({value!r})" for value in coefficients)}}};
        constexpr int last = {len(coefficients) - 2}, rows = sizeof(square) / sizeof(Row);
        Row x[rows], power[rows], even[rows], odd[rows];
        memcpy(x, &square, sizeof(x));
        for (int row = 0; row < rows; ++row)
            power[row] = x[row] * x[row], even[row] = c[last], odd[row] = c[last + 1];
        _Pragma("clang loop unroll(disable)")
        for (int k = last - 2; k >= 0; k -= 2)
            for (int row = 0; row < rows; ++row)
                even[row] = even[row] * power[row] + c[k], odd[row] = odd[row] * power[row] + c[k + 1];
        for (int row = 0; row < rows; ++row)
            x[row] = even[row] + x[row] * odd[row];
        memcpy(&square, x, sizeof(x));
        return square;
    """


@wp.func
def polynomial(x: Any, coefficients: Any):
    """Polynomial in ``x``; an even number of ``coefficients``, the constant first. Even and odd powers are separate."""
    square = mul(x, x)
    even = type(x)()
    odd = type(x)()
    for k in range(len(coefficients) // 2):
        even = mul(even, square) + fill(x, coefficients[len(coefficients) - 2 - 2 * k])
        odd = mul(odd, square) + fill(x, coefficients[len(coefficients) - 1 - 2 * k])
    return even + mul(x, odd)


for _types in ALL_LANE_TYPES:
    if _types.real is wp.float64:

        @wp.func
        def arctangent_ratio(square: _types.lanes):
            """atan(x)/x of ``square`` = x^2 up to 1, to the precision of the lanes."""
            return polynomial(square, _DOUBLE_ARCTANGENT)

    elif _types.lane_count == GPU_LANE_COUNT:

        @wp.func
        def arctangent_ratio(square: _types.lanes):
            return polynomial(square, _SINGLE_ARCTANGENT)

    else:
        _lanes2 = wp.types.matrix((2, _types.lane_count), _types.real)

        @wp.func_native(_polynomials(_types))
        def arctangent_ratio(square: _types.lanes) -> _types.lanes: ...

        @wp.func_native(_polynomials(_types))
        def arctangent_ratio(square: _lanes2) -> _lanes2: ...


@wp.func
def half_tangent(sine: Any, beside: Any):
    """tan of half an angle, or its reciprocal beyond a right angle; ``beside`` is the radius plus the cosine."""
    size = magnitude(sine)
    return div(smaller(size, beside), larger(size, beside))


@wp.func
def twice(sine: Any, beside: Any, half: Any):
    """The angle from the arctangent of ``half_tangent``."""
    half = where_positive(magnitude(sine) - beside, fill(half, half.dtype(_RIGHT_ANGLE)) - half, half)
    return where_positive(sine, half + half, -(half + half))


@wp.func
def angle_of(sine: Any, cosine: Any, radius: Any):
    """atan2(sine, cosine), where ``radius`` = sqrt(sine^2 + cosine^2), to a few round-offs up to 170 degrees.

    Twice the arctangent of tan(x/2) = sine/(radius + cosine), or of its reciprocal beyond a right angle: one division,
    no root, no branch.
    """
    return angle_beside(sine, radius + cosine)


@wp.func
def angle_beside(sine: Any, beside: Any):
    """``angle_of``, given radius plus cosine."""
    tangent = half_tangent(sine, beside)
    return twice(sine, beside, mul(tangent, arctangent_ratio(mul(tangent, tangent))))


@wp.func
def angles_of(sine1: Any, beside1: Any, sine2: Any, beside2: Any):
    """``angle_beside`` of two angles, for sixteen lanes of single precision: neither waits for the other's sums."""
    tangent1 = half_tangent(sine1, beside1)
    tangent2 = half_tangent(sine2, beside2)
    ratios = arctangent_ratio(from_rows(mul(tangent1, tangent1), mul(tangent2, tangent2)))
    return twice(sine1, beside1, mul(tangent1, ratios[0])), twice(sine2, beside2, mul(tangent2, ratios[1]))
