"""The surface of a sheet within one element, and the foot of a point on it (docs/plies.md).

The facet is the bilinear quadrilateral of its four nodes. Their normals are interpolated with a quadratic part along
each coordinate, which makes them perpendicular to the facet on the mean: on an edge n = m + q xi + b (1 - xi^2) with
b = -3/2 (a.m) a/(a.a), where a is half of the edge, m and q mean and half difference of the normals at its ends.
Normals that turn by unlike angles at both ends, as where a crease begins, would otherwise lean, and a node that slides
over the facet and back would gain energy (docs/decisions/0061). Positions and normals are shared along edges, so that
feet cover the sheet once: there are no cases for edges and corners.
"""

from functools import cache
from typing import Any

import warp as wp

from ..lane_types import CPU_LANE_COUNT, GPU_LANE_COUNT, lane_types
from ..lanes import dot, fill, lane_maximum, larger, magnitude, scale, smaller, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from ..records import gather4, vector_of
from ..rows import MotionRow

# What lies beyond an edge of a facet in place of a neighbour.
FREE_EDGE = wp.constant(-1)
SYMMETRY_EDGE = wp.constant(-2)
# Feet are sought up to this coordinate; beyond it the extrapolated facet says nothing.
FARTHEST = wp.constant(2.0)


@cache
def facets_struct(real: type):
    """Facets of one sheet; corners in the order of its elements, edges after their first corner."""

    @wp.struct
    class Facets:
        corner: wp.array(dtype=wp.int32)  # [4 facet + corner]: first entry of the node in the motion
        normal_corner: wp.array(dtype=wp.int32)  # the same in the normals
        neighbour: wp.array2d(dtype=wp.int32)  # [facet, edge]: the facet beyond, FREE_EDGE or SYMMETRY_EDGE
        warp_gradient: wp.array2d(dtype=real)  # [diagonal, facet]: gradients along the warp, GradientRow bp1 and bq1
        motion: wp.array(dtype=real)  # rows: see MotionRow
        stride: wp.int32  # entries between two rows
        normals: wp.array(dtype=real)  # unit normals of the nodes: see normals.py
        normal_stride: wp.int32
        flat: wp.array(
            dtype=real
        )  # flat coordinates of the nodes, laid out as the normals; 1 behind those on a free edge

    return Facets


@cache
def patch_struct(real: type, lane_count: int):
    """Vectors at four corners as mean + xi along1 + eta along2 + xi eta twist, one facet per lane."""
    lanes3 = lane_types(real, lane_count).lanes3

    @wp.struct
    class Patch:
        mean: lanes3
        along1: lanes3
        along2: lanes3
        twist: lanes3

    return Patch


for _types in (lane_types(wp.float32, GPU_LANE_COUNT), lane_types(wp.float32, CPU_LANE_COUNT)):

    @wp.func_native(f"""
        const int *from = table.data + corner;
        wp::vec_t<{_types.lane_count}, wp::int32> result;
        for (int i = 0; i < {_types.lane_count}; ++i)
            result[i] = from[4 * facet[i]];
        return result;
    """)
    def corner_entries(table: wp.array(dtype=wp.int32), facet: _types.indices, corner: wp.int32) -> _types.indices:
        """Entries of one corner of a facet per lane, from a contiguous table of four per facet."""


@cache
def patch_functions(real: type, lane_count: int):
    """wp.funcs that gather patches: a row of the motion as it is, positions from a point, normals, and any."""
    types, Patch, Facets = lane_types(real, lane_count), patch_struct(real, lane_count), facets_struct(real)
    indices, lanes3 = types.indices, types.lanes3

    @wp.func
    def patch_of(v0: lanes3, v1: lanes3, v2: lanes3, v3: lanes3):
        quarter = real(0.25)
        patch = Patch()
        even = v0 + v2
        odd = v1 + v3
        falling = v1 - v3
        rising = v2 - v0
        patch.mean = quarter * (even + odd)
        patch.twist = quarter * (even - odd)
        patch.along1 = quarter * (rising + falling)
        patch.along2 = quarter * (rising - falling)
        return patch

    @wp.func
    def vector_at(facets: Facets, entry: indices, row: int):
        return vector_of(gather4(facets.motion, entry, row * facets.stride, facets.stride))

    @wp.func
    def vectors(facets: Facets, facet: indices, row: int):
        return patch_of(
            vector_at(facets, corner_entries(facets.corner, facet, 0), row),
            vector_at(facets, corner_entries(facets.corner, facet, 1), row),
            vector_at(facets, corner_entries(facets.corner, facet, 2), row),
            vector_at(facets, corner_entries(facets.corner, facet, 3), row),
        )

    @wp.func
    def from_point(facets: Facets, entry: indices, position: lanes3, remainder: lanes3):
        # differences first: in single precision the noise of a sum of weighted positions is a pressure of its own
        return (vector_at(facets, entry, MotionRow.position) - position) + (
            vector_at(facets, entry, MotionRow.remainder) - remainder
        )

    @wp.func
    def positions(facets: Facets, facet: indices, position: lanes3, remainder: lanes3):
        return patch_of(
            from_point(facets, corner_entries(facets.corner, facet, 0), position, remainder),
            from_point(facets, corner_entries(facets.corner, facet, 1), position, remainder),
            from_point(facets, corner_entries(facets.corner, facet, 2), position, remainder),
            from_point(facets, corner_entries(facets.corner, facet, 3), position, remainder),
        )

    @wp.func
    def normal_at(facets: Facets, facet: indices, corner: int):
        entry = corner_entries(facets.normal_corner, facet, corner)
        return vector_of(gather4(facets.normals, entry, 0, facets.normal_stride))

    @wp.func
    def normals(facets: Facets, facet: indices):
        return patch_of(
            normal_at(facets, facet, 0), normal_at(facets, facet, 1), normal_at(facets, facet, 2),
            normal_at(facets, facet, 3),
        )  # fmt: skip

    return vectors, positions, normals, patch_of


