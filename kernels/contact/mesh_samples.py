"""Signed distance of a triangle mesh from samples in sparse tiles, for lanes of points. Negative inside.

A stored tile holds the samples of its cells' corners, so that a cell is read from one tile whatever lies beside it.
The last bit of the sample at a cell's lowest corner tells whether the cell is doubted: there the nearest triangle
counts (nearest_triangle.py).
"""

from typing import Any

import warp as wp

from ..lane_types import ALL_LANE_TYPES
from ..lanes import fill, larger, where_positive
from ..records import SCALAR, vector_of
from .nearest_triangle import NearestTriangles, nearest_in_cell

TILE_SIZE = wp.constant(8)  # cells along each edge of a tile
# Samples along each edge of a tile, and numbers from one tile to the next: whole lines of the cache.
TILE_CORNERS = wp.constant(9)
TILE_STRIDE = wp.constant(736)
# Tiles that are not stored: further outside, or deeper inside, than the reach.
FAR_TILE = wp.constant(-1)
DEEP_TILE = wp.constant(-2)


@wp.struct
class SampledMesh:
    """A triangle mesh with samples of its distance; single precision, about the mesh's own centre."""

    values: wp.uint64  # address of the samples, float32, (tile, TILE_STRIDE) [m]
    tiles: wp.uint64  # address of the number of each tile of the box, int32, z fastest
    counts: wp.vec3i  # tiles along each axis
    first: wp.vec3  # position of the first sample of the first tile [m]
    spacing: float  # [m]
    per_spacing: float  # its inverse [1/m]
    lower: wp.vec3  # box within which samples are read [m]
    upper: wp.vec3
    reach: float  # samples are truncated to plus and minus this [m]
    searched: float  # triangles are searched only for distances below this [m]
    nearest: NearestTriangles


def _find_cells() -> str:
    """C++ of the cell of each point: ``tile``, ``place`` of its lowest corner, ``part`` of its edges, ``beyond``.

    NaN in a coordinate stays within the box, and makes ``beyond`` NaN.
    """
    return f"""
        const int *tiles = reinterpret_cast<const int *>(sampled.tiles);
        float part[3][N], beyond[N];
        int place[N], tile[N];
        for (int i = 0; i < N; ++i) {{
            int cell = 0, corner = 0;
            float square = 0.0f;
            for (int c = 0; c < 3; ++c) {{
                const float q = static_cast<float>(points.data[c][i]), low = sampled.lower[c], high = sampled.upper[c];
                const float inside = q > low ? (q < high ? q : high) : low;
                square += (q - inside) * (q - inside);
                const float along = (inside - sampled.first[c]) * sampled.per_spacing;
                const int k = static_cast<int>(along);
                part[c][i] = along - static_cast<float>(k);
                cell = cell * sampled.counts[c] + k / {int(TILE_SIZE)};
                corner = corner * {int(TILE_CORNERS)} + k % {int(TILE_SIZE)};
            }}
            beyond[i] = square;
            place[i] = corner;
            tile[i] = cell;
        }}
        for (int i = 0; i < N; ++i) {{
            tile[i] = tiles[tile[i]];
            place[i] += (tile[i] > 0 ? tile[i] : 0) * {int(TILE_STRIDE)};
        }}
    """


def _interpolate() -> str:
    """C++ of what the samples at ``place`` say: ``distance``, its gradient, and the ``lowest`` corner's sample."""
    return f"""
            const float *v = values + place[i];
            constexpr int y = {int(TILE_CORNERS)}, x = y * y;
            const float fx = part[0][i], fy = part[1][i], fz = part[2][i], lowest = v[0];
            const float d00 = v[1] - lowest, d01 = v[y + 1] - v[y], d10 = v[x + 1] - v[x];
            const float d11 = v[x + y + 1] - v[x + y];
            const float a00 = lowest + fz * d00, a01 = v[y] + fz * d01, a10 = v[x] + fz * d10;
            const float a11 = v[x + y] + fz * d11;
            const float e0 = a01 - a00, e1 = a11 - a10, b0 = a00 + fy * e0, b1 = a10 + fy * e1;
            const float c0 = d00 + fy * (d01 - d00), c1 = d10 + fy * (d11 - d10);
            const float gx = b1 - b0, gy = e0 + fx * (e1 - e0), gz = c0 + fx * (c1 - c0);
            float distance = b0 + fx * gx;
    """


