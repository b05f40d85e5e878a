"""Signed distances of the analytic shapes that tools are made of."""

from functools import cache
from typing import Any

import warp as wp

from ..lanes import (  # noqa: F401 - operators of lanes
    div,
    fill,
    larger,
    magnitude,
    mul,
    smaller,
    spread,
    square_root,
    where_positive,
)

PLANE = wp.constant(0)  # solid z < 0
SPHERE = wp.constant(1)  # radius
CAPSULE = wp.constant(2)  # radius, half_length along x
TORUS = wp.constant(3)  # tube radius, major radius in half_length, around z
DOME_PUNCH = wp.constant(4)  # lower half of a capsule along x, extruded to z = +infinity
DOME_OPENING = wp.constant(5)  # solid z < 0 with an opening: radius, half_length, edge_radius
VOLUME = wp.constant(6)  # sampled distance
DOME_CAVITY = wp.constant(7)  # solid z < 0 with a hollow, the lower half of a capsule along x: radius, half_length
ALL_KINDS = tuple(range(8))


@cache
def part_struct(real: type):
    """One part of a tool: kind, frame and dimensions [m]."""
    vec3 = wp.types.vector(3, real)

    @wp.struct
    class ToolPart:
        kind: wp.int32
        origin: vec3
        rotation: wp.types.matrix((3, 3), real)  # columns: the part's axes in the world
        radius: real
        half_length: real
        edge_radius: real
        volume: wp.uint64  # id of a wp.Volume in the part's frame
        lower: vec3  # box of the volume; outside it the distance is at least that to the box
        upper: vec3
        reach: real  # value used outside the volume [m]

    return ToolPart


@wp.func
def stadium_profile(x: Any, y: Any, half_length: Any):
    """Distance to a segment along x in the plan view, and the two components of its vector."""
    zero = fill(x, 0.0)
    over = larger(magnitude(x) - spread(x, half_length), zero)
    along = where_positive(x, over, -over)
    return square_root(along * along + y * y), along, y


@wp.func
def safe_inverse(length: Any):
    tiny = fill(length, 1.0e-12)
    return fill(length, 1.0) / larger(length, tiny)


@wp.func
def dome_opening_distance(x: Any, y: Any, z: Any, radius: Any, half_length: Any, edge_radius: Any):
    """Plate z < 0 with a stadium-shaped opening whose upper edge is rounded: distance and normal components."""
    zero = fill(x, 0.0)
    one = fill(x, 1.0)
    out, along, across = stadium_profile(x, y, half_length)
    inverse_out = safe_inverse(out)
    edge = spread(x, edge_radius)
    # coordinates from the centre of the edge circle: a < 0 over the opening, b > 0 above
    a = out - spread(x, radius + edge_radius)
    b = z + edge
    wall = smaller(a, zero)
    top = larger(b, zero)
    corner = square_root(wall * wall + top * top)
    # in the corner quadrant the rounded edge; elsewhere inside the solid the nearer of wall and top
    rounded = corner - edge
    inner = larger(-a, b) - edge
    distance = where_positive(corner, rounded, inner)
    inverse_corner = safe_inverse(corner)
    wall_nearer = where_positive(-a - b, one, zero)
    normal_out = where_positive(corner, wall * inverse_corner, -wall_nearer)
    normal_up = where_positive(corner, top * inverse_corner, one - wall_nearer)
    return distance, normal_out * along * inverse_out, normal_out * across * inverse_out, normal_up


@wp.func
def dome_cavity_distance(x: Any, y: Any, z: Any, radius: Any, half_length: Any):
    """Block z < 0 with a hollow, the lower half of a capsule along x: distance and normal components."""
    zero = fill(x, 0.0)
    one = fill(x, 1.0)
    out, along, across = stadium_profile(x, y, half_length)
    inverse_out = safe_inverse(out)
    # below the top: the hollow, or the top itself where that is nearer
    deep = square_root(out * out + z * z)
    inverse_deep = safe_inverse(deep)
    hollow = spread(x, radius) - deep
    top_nearer = z - hollow
    # above it: the rim, or the top beside it
    wall = larger(spread(x, radius) - out, zero)
    high = square_root(wall * wall + z * z)
    inverse_high = safe_inverse(high)
    distance = where_positive(z, high, larger(hollow, z))
    normal_out = where_positive(
        z, -(wall * inverse_high) * inverse_out, where_positive(top_nearer, zero, -inverse_deep)
    )
    normal_up = where_positive(z, z * inverse_high, where_positive(top_nearer, one, -(z * inverse_deep)))
    return distance, normal_out * along, normal_out * across, normal_up