@wp.func
def patch_at(patch: Any, xi: Any, eta: Any):
    return patch.mean + scale(xi, patch.along1 + scale(eta, patch.twist)) + scale(eta, patch.along2)


@wp.func
def patch_along1(patch: Any, eta: Any):
    """Derivative by xi."""
    return patch.along1 + scale(eta, patch.twist)


@wp.func
def patch_along2(patch: Any, xi: Any):
    """Derivative by eta."""
    return patch.along2 + scale(xi, patch.twist)


@wp.func
def corner_weight(corner: int, xi: Any, eta: Any):
    """Share of one corner in a point of the facet."""
    one = fill(xi, 1.0)
    first = one - xi
    if corner == 1 or corner == 2:
        first = one + xi
    second = one - eta
    if corner > 1:
        second = one + eta
    return first.dtype(0.25) * mul(first, second)


@wp.func
def lean1(x: Any, d: Any, eta: Any):
    """How far the mean normal of a line along xi leans along it, times half its length: linear between the edges."""
    across = fill(eta, 1.0) - eta * eta
    return dot(patch_along1(x, eta), d.mean + scale(eta, d.along2)) + across * dot(x.twist, d.along2)


@wp.func
def lean2(x: Any, d: Any, xi: Any):
    """The same of a line along eta."""
    across = fill(xi, 1.0) - xi * xi
    return dot(patch_along2(x, xi), d.mean + scale(xi, d.along1)) + across * dot(x.twist, d.along1)


@wp.func
def bend1(x: Any, d: Any, eta: Any):
    """Quadratic part of the normals along xi."""
    along = patch_along1(x, eta)
    return scale(eta.dtype(-1.5) * lean1(x, d, eta) / dot(along, along), along)


@wp.func
def bend2(x: Any, d: Any, xi: Any):
    """Quadratic part of the normals along eta."""
    along = patch_along2(x, xi)
    return scale(xi.dtype(-1.5) * lean2(x, d, xi) / dot(along, along), along)


@wp.func
def bounded(value: Any, size: Any):
    """``value`` within +-size; a NaN becomes ``size``."""
    return larger(smaller(value, size), -size)


@wp.func
def bow(along: Any):
    """1 - along^2 on the facet, and 0 beyond its edges."""
    one = fill(along, 1.0)
    within = bounded(along, one)
    return one - within * within


@wp.func
def bow_slope(along: Any):
    """Derivative of ``bow``."""
    return where_positive(bow(along), fill(along, -2.0) * along, fill(along, 0.0))


@wp.func
def normal_at(x: Any, d: Any, xi: Any, eta: Any):
    """Interpolated normal, of a length near one."""
    bent = scale(bow(xi), bend1(x, d, eta)) + scale(bow(eta), bend2(x, d, xi))
    return patch_at(d, xi, eta) + bent


@wp.func
def rise(along: Any, turn: Any, lean: Any):
    """Twice the sagitta on a line whose normals turn and lean; beyond the edges they only turn on, as on an arc."""
    one = fill(along, 1.0)
    within = bounded(along, one)
    beyond = along - within
    return (one - along * along) * turn + lean * ((one - within * within) * within - beyond - beyond)


@wp.func
def sagitta(x: Any, d: Any, xi: Any, eta: Any):
    """Height of the surface that the normals describe over the bilinear facet, along them."""
    rise1 = rise(xi, dot(patch_along1(x, eta), patch_along1(d, eta)), lean1(x, d, eta))
    rise2 = rise(eta, dot(patch_along2(x, xi), patch_along2(d, xi)), lean2(x, d, xi))
    return xi.dtype(0.5) * (rise1 + rise2)


@wp.func
def offset_along1(x: Any, d: Any, xi: Any, eta: Any, g: Any):
    """Derivative by xi of the surface at a height g, as if the bends did not vary across."""
    return patch_along1(x, eta) + scale(g, patch_along1(d, eta) + scale(bow_slope(xi), bend1(x, d, eta)))