def _read(lane_count: int, scalar: str) -> str:
    """C++ of ``read_samples``; see there."""
    return f"""
        constexpr int N = {lane_count};
        const float *values = reinterpret_cast<const float *>(sampled.values);
        wp::mat_t<4, N, wp::{scalar}> result;
        {_find_cells()}
        for (int i = 0; i < N; ++i) {{
            {_interpolate()}
            const float square = gx * gx + gy * gy + gz * gz;
            const bool stored = tile[i] >= 0, outside = !(beyond[i] <= 0.0f);
            const float scale = stored && square > 0.0f && !outside ? 1.0f / sqrtf(square) : 0.0f;
            distance = stored ? distance : (tile[i] == {int(DEEP_TILE)} ? -sampled.reach : sampled.reach);
            distance = outside ? sampled.reach + sqrtf(beyond[i]) : distance;
            union {{ float number; int bits; }} found, mark;
            found.number = distance, mark.number = lowest;
            const bool near = distance < sampled.searched && distance > -sampled.searched;
            found.bits = (found.bits & ~1) | (stored && near ? mark.bits & 1 : 0);
            result.data[0][i] = gx * scale;
            result.data[1][i] = gy * scale;
            result.data[2][i] = outside ? 1.0f : gz * scale;
            result.data[3][i] = found.number;
        }}
        return result;
    """


for _types in ALL_LANE_TYPES:

    @wp.func_native(_read(_types.lane_count, _types.real.__name__))
    def read_samples(sampled: SampledMesh, points: _types.lanes3) -> _types.lanes4:
        """Rows: the normal, and the distance, whose last bit is set where its cell is doubted.

        Outside the box the distance is a lower bound. Where samples are truncated, or far, there is no normal.
        """

    @wp.func_native(f"""
        int result = 0;
        for (int i = 0; i < {_types.lane_count}; ++i) {{
            union {{ float number; int bits; }} found;
            found.number = static_cast<float>(distance[i]);
            result |= (found.bits & 1) << i;
        }}
        return result;
    """)
    def doubted_lanes(distance: _types.lanes) -> wp.int32:
        """A bit for each lane whose distance has its last bit set in single precision."""


@wp.func
def tile_at(sampled: SampledMesh, cell: wp.vec3i):
    """Number of the tile that holds a cell."""
    counts = sampled.counts
    tiles = wp.array(ptr=sampled.tiles, shape=(counts[0] * counts[1] * counts[2],), dtype=wp.int32)
    x = cell[0] / TILE_SIZE
    y = cell[1] / TILE_SIZE
    z = cell[2] / TILE_SIZE
    return tiles[(x * counts[1] + y) * counts[2] + z]


@wp.func
def nearest_at(sampled: SampledMesh, point: wp.vec3):
    """Signed distance and outward normal of a point in a doubted cell."""
    along = (point - sampled.first) * sampled.per_spacing
    cell = wp.vec3i(int(along[0]), int(along[1]), int(along[2]))
    return nearest_in_cell(sampled.nearest, tile_at(sampled, cell), cell, point, along)


@wp.func
def sampled_distance(sampled: SampledMesh, p: Any):
    """Distances and normals of points as rows of lanes."""
    read = read_samples(sampled, p)
    distance = read[SCALAR]
    normal = vector_of(read)
    doubted = doubted_lanes(distance)
    i = wp.int32(0)
    while doubted != 0:
        # a loop over all lanes would be unrolled, and its code too large to be part of the caller's
        if doubted & 1 != 0:
            q = wp.vec3(float(p[0, i]), float(p[1, i]), float(p[2, i]))
            value, unit = nearest_at(sampled, q)
            if wp.abs(value) < sampled.nearest.largest:
                distance[i] = distance.dtype(value)
                for c in range(3):
                    normal[c, i] = distance.dtype(unit[c])
        doubted = doubted >> 1
        i += 1
    return distance, normal


@wp.func
def volume_distance(part: Any, p: Any):
    """Distance and normal of a part that is a sampled mesh, for lanes of points; outside its box a lower bound.

    One of the kinds of ``tool_shapes.py``.
    """
    sampled = wp.array(ptr=part.volume, shape=(1,), dtype=SampledMesh)[0]
    return sampled_distance(sampled, p)


@wp.func
def sampled_clearance(reach: Any, checked: Any, error: Any, largest_error: Any, distance: Any):
    """Lower bound of the distance, from a ``distance`` of samples, that changes by at most the way of a point.

    Up to ``checked`` samples err by up to ``error``, further away by up to ``largest_error``. Beyond the reach a point
    is outside the box, within which a body may begin, as that of an open sheet does.
    """
    far = larger(distance - fill(distance, largest_error), fill(distance, checked - error))
    clearance = where_positive(fill(distance, checked) - distance, distance - fill(distance, error), far)
    outside = distance - fill(distance, distance.dtype(1.000001) * reach)
    return where_positive(outside, outside, clearance)
