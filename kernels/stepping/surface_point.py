"""Points of the sheet's surface between its nodes, and forces on them (docs/theory.md, section 6).

The surface lies off the bilinear patch of an element's corners by the sagitta s that the directors describe, along the
interpolated director n: x(u, v) + s n with s = [(1 - u^2) x_,u . n_,u + (1 - v^2) x_,v . n_,v]/2 for -1 <= u, v <= 1.
"""

from functools import cache

import warp as wp

from ..lanes import dot, fill, lane_types, larger, scale, square_root
from ..operators import div, mul  # noqa: F401
from ..records import SCALAR, gather4, record4, store_record4, vector_of
from ..rows import CORNER_ROW_COUNT, ROWS_PER_CORNER, CornerRow, MotionRow
from .sample_data import load_struct, patch_struct, point_struct, samples_struct, weight_struct

# Shortest sum of the directors of a patch that is taken for a direction: they point all ways beyond.
SHORTEST_DIRECTOR = wp.constant(0.1)


@cache
def corner_function(real: type, lane_count: int):
    """wp.func that reads a vector of the motion of one corner of a block of elements."""
    Samples = samples_struct(real, lane_count)

    @wp.func
    def corner(samples: Samples, block: wp.int32, index: wp.int32, motion: wp.array(dtype=real), row: wp.int32):
        stride = samples.node_stride
        return vector_of(gather4(motion, samples.corner_node[index, block], row * stride, stride))

    return corner


@cache
def patch_function(real: type, lane_count: int):
    """wp.func that reads the ``Patch`` of a block of elements."""
    lanes3 = lane_types(real, lane_count).lanes3
    Samples, Patch = samples_struct(real, lane_count), patch_struct(real, lane_count)
    corner = corner_function(real, lane_count)

    @wp.func
    def from_first(
        samples: Samples, block: wp.int32, index: wp.int32, motion: wp.array(dtype=real), first: lanes3, rest: lanes3
    ):
        # differences first, then remainders: exact to their own rounding
        way = corner(samples, block, index, motion, MotionRow.position) - first
        return way + (corner(samples, block, index, motion, MotionRow.remainder) - rest)

    @wp.func
    def read_patch(samples: Samples, block: wp.int32, motion: wp.array(dtype=real)):
        patch = Patch()
        patch.origin = corner(samples, block, 0, motion, MotionRow.position)
        patch.remainder = corner(samples, block, 0, motion, MotionRow.remainder)
        patch.x2 = from_first(samples, block, 1, motion, patch.origin, patch.remainder)
        patch.x3 = from_first(samples, block, 2, motion, patch.origin, patch.remainder)
        patch.x4 = from_first(samples, block, 3, motion, patch.origin, patch.remainder)
        patch.d1 = corner(samples, block, 0, motion, MotionRow.director)
        patch.d2 = corner(samples, block, 1, motion, MotionRow.director)
        patch.d3 = corner(samples, block, 2, motion, MotionRow.director)
        patch.d4 = corner(samples, block, 3, motion, MotionRow.director)
        patch.v1 = corner(samples, block, 0, motion, MotionRow.velocity)
        patch.v2 = corner(samples, block, 1, motion, MotionRow.velocity)
        patch.v3 = corner(samples, block, 2, motion, MotionRow.velocity)
        patch.v4 = corner(samples, block, 3, motion, MotionRow.velocity)
        return patch

    return read_patch


@cache
def weight_function(real: type):
    """wp.func (place) -> ``Weight``."""
    vec4, Weight = wp.types.vector(4, real), weight_struct(real)

    @wp.func
    def weight_at(place: wp.vec2d):
        u = real(place[0])
        v = real(place[1])
        quarter = real(0.25)
        one = real(1.0)
        less_u, more_u, less_v, more_v = one - u, one + u, one - v, one + v
        weight = Weight()
        weight.share = quarter * vec4(less_u * less_v, more_u * less_v, more_u * more_v, less_u * more_v)
        weight.by_u = quarter * vec4(-less_v, less_v, more_v, -more_v)
        weight.by_v = quarter * vec4(-less_u, -more_u, more_u, less_u)
        weight.rest_u = real(0.5) * less_u * more_u
        weight.rest_v = real(0.5) * less_v * more_v
        return weight

    return weight_at


