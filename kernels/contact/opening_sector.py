"""Signed distance of a sector of a plate with an opening; see ``tool_shapes.py``."""

from typing import Any

import warp as wp

from ..lanes import fill, from_rows, larger, scale, smaller, square_root, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from .tool_shapes import ShapeKind, dome_opening_distance, number, safe_inverse


@wp.func
def sector_distance(part: Any, p: Any):
    """Distance to a sector between two half planes along z, of at most half a turn, and its normal."""
    one = fill(p[0], 1.0)
    zero = fill(p[0], 0.0)
    begin = number(part, 0) * p[0] + number(part, 1) * p[1]
    end = number(part, 2) * p[0] + number(part, 3) * p[1]
    later = where_positive(end - begin, one, zero)
    normal_x = number(part, 0) * (one - later) + number(part, 2) * later
    normal_y = number(part, 1) * (one - later) + number(part, 3) * later
    return larger(begin, end), from_rows(normal_x, normal_y, zero)


@wp.func
def opening_sector_distance(part: Any, p: Any):
    """What a plate with an opening and a sector have in common; exact where their surfaces meet at right angles."""
    plate, of_plate = dome_opening_distance(part, p)
    side, of_side = sector_distance(part, p)
    one = fill(plate, 1.0)
    zero = fill(plate, 0.0)
    high = larger(plate, zero)
    far = larger(side, zero)
    corner = square_root(high * high + far * far)
    # beyond both: the edge between them; else the surface that is further
    beyond = smaller(plate, side)
    distance = where_positive(beyond, corner, larger(plate, side))
    inverse = safe_inverse(corner)
    plate_further = where_positive(plate - side, one, zero)
    share = where_positive(beyond, high * inverse, plate_further)
    rest = where_positive(beyond, far * inverse, one - plate_further)
    return distance, scale(share, of_plate) + scale(rest, of_side)


SHAPE = ShapeKind(
    opening_sector_distance, ("radius", "half_length", "edge_radius", "begin_x", "begin_y", "end_x", "end_y")
)