@wp.func
def offset_along2(x: Any, d: Any, xi: Any, eta: Any, g: Any):
    """Derivative by eta, likewise."""
    return patch_along2(x, xi) + scale(g, patch_along2(d, xi) + scale(bow_slope(eta), bend2(x, d, xi)))


@wp.func
def triple(a: Any, b: Any, c: Any):
    """a . (b x c)."""
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])


@wp.func
def first_height(x: Any, d: Any, xi: Any, eta: Any):
    """Height of a point over (xi, eta), where Newton's method begins."""
    n = normal_at(x, d, xi, eta)
    return -dot(patch_at(x, xi, eta), n) / larger(dot(n, n), fill(xi, 1.0e-6))


@wp.func
def nearer_foot(x: Any, d: Any, xi: Any, eta: Any, g: Any):
    """Coordinates and height after one iteration of Newton's method: see ``find_foot``."""
    farthest = fill(xi, FARTHEST)
    n = normal_at(x, d, xi, eta)
    rest = patch_at(x, xi, eta) + scale(g, n)
    c1 = offset_along1(x, d, xi, eta, g)
    c2 = offset_along2(x, d, xi, eta, g)
    volume = triple(c1, c2, n)
    inverse = fill(volume, 1.0) / volume
    new_xi = bounded(xi - inverse * triple(rest, c2, n), farthest)
    new_eta = bounded(eta - inverse * triple(c1, rest, n), farthest)
    return new_xi, new_eta, g - inverse * triple(c1, c2, rest)


@wp.func
def find_foot(x: Any, d: Any, xi: Any, eta: Any, iterations: int):
    """Coordinates (xi, eta) and height g with x(xi, eta) + g n(xi, eta) = 0, by Newton's method.

    ``x`` is the facet as seen from the point whose foot is sought, and ``d`` the normals at its corners.
    """
    g = first_height(x, d, xi, eta)
    for _ in range(iterations):
        xi, eta, g = nearer_foot(x, d, xi, eta, g)
    return xi, eta, g


@cache
def walk_function(real: type, lane_count: int):
    """wp.func -> (facets beyond the edges that feet have passed, with feet at their centres, number of moved ones)."""
    types, Facets = lane_types(real, lane_count), facets_struct(real)
    indices, lanes = types.indices, types.lanes

    @wp.func
    def edge_passed(along: real, low: int, high: int):
        # a margin against going to and fro
        return wp.where(along > real(1.0001), high, wp.where(along < real(-1.0001), low, -1))

    @wp.func
    def walk(facets: Facets, old_facet: indices, old_xi: lanes, old_eta: lanes):
        facet = old_facet
        xi = old_xi
        eta = old_eta
        moved = wp.int32(0)
        if not lane_maximum(larger(magnitude(xi), magnitude(eta))) > real(1.0001):
            return facet, xi, eta, moved
        for i in range(lane_count):
            first = edge_passed(xi[i], 3, 1)
            second = edge_passed(eta[i], 0, 2)
            if first >= 0 or second >= 0:
                # the edge that is passed farther; the other one where there is nothing beyond it
                if wp.abs(eta[i]) > wp.abs(xi[i]):
                    other = first
                    first = second
                    second = other
                beyond = FREE_EDGE
                if first >= 0:
                    beyond = facets.neighbour[facet[i], first]
                if beyond < 0 and second >= 0:
                    beyond = facets.neighbour[facet[i], second]
                if beyond >= 0:
                    facet[i] = beyond
                    xi[i] = real(0.0)
                    eta[i] = real(0.0)
                    moved = moved + 1
        return facet, xi, eta, moved

    return walk


@cache
def inside_function(real: type, lane_count: int):
    """wp.func -> 1 in the lanes whose feet lie on their facets, or just beyond an edge that has a neighbour; else 0.

    ``farthest`` is how far they may lie beyond a free edge, as a coordinate of the facet.
    """
    types, Facets = lane_types(real, lane_count), facets_struct(real)
    indices, lanes = types.indices, types.lanes

    @wp.func
    def beside(facets: Facets, facet: int, along: real, low: int, high: int, farthest: real):
        result = real(1.0)
        size = wp.abs(along)
        # nodes of equal plies stand on each other's edges, to rounding
        if size > real(1.001):
            edge = wp.where(along > real(0.0), high, low)
            is_free = facets.neighbour[facet, edge] == FREE_EDGE
            if size > wp.where(is_free, farthest, real(1.2)):
                result = real(0.0)
        return result

    @wp.func
    def inside(facets: Facets, facet: indices, xi: lanes, eta: lanes, farthest: real):
        result = fill(xi, 1.0)
        if lane_maximum(larger(magnitude(xi), magnitude(eta))) <= real(1.001):
            return result
        for i in range(lane_count):
            first = beside(facets, facet[i], xi[i], 3, 1, farthest)
            result[i] = first * beside(facets, facet[i], eta[i], 0, 2, farthest)
        return result

    return inside