@cache
def point_function(real: type, lane_count: int):
    """wp.func (patch, weight) -> ``Point`` of the surface."""
    types = lane_types(real, lane_count)
    lanes3, vec4 = types.lanes3, types.vec4
    Patch, Point, Weight = patch_struct(real, lane_count), point_struct(real, lane_count), weight_struct(real)

    @wp.func
    def weighted(w: vec4, a: lanes3, b: lanes3, c: lanes3, d: lanes3):
        return (w[0] * a + w[1] * b) + (w[2] * c + w[3] * d)

    @wp.func
    def of_positions(w: vec4, patch: Patch):
        return (w[1] * patch.x2 + w[2] * patch.x3) + w[3] * patch.x4

    @wp.func
    def of_directors(w: vec4, patch: Patch):
        return weighted(w, patch.d1, patch.d2, patch.d3, patch.d4)

    @wp.func
    def surface_point(patch: Patch, weight: Weight):
        point = Point()
        point.x_by_u = of_positions(weight.by_u, patch)
        point.x_by_v = of_positions(weight.by_v, patch)
        point.d_by_u = of_directors(weight.by_u, patch)
        point.d_by_v = of_directors(weight.by_v, patch)
        sum = of_directors(weight.share, patch)
        length = square_root(dot(sum, sum))
        one = fill(length, 1.0)
        inverse = one / larger(length, fill(length, SHORTEST_DIRECTOR))
        sagitta = weight.rest_u * dot(point.x_by_u, point.d_by_u) + weight.rest_v * dot(point.x_by_v, point.d_by_v)
        point.normal = scale(inverse, sum)
        point.shrunk = inverse * sagitta
        point.way = of_positions(weight.share, patch) + scale(sagitta, point.normal)
        point.velocity = weighted(weight.share, patch.v1, patch.v2, patch.v3, patch.v4)
        return point

    return surface_point


@cache
def load_functions(real: type, lane_count: int):
    """Functions that add the force at a sample to a ``Load``, and that to what the elements wrote at their corners.

    The spring's force S has a potential, so it acts on all that moves the surface: with its part q = S . n along the
    normal, the corner gets share S + q/2 [(1 - u^2) share_,u d_,u + ...] and the couple
    q/2 [(1 - u^2) share_,u x_,u + ...] + share s (S - q n)/|d|. All else acts on the patch of the corners.
    """
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    Point, Weight, Load = point_struct(real, lane_count), weight_struct(real), load_struct(real, lane_count)

    @wp.func
    def at_corner(share: real, by_u: real, by_v: real, whole: lanes3, along_u: lanes3, along_v: lanes3):
        return share * whole + by_u * along_u + by_v * along_v

    @wp.func
    def add_load(load: Load, point: Point, w: Weight, force: lanes3, spring: lanes3):
        along = dot(spring, point.normal)
        across = scale(point.shrunk, spring - scale(along, point.normal))
        on_u = scale(w.rest_u * along, point.d_by_u)
        on_v = scale(w.rest_v * along, point.d_by_v)
        load.force1 = load.force1 + at_corner(w.share[0], w.by_u[0], w.by_v[0], force, on_u, on_v)
        load.force2 = load.force2 + at_corner(w.share[1], w.by_u[1], w.by_v[1], force, on_u, on_v)
        load.force3 = load.force3 + at_corner(w.share[2], w.by_u[2], w.by_v[2], force, on_u, on_v)
        load.force4 = load.force4 + at_corner(w.share[3], w.by_u[3], w.by_v[3], force, on_u, on_v)
        on_u = scale(w.rest_u * along, point.x_by_u)
        on_v = scale(w.rest_v * along, point.x_by_v)
        load.couple1 = load.couple1 + at_corner(w.share[0], w.by_u[0], w.by_v[0], across, on_u, on_v)
        load.couple2 = load.couple2 + at_corner(w.share[1], w.by_u[1], w.by_v[1], across, on_u, on_v)
        load.couple3 = load.couple3 + at_corner(w.share[2], w.by_u[2], w.by_v[2], across, on_u, on_v)
        load.couple4 = load.couple4 + at_corner(w.share[3], w.by_u[3], w.by_v[3], across, on_u, on_v)
        return load

    @wp.func
    def add_at(block: wp.int32, row: wp.int32, vector: lanes3, corner_force: wp.array2d(dtype=lanes)):
        piece = record4(corner_force, CORNER_ROW_COUNT, row, block)
        store_record4(corner_force, CORNER_ROW_COUNT, row, block, vector_of(piece) + vector, piece[SCALAR])

    @wp.func
    def store_load(block: wp.int32, load: Load, corner_force: wp.array2d(dtype=lanes)):
        add_at(block, CornerRow.force, load.force1, corner_force)
        add_at(block, CornerRow.couple, load.couple1, corner_force)
        add_at(block, ROWS_PER_CORNER + CornerRow.force, load.force2, corner_force)
        add_at(block, ROWS_PER_CORNER + CornerRow.couple, load.couple2, corner_force)
        add_at(block, 2 * ROWS_PER_CORNER + CornerRow.force, load.force3, corner_force)
        add_at(block, 2 * ROWS_PER_CORNER + CornerRow.couple, load.couple3, corner_force)
        add_at(block, 3 * ROWS_PER_CORNER + CornerRow.force, load.force4, corner_force)
        add_at(block, 3 * ROWS_PER_CORNER + CornerRow.couple, load.couple4, corner_force)

    return add_load, store_load
