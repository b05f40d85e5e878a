"""The furthest that every element has gone so far, so that a verdict needs no frame at the right instant."""

from functools import cache

import warp as wp

from ..lanes import lane_types, larger, magnitude, smaller
from ..operators import div, mul  # noqa: F401
from ..rows import ExtremeRow
from .kinematics import element_struct, membrane_function, shape_functions, shape_struct, vectors_functions


@cache
def element_extremes_kernel(real: type, lane_count: int):
    """Kernel, launched once per block of steps: extremes of stretches and shear angle."""
    lanes, layout = lane_types(real, lane_count).lanes, (real, lane_count)
    Elements, Shape = element_struct(*layout), shape_struct(*layout)
    positions, _ = vectors_functions(*layout)
    stretch_membrane = membrane_function(*layout)

    @wp.kernel(module="unique", enable_backward=False)
    def element_extremes(
        # In
        first: wp.int32,
        elements: Elements,
        motion: wp.array(dtype=real),
        # Out
        extremes: wp.array2d(dtype=lanes),  # rows: see ExtremeRow
    ):
        block = first + wp.tid()
        shape = shape_functions(elements, block, Shape())
        x = positions(elements, block, shape, motion)
        m = stretch_membrane(x.by1, x.by2)
        extremes[ExtremeRow.min_warp, block] = smaller(extremes[ExtremeRow.min_warp, block], m.strain1)
        extremes[ExtremeRow.max_warp, block] = larger(extremes[ExtremeRow.max_warp, block], m.strain1)
        extremes[ExtremeRow.min_weft, block] = smaller(extremes[ExtremeRow.min_weft, block], m.strain2)
        extremes[ExtremeRow.max_weft, block] = larger(extremes[ExtremeRow.max_weft, block], m.strain2)
        extremes[ExtremeRow.angle, block] = larger(extremes[ExtremeRow.angle, block], magnitude(m.angle))

    return element_extremes
