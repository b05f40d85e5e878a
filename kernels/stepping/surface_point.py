"""Points of the sheet's surface between its nodes, and forces on them (docs/theory.md, section 6).

The surface lies off the bilinear patch of an element's corners by the sagitta s that the directors describe, along the
interpolated director n: x(u, v) + s n with s = [(1 - u^2) x_,u . n_,u + (1 - v^2) x_,v . n_,v]/2 for -1 <= u, v <= 1.
"""

from functools import cache

import warp as wp

from ..lane_types import lane_types
from ..lanes import dot, fill, larger, scale, square_root
from ..operators import add, div, mul, sub  # noqa: F401
from ..records import SCALAR, gather4, scatter4, vector_of
from ..rows import ROWS_PER_CORNER, CornerRow, MotionRow
from .sample_data import load_struct, patch_struct, point_struct, samples_struct

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
    def modes(a: lanes3, b: lanes3, c: lanes3, d: lanes3):
        quarter = real(0.25)
        near = a + b
        far = d + c
        along = b - a
        across = c - d
        return quarter * (near + far), quarter * (along + across), quarter * (far - near), quarter * (across - along)

    @wp.func
    def read_patch(samples: Samples, block: wp.int32, motion: wp.array(dtype=real)):
        patch = Patch()
        patch.origin = corner(samples, block, 0, motion, MotionRow.position)
        patch.remainder = corner(samples, block, 0, motion, MotionRow.remainder)
        x, x_u, x_v, x_uv = modes(
            lanes3(),
            from_first(samples, block, 1, motion, patch.origin, patch.remainder),
            from_first(samples, block, 2, motion, patch.origin, patch.remainder),
            from_first(samples, block, 3, motion, patch.origin, patch.remainder),
        )
        d, d_u, d_v, d_uv = modes(
            corner(samples, block, 0, motion, MotionRow.director),
            corner(samples, block, 1, motion, MotionRow.director),
            corner(samples, block, 2, motion, MotionRow.director),
            corner(samples, block, 3, motion, MotionRow.director),
        )
        v, v_u, v_v, v_uv = modes(
            corner(samples, block, 0, motion, MotionRow.velocity),
            corner(samples, block, 1, motion, MotionRow.velocity),
            corner(samples, block, 2, motion, MotionRow.velocity),
            corner(samples, block, 3, motion, MotionRow.velocity),
        )
        patch.x = x
        patch.x_u = x_u
        patch.x_v = x_v
        patch.x_uv = x_uv
        patch.d = d
        patch.d_u = d_u
        patch.d_v = d_v
        patch.d_uv = d_uv
        patch.v = v
        patch.v_u = v_u
        patch.v_v = v_v
        patch.v_uv = v_uv
        return patch

    return read_patch


@cache
def point_function(real: type, lane_count: int):
    """wp.func (patch, place from -1 to 1) -> ``Point`` of the surface."""
    Patch, Point = patch_struct(real, lane_count), point_struct(real, lane_count)

    @wp.func
    def surface_point(patch: Patch, u: real, v: real):
        half, one = real(0.5), real(1.0)
        point = Point()
        point.x_by_u = patch.x_u + v * patch.x_uv
        point.x_by_v = patch.x_v + u * patch.x_uv
        point.d_by_u = patch.d_u + v * patch.d_uv
        point.d_by_v = patch.d_v + u * patch.d_uv
        sum = patch.d + (u * patch.d_u + v * point.d_by_v)
        length = square_root(dot(sum, sum))
        inverse = fill(length, 1.0) / larger(length, fill(length, SHORTEST_DIRECTOR))
        rest_u, rest_v = half * (one - u * u), half * (one - v * v)
        sagitta = rest_u * dot(point.x_by_u, point.d_by_u) + rest_v * dot(point.x_by_v, point.d_by_v)
        point.normal = scale(inverse, sum)
        point.shrunk = inverse * sagitta
        point.way = (patch.x + (u * patch.x_u + v * point.x_by_v)) + scale(sagitta, point.normal)
        point.velocity = patch.v + (u * patch.v_u + v * (patch.v_v + u * patch.v_uv))
        return point

    return surface_point


@cache
def load_functions(real: type, lane_count: int):
    """Functions that add the force at a sample to a ``Load``, and that to what the elements wrote at their corners.

    The spring's force S has a potential, so it acts on all that moves the surface: with its part q = S . n along the
    normal, the corner I gets share S + q/2 [(1 - u^2) share_,u d_,u + ...] and the couple
    q/2 [(1 - u^2) share_,u x_,u + ...] + share s (S - q n)/|d|. All else acts on the patch of the corners.
    """
    lanes3 = lane_types(real, lane_count).lanes3
    Samples, Point = samples_struct(real, lane_count), point_struct(real, lane_count)
    Load = load_struct(real, lane_count)

    @wp.func
    def add_load(load: Load, point: Point, u: real, v: real, force: lanes3, spring: lanes3):
        half, one = real(0.5), real(1.0)
        rest_u, rest_v = half * (one - u * u), half * (one - v * v)
        along = dot(spring, point.normal)
        across = scale(point.shrunk, spring - scale(along, point.normal))
        on_u = scale(rest_u * along, point.d_by_u)
        on_v = scale(rest_v * along, point.d_by_v)
        load.force = load.force + force
        load.force_u = load.force_u + (u * force + on_u)
        load.force_v = load.force_v + (v * force + on_v)
        load.force_uv = load.force_uv + ((u * v) * force + (v * on_u + u * on_v))
        on_u = scale(rest_u * along, point.x_by_u)
        on_v = scale(rest_v * along, point.x_by_v)
        load.couple = load.couple + across
        load.couple_u = load.couple_u + (u * across + on_u)
        load.couple_v = load.couple_v + (v * across + on_v)
        load.couple_uv = load.couple_uv + ((u * v) * across + (v * on_u + u * on_v))
        return load

    @wp.func
    def add_at(samples: Samples, block: wp.int32, row: wp.int32, vector: lanes3, corner_force: wp.array(dtype=real)):
        element, stride = samples.element[block], samples.corner_stride
        piece = gather4(corner_force, element, row * stride, stride)
        scatter4(corner_force, element, row * stride, stride, vector_of(piece) + vector, piece[SCALAR])

    @wp.func
    def store(
        samples: Samples,
        block: wp.int32,
        row: wp.int32,
        mean: lanes3,
        by_u: lanes3,
        by_v: lanes3,
        by_uv: lanes3,
        # Out
        corner_force: wp.array(dtype=real),
    ):
        quarter = real(0.25)
        near = quarter * (mean - by_v)
        far = quarter * (mean + by_v)
        along = quarter * (by_u - by_uv)
        across = quarter * (by_u + by_uv)
        add_at(samples, block, row, near - along, corner_force)
        add_at(samples, block, ROWS_PER_CORNER + row, near + along, corner_force)
        add_at(samples, block, 2 * ROWS_PER_CORNER + row, far + across, corner_force)
        add_at(samples, block, 3 * ROWS_PER_CORNER + row, far - across, corner_force)

    @wp.func
    def store_load(samples: Samples, block: wp.int32, load: Load, corner_force: wp.array(dtype=real)):
        force, couple = CornerRow.force, CornerRow.couple
        store(samples, block, force, load.force, load.force_u, load.force_v, load.force_uv, corner_force)
        store(samples, block, couple, load.couple, load.couple_u, load.couple_v, load.couple_uv, corner_force)

    return add_load, store_load
