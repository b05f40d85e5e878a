"""Arguments of friction laws between plies: pressure, angle between the warps, Hersey number."""

from functools import cache

import warp as wp

from ..contact.friction import NO_ARGUMENT, YARN_ANGLE, friction_law_struct, law_argument, widened
from ..lane_types import lane_types
from ..lanes import dot, fill, magnitude, scale, smaller, square_root
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import MotionRow, PlyRow
from .data import record_struct, slaves_struct
from .facet import facets_struct, patch_functions

# Series of the arc cosine: acos(x) = sqrt(1 - x) (a0 + a1 x + ...), Abramowitz and Stegun 4.4.46, error 2e-8. A vector
# of Warp is part of a kernel's hash; an entry of a tuple that depends on a loop would not be.
_ARC_COSINE = (
    1.5707963050, -0.2145988016, 0.0889789874, -0.0501743046, 0.0308918810, -0.0170881256, 0.0066700901, -0.0012624911,
)  # fmt: skip


@cache
def yarn_angle_function(real: type, lane_count: int):
    """wp.func -> angle between the warps of both plies, from 0 to a right angle [rad]."""
    types = lane_types(real, lane_count)
    lanes, indices = types.lanes, types.indices
    Slaves, Facets = slaves_struct(real, lane_count), facets_struct(real)
    vectors, _, _, _ = patch_functions(real, lane_count)
    arc_cosine = wp.types.vector(len(_ARC_COSINE), real)(*_ARC_COSINE)

    @wp.func
    def gradient(facets: Facets, facet: indices, diagonal: int):
        result = lanes()
        for i in range(lane_count):
            result[i] = facets.warp_gradient[diagonal, facet[i]]
        return result

    @wp.func
    def warp_along(facets: Facets, facet: indices):
        x = vectors(facets, facet, MotionRow.position)
        # the diagonals are -2 (along1 + along2) and 2 (along1 - along2)
        first = gradient(facets, facet, 0)
        second = gradient(facets, facet, 1)
        return scale(second - first, x.along1) - scale(first + second, x.along2)

    @wp.func
    def yarn_angle(slaves: Slaves, facets: Facets, block: int, facet: indices):
        own = warp_along(slaves.facets, slaves.home[block])
        other = warp_along(facets, facet)
        one = fill(own[0], 1.0)
        cosine = magnitude(dot(own, other)) / square_root(dot(own, own) * dot(other, other))
        cosine = smaller(cosine, one)
        series = lanes()
        for k in range(len(arc_cosine)):
            series = series * cosine + lanes(arc_cosine[len(arc_cosine) - 1 - k])
        return series * square_root(one - cosine)

    return yarn_angle


@cache
def friction_argument_function(real: type, lane_count: int):
    """wp.func (law, pressure, speed, angle) -> argument of the law's table; its extremes so far are written."""
    types = lane_types(real, lane_count)
    lanes = types.lanes
    FrictionLaw, Record = friction_law_struct(real), record_struct(real, lane_count)

    @wp.func
    def friction_argument(
        law: FrictionLaw, pressure: lanes, speed: lanes, angle: lanes, record: Record, block: wp.int32
    ):
        argument = law_argument(law, pressure, speed)
        if law.argument_kind == YARN_ANGLE:
            argument = angle
        if law.argument_kind != NO_ARGUMENT:
            rows = record.rows
            low, high = widened(rows[PlyRow.low, block], rows[PlyRow.high, block], argument, pressure)
            rows[PlyRow.low, block] = low
            rows[PlyRow.high, block] = high
        return argument

    return friction_argument
