"""Terms that couple positions and directors in the bound of an element's frequency (docs/theory.md, section 7).

Norms come in threes: contributions of an energy term to positions, to their coupling with directors, and to directors.
"""

from functools import cache
from typing import Any

import warp as wp

from ..lane_types import lane_types
from ..lanes import dot, fill, larger, square_root
from ..laws.contract import BendingDevice, device_law
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import CurvatureRow, TransverseShearRow
from .eigenvalue import largest_of_pencil
from .hourglass import hourglass_stiffnesses, twist_weights
from .kinematics import skew_weights
from .laws import SheetTraits

# Effects of the tilt in transverse shear, relative to the leading terms: on positions, linear and squared; on positions
# and directors. Rounded up from proven values (docs/theory.md, section 7, *Coupled terms*). For bending see its law.
TILT_STIFFENING = 4.4  # proven: 1 + sqrt 2 = 2.42
TILT_SQUARE_STIFFENING = 8.5  # proven: 1 + 2 sqrt 2 + (1 + sqrt 2)/2 = 5.04
TILT_COUPLING = 5.4  # proven: sqrt 5 = 2.24
# Warping contains a quarter of x_h.d, and the mean d of four corners is at most half of their norm.
MEAN_WARPING = 0.125


@cache
def sizes_struct(real: type, lane_count: int):
    """Sizes in the current metric that couple positions and directors, for a block of elements."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class Sizes:
        gradient: lanes  # largest eigenvalue of the inverse metric times B [1/m^2], and its root
        root_gradient: lanes
        curvature: lanes  # [1/m]
        tilt: lanes  # of the mean director
        x_odd: lanes  # lengths of the hourglass vectors of positions [m] and directors
        d_odd: lanes
        lean: lanes  # of any director at the corners
        largest_metric: lanes
        inverse_radius: lanes  # of the scaled rotary inertia [1/m], and its square
        inverse_squared_radius: lanes
        contact_directors: lanes  # springs of contact between nodes: on directors [N/m], and on positions and directors
        contact_coupling: lanes

    return Sizes


@cache
def sizes_function(real: type, lane_count: int, flat: bool):
    """Function for the ``Sizes`` of a block."""
    Sizes = sizes_struct(real, lane_count)

    @wp.func
    def measure(elements: Any, block: int, x: Any, d: Any, m: Any, raised: Any, b: Any, inverse_squared_radius: Any):
        two = inverse_squared_radius.dtype(2.0)
        zero = fill(inverse_squared_radius, 0.0)
        gradient = largest_of_pencil(raised, b)
        tilt1 = dot(x.by1, d.mean)
        tilt2 = dot(x.by2, d.mean)
        curvature = raised.a11 * dot(d.by1, d.by1) + two * (raised.a12 * dot(d.by1, d.by2))
        curvature = curvature + raised.a22 * dot(d.by2, d.by2)
        tilt = raised.a11 * tilt1 * tilt1 + two * (raised.a12 * tilt1 * tilt2) + raised.a22 * tilt2 * tilt2
        if wp.static(not flat):
            raising = raised.a11 + raised.a22
            k11 = elements.initial_curvature[CurvatureRow.k11, block]
            k12 = elements.initial_curvature[CurvatureRow.k12, block]
            k22 = elements.initial_curvature[CurvatureRow.k22, block]
            g1 = elements.initial_transverse_shear[TransverseShearRow.g1, block]
            g2 = elements.initial_transverse_shear[TransverseShearRow.g2, block]
            curvature = two * (curvature + raising * raising * (k11 * k11 + two * (k12 * k12) + k22 * k22))
            tilt = two * (tilt + raising * (g1 * g1 + g2 * g2))
        curvature = square_root(larger(curvature, zero))
        tilt = square_root(larger(tilt, zero))
        x_odd = square_root(dot(x.hourglass, x.hourglass))
        d_odd = square_root(dot(d.hourglass, d.hourglass))
        root_gradient = square_root(gradient)
        lean = tilt + curvature / root_gradient + inverse_squared_radius.dtype(0.25) * d_odd
        return Sizes(
            gradient, root_gradient, curvature, tilt, x_odd, d_odd, lean, m.m11 + m.m22,
            square_root(inverse_squared_radius), inverse_squared_radius, zero, zero,
        )  # fmt: skip

    return measure


@cache
def slope_function(skewed: bool):
    """Function for the contributions of transverse shear to positions, coupling with directors, and directors."""

    @wp.func
    def slope_norms(shape: Any, slope: Any, size: Any):
        """Transverse shear couples slopes and mean directors, in a flat element too, with the full director length."""
        one = fill(slope, 1.0)
        half = slope.dtype(0.5)
        positions = slope * size.gradient
        half_directors = fill(slope, 0.5)
        if wp.static(skewed):
            skew11, skew12, skew13, skew21, skew22, skew23 = skew_weights(shape)
            skew = skew11 * skew11 + skew13 * skew13 + skew21 * skew21 + skew23 * skew23
            skew = skew + half * (skew12 * skew12 + skew22 * skew22)
            half_directors = half_directors + square_root(skew * size.gradient * size.largest_metric)
        directors = slope * half_directors * half_directors * size.inverse_squared_radius
        stiffening = fill(slope, slope.dtype(TILT_STIFFENING)) + slope.dtype(TILT_SQUARE_STIFFENING) * size.tilt
        tilting = positions * size.tilt * stiffening
        coupling = square_root(positions * directors) * (one + slope.dtype(TILT_COUPLING) * size.tilt)
        return tilting, coupling, directors

    return slope_norms


@cache
def bending_function(law: BendingDevice):
    """Function for the contributions of bending to positions, coupling with director gradients, and directors."""
    stiffening, coupled = law.curvature_stiffening, law.curvature_coupling

    @wp.func
    def bending_norms(bending: Any, size: Any):
        positions = (bending.dtype(stiffening) * bending) * (size.curvature * size.curvature)
        coupling = (bending.dtype(coupled) * bending) * (size.inverse_radius * size.curvature)
        return positions, coupling, bending * size.inverse_squared_radius

    return bending_norms


@wp.func
def warping_norms(shape: Any, squares: Any, length: Any, size: Any):
    """Warping due to positions and directors, and their coupling: a quarter of x_h, and the twist of the curvature.

    x_h has the norm ``length``.
    """
    half = length.dtype(0.5)
    quarter = length.dtype(0.25)
    mean_warping = length.dtype(MEAN_WARPING)
    weight11, weight12, weight22 = twist_weights(shape)
    twist = square_root(squares * (weight11 * weight11 + half * weight12 * weight12 + weight22 * weight22))
    root_metric = square_root(size.largest_metric)
    positions = quarter * length + twist * root_metric * size.curvature
    directors = size.inverse_radius * (twist * root_metric + mean_warping * size.x_odd)
    warp = quarter * size.x_odd + twist * size.curvature / size.root_gradient
    coupling = positions * directors + warp * size.inverse_radius * (mean_warping * length + twist * size.root_gradient)
    return positions, coupling, directors


@wp.func
def largest_of_blocks(positions: Any, coupling: Any, directors: Any):
    """Largest eigenvalue of the symmetric 2 x 2 matrix of norms."""
    half = positions.dtype(0.5)
    mean = half * (positions + directors)
    difference = half * (positions - directors)
    return mean + square_root(difference * difference + coupling * coupling)


@cache
def coupled_function(traits: SheetTraits):
    """Function for the bound of a block's eigenvalues for all motions, from those within and across its plane."""
    slope_norms = slope_function(traits.skewed)
    bending_norms = bending_function(device_law(traits.bending))

    @wp.func
    def couple(laws: Any, bending: Any, slope: Any, shape: Any, b: Any, size: Any, in_plane: Any, across: Any):
        one = fill(slope, 1.0)
        two = slope.dtype(2.0)
        tilting, slope_coupling, mean_directors = slope_norms(shape, slope, size)
        bending_positions, bending_coupling, bending_directors = bending_norms(bending, size)
        constraint = mean_directors * size.tilt * size.lean
        constraint = constraint + bending_directors * size.curvature * size.lean / size.root_gradient

        in_plane_stiffness, warping_stiffness, director_stiffness = hourglass_stiffnesses(laws, shape)
        squares = b.a11 + b.a22
        length = square_root(
            fill(slope, 4.0) + two * (shape.offset_p * shape.offset_p + shape.offset_q * shape.offset_q)
        )
        tipping = size.x_odd * size.root_gradient
        in_plane_odd = in_plane_stiffness * length * (length + two * tipping * (one + tipping))
        warp_positions, warp_coupling, warp_directors = warping_norms(shape, squares, length, size)
        odd_positions = square_root(squares) * size.d_odd
        odd_directors = size.inverse_radius * (length * square_root(size.largest_metric))

        # in a flat element, slopes with mean directors and warping with director gradients are decoupled
        positions = larger(
            larger(in_plane, across) + tilting,
            larger(in_plane_odd, warping_stiffness * warp_positions * warp_positions),
        )
        positions = positions + bending_positions + director_stiffness * odd_positions * odd_positions
        directors = larger(
            larger(mean_directors, bending_directors + warping_stiffness * warp_directors * warp_directors),
            director_stiffness * odd_directors * odd_directors,
        )
        coupling = larger(slope_coupling, warping_stiffness * warp_coupling) + bending_coupling
        coupling = coupling + (two * director_stiffness) * (odd_positions * odd_directors)
        coupling = coupling + size.contact_coupling
        return largest_of_blocks(positions, coupling, directors + constraint + size.contact_directors)

    return couple
