"""The furthest that every element has gone so far, so that a verdict needs no frame at the right instant."""

from functools import cache

import warp as wp

from ..lane_types import lane_types
from ..lanes import larger, magnitude, smaller
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import ExtremeRow, MotionRow
from .kinematics import (
    bend_function,
    element_struct,
    membrane_function,
    shape_functions,
    shape_struct,
    vectors_functions,
)


@cache
def element_extremes_function(real: type, lane_count: int, flat: bool):
    """Function for the extremes of stretches, shear angle and curvatures of a block of elements.

    ``flat``: as in ``SheetTraits``.
    """
    lanes, layout = lane_types(real, lane_count).lanes, (real, lane_count)
    Elements, Shape = element_struct(*layout), shape_struct(*layout)
    positions, vectors = vectors_functions(*layout)
    stretch_membrane, bend = membrane_function(*layout), bend_function(*layout, flat, False)

    @wp.func
    def extremes_of_block(
        # In
        block: wp.int32,
        elements: Elements,
        motion: wp.array(dtype=real),
        # Out
        extremes: wp.array2d(dtype=lanes),  # rows: see ExtremeRow
    ):
        shape = shape_functions(elements, block, Shape())
        x, means = positions(elements, block, shape, motion)
        m = stretch_membrane(x.by1, x.by2)
        b = bend(elements, block, shape, x, vectors(elements, block, shape, motion, MotionRow.director))
        extremes[ExtremeRow.min_warp, block] = smaller(extremes[ExtremeRow.min_warp, block], m.strain1)
        extremes[ExtremeRow.max_warp, block] = larger(extremes[ExtremeRow.max_warp, block], m.strain1)
        extremes[ExtremeRow.min_weft, block] = smaller(extremes[ExtremeRow.min_weft, block], m.strain2)
        extremes[ExtremeRow.max_weft, block] = larger(extremes[ExtremeRow.max_weft, block], m.strain2)
        extremes[ExtremeRow.angle, block] = larger(extremes[ExtremeRow.angle, block], magnitude(m.angle))
        warp, weft = magnitude(b.k11) / m.m11, magnitude(b.k22) / m.m22
        extremes[ExtremeRow.warp_curvature, block] = larger(extremes[ExtremeRow.warp_curvature, block], warp)
        extremes[ExtremeRow.weft_curvature, block] = larger(extremes[ExtremeRow.weft_curvature, block], weft)

    return extremes_of_block


@cache
def element_extremes_kernel(real: type, lane_count: int, flat: bool):
    """Kernel, launched once per block of steps: extremes of every element."""
    lanes, Elements = lane_types(real, lane_count).lanes, element_struct(real, lane_count)
    extremes_of_block = element_extremes_function(real, lane_count, flat)

    @wp.kernel(module="unique", enable_backward=False)
    def element_extremes(
        # In
        first: wp.int32,
        elements: Elements,
        motion: wp.array(dtype=real),
        # Out
        extremes: wp.array2d(dtype=lanes),
    ):
        extremes_of_block(first + wp.tid(), elements, motion, extremes)

    return element_extremes
