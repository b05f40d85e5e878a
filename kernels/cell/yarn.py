"""One yarn of the plain weave: strain, forces, and higher derivatives of its energy (docs/theory.md, section 2)."""

from typing import Any

import warp as wp

from ..angles import angle_beside
from ..lanes import fill, from_rows, inverses, larger, magnitude, square_root, where_positive
from ..operators import add, div, mul, sub  # noqa: F401

# Rows of a yarn's state, from which its higher derivatives are computed: l - l0, axial stiffness [N/m], moment [N m],
# cosine and sine of the chord, 1/l.
ELONGATION = wp.constant(0)
STIFFNESS = wp.constant(1)
MOMENT = wp.constant(2)
COSINE = wp.constant(3)
SINE = wp.constant(4)
INVERSE_LENGTH = wp.constant(5)


@wp.func
def yarn_chord(cell: Any, k: int, u: Any, w: Any):
    """Elongation l - l0 of yarn k's chord, the chord (X, H, 1/l), and of its rotation phi sin and 1 + cos, times l l0.

    Both are written without cancellation: l - l0 = (l^2 - l0^2)/(l + l0), and sin(phi) l l0 = L w - h u.
    """
    half_spacing = cell.half_spacing[k]
    crimp_height = cell.crimp_height[k]
    chord_length = cell.chord_length[k]
    x = fill(u, half_spacing) + u
    h = fill(u, crimp_height) + w
    length = square_root(x * x + h * h)
    along = u * (u.dtype(2.0) * fill(u, half_spacing) + u)
    across = w * (u.dtype(2.0) * fill(u, crimp_height) + w)
    inverse_length, inverse_sum = inverses(length, length + fill(u, chord_length))
    elongation = (along + across) * inverse_sum
    sine = half_spacing * w - crimp_height * u
    beside = chord_length * length + (half_spacing * x + crimp_height * h)
    return elongation, x, h, inverse_length, sine, beside


@wp.func
def yarn_strain(cell: Any, k: int, u: Any, w: Any):
    """Elongation l - l0 and rotation phi of yarn k's chord, and the chord (X, H, 1/l)."""
    elongation, x, h, inverse_length, sine, beside = yarn_chord(cell, k, u, w)
    return elongation, angle_beside(sine, beside), x, h, inverse_length


@wp.func
def yarn_axial_stiffness(cell: Any, k: int, elongation: Any):
    return where_positive(
        elongation, fill(elongation, cell.tensile_stiffness[k]), fill(elongation, cell.compressive_stiffness[k])
    )


@wp.func
def strained_forces(cell: Any, k: int, elongation: Any, rotation: Any, x: Any, h: Any, inverse_length: Any):
    """``yarn_forces`` of a strained yarn."""
    stiffness = yarn_axial_stiffness(cell, k, elongation)
    axial = stiffness * elongation
    moment = cell.rotation_stiffness[k] * rotation
    cosine = x * inverse_length
    sine = h * inverse_length
    shear = moment * inverse_length
    by_u = axial * cosine - shear * sine
    by_w = axial * sine + shear * cosine
    # d2Pi/dw2: elastic part K_E, geometric part K_G
    turning = cosine * inverse_length
    elastic = stiffness * sine * sine + cell.rotation_stiffness[k] * turning * turning
    geometric = (axial * cosine - x.dtype(2.0) * shear * sine) * turning
    # reference size of the residual
    size = magnitude(axial * sine) + magnitude(shear * cosine)
    state = from_rows(elongation, stiffness, moment, cosine, sine, inverse_length)
    return by_u, by_w, elastic + geometric, elastic, size, state


@wp.func
def yarn_forces(cell: Any, k: int, u: Any, w: Any):
    """dPi/du, dPi/dw, d2Pi/dw2, its positive part, the size of the terms of dPi/dw, and the state, of yarn k alone."""
    elongation, rotation, x, h, inverse_length = yarn_strain(cell, k, u, w)
    return strained_forces(cell, k, elongation, rotation, x, h, inverse_length)


@wp.func
def yarn_expansion(cell: Any, k: int, state: Any):
    """Further derivatives of yarn k's energy: uw, uww, www."""
    elongation = state[ELONGATION]
    stiffness = state[STIFFNESS]
    moment = state[MOMENT]
    cosine = state[COSINE]
    sine = state[SINE]
    inverse_length = state[INVERSE_LENGTH]
    one = fill(moment, 1.0)
    two = moment.dtype(2.0)
    four = moment.dtype(4.0)
    bending = cell.rotation_stiffness[k] * inverse_length * inverse_length
    shear = moment * inverse_length * inverse_length
    along = stiffness - stiffness * elongation * inverse_length - two * bending
    c2 = cosine * cosine
    s2 = sine * sine
    turning = cosine * inverse_length
    twice_shear = two * shear * inverse_length
    uw = cosine * sine * (along + bending) - shear * (c2 - s2)
    uww = turning * (c2 - two * s2) * along + twice_shear * sine * (four * c2 - one)
    www = moment.dtype(3.0) * turning * cosine * sine * along + twice_shear * cosine * (four * s2 - one)
    return uw, uww, www


@wp.func
def yarn_remainder(cell: Any, k: int, state: Any, step: Any):
    """Change of dPi/dw of yarn k in a step of w beyond the third derivative, of the size of its terms; elongation.

    This includes d4Pi/dw4, and the change of stiffness when the yarn switches between tension and compression.
    """
    elongation = state[ELONGATION]
    stiffness = state[STIFFNESS]
    moment = state[MOMENT]
    cosine = state[COSINE]
    sine = state[SINE]
    inverse_length = state[INVERSE_LENGTH]
    bend = cosine * step * inverse_length
    stretched = elongation + sine * step + step.dtype(0.5) * cosine * bend * step
    passed = larger(where_positive(elongation, -stretched, stretched), fill(step, 0.0))
    jump = wp.abs(cell.tensile_stiffness[k] - cell.compressive_stiffness[k])
    fourth = step.dtype(2.0) * (stiffness + cell.rotation_stiffness[k] * inverse_length * inverse_length)
    beyond = fourth * bend * bend * magnitude(step) + jump * passed * magnitude(sine)
    axial = stiffness * sine
    turning = inverse_length * cosine
    before = magnitude(axial * elongation) + magnitude(turning * moment)
    after = magnitude(axial * stretched) + magnitude(turning * (moment + cell.rotation_stiffness[k] * bend))
    return beyond, after - before, stretched


@wp.func
def yarn_hessian(cell: Any, k: int, u: Any, w: Any, in_tension: bool):
    """Second derivatives (uu, uw, ww) of yarn k's energy, and their determinant without cancellation.

    ``in_tension``: always with its stiffness in tension.
    """
    elongation, rotation, x, h, inverse_length = yarn_strain(cell, k, u, w)
    stiffness = yarn_axial_stiffness(cell, k, elongation)
    axial = stiffness * elongation * inverse_length
    if in_tension:
        stiffness = fill(u, cell.tensile_stiffness[k])
        axial = larger(axial, fill(u, 0.0))
    bending = cell.rotation_stiffness[k] * inverse_length * inverse_length
    moment = cell.rotation_stiffness[k] * rotation * inverse_length * inverse_length
    c = x * inverse_length
    s = h * inverse_length
    twice = u.dtype(2.0) * moment * c * s
    uu = stiffness * c * c + axial * s * s + bending * s * s + twice
    uw = (stiffness - axial - bending) * c * s - moment * (c * c - s * s)
    ww = stiffness * s * s + axial * c * c + bending * c * c - twice
    return uu, uw, ww, stiffness * (axial + bending) - moment * moment
