"""Curves as evenly spaced tables of cubic pieces, and the spring-slider for hysteresis (theory, section 3)."""

from functools import cache
from typing import Any

import warp as wp

from .lanes import fill, magnitude, where_positive
from .operators import add, div, mul, sub  # noqa: F401


@cache
def curve_struct(real: type):
    """A function of x >= 0, as cubic pieces between evenly spaced knots; the last piece extends to infinity."""

    @wp.struct
    class Curve:
        knot_spacing: real
        knots_per_unit: real  # its reciprocal
        coefficient: wp.array(dtype=wp.types.vector(4, real))  # c0 + c1 x + c2 x^2 + c3 x^3 from each knot on
        integral: wp.array(dtype=real)  # of the function, up to each knot

    return Curve


@wp.func
def curve_piece(curve: Any, value: Any):
    """Piece of the curve that contains |value|, and the position in it."""
    size = wp.abs(value)
    # clamped from below too: a NaN becomes the most negative integer
    piece = wp.clamp(int(size * curve.knots_per_unit), 0, curve.coefficient.shape[0] - 1)
    return piece, size - type(value)(piece) * curve.knot_spacing


@wp.func
def curve_size(curve: Any, x: Any):
    """The curve at |x|: an even function."""
    result = type(x)()
    for i in range(len(x)):
        piece, s = curve_piece(curve, x[i])
        c = curve.coefficient[piece]
        result[i] = c[0] + s * (c[1] + s * (c[2] + s * c[3]))
    return result


@wp.func
def odd_curve(curve: Any, x: Any):
    """The curve with the sign of x, and its derivative."""
    result = type(x)()
    tangent = type(x)()
    for i in range(len(x)):
        piece, s = curve_piece(curve, x[i])
        c = curve.coefficient[piece]
        value = c[0] + s * (c[1] + s * (c[2] + s * c[3]))
        result[i] = wp.where(x[i] < x.dtype(0.0), -value, value)
        tangent[i] = c[1] + s * (x.dtype(2.0) * c[2] + x.dtype(3.0) * s * c[3])
    return result, tangent


@wp.func
def curve_energy(curve: Any, x: Any):
    """Integral of the odd curve from 0 to x."""
    energy = type(x)()
    for i in range(len(x)):
        piece, s = curve_piece(curve, x[i])
        c = curve.coefficient[piece]
        energy[i] = curve.integral[piece] + s * (
            c[0] + s * (c[1] / x.dtype(2.0) + s * (c[2] / x.dtype(3.0) + s * c[3] / x.dtype(4.0)))
        )
    return energy


@wp.func
def slide(strain: Any, slip: Any, spring_before: Any, stiffness: Any, limit: Any, resolution: Any):
    """Spring and slider in series: the force k (strain - slip) stays within its limit, because the slip follows.

    Rounding of the difference (``resolution``, relative) is not slip: the same strain twice gives the same bits.
    Returns the new slip, the new spring = strain - slip, and the work lost: the mean force of the step times the slip,
    so that stored plus lost energy is the work of the mean forces, even if the limit changes.
    """
    spring = strain - slip
    free = limit / fill(strain, stiffness)
    excess = magnitude(spring) - free - resolution * (magnitude(strain) + magnitude(slip) + free)
    held = where_positive(spring, free, -free)
    new_slip = where_positive(excess, strain - held, slip)
    new_spring = strain - new_slip
    mean_force = (strain.dtype(0.5) * stiffness) * (spring_before + new_spring)
    return new_slip, new_spring, mean_force * (new_slip - slip)


@wp.func
def book_loss(slip: Any, row: int, remainder_row: int, block: int, lost: Any):
    """Add to a loss, with what rounding cut off in a row of its own: the sum of many small increments."""
    before = slip[row, block]
    whole = lost + slip[remainder_row, block]
    after = before + whole
    slip[remainder_row, block] = whole - (after - before)
    slip[row, block] = after


@wp.func
def spring_energy(stiffness: Any, spring: Any):
    """psi of the spring in series with a slider [J/m^2]."""
    return (spring.dtype(0.5) * stiffness) * (spring * spring)
