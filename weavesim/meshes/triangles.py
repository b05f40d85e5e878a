"""Split quadrilaterals and polygons into triangles."""

from __future__ import annotations

import numpy as np

# Below this share of the squared size of a cell, an area is round-off.
_ROUNDING = 1e-9


class Crossing(ValueError):
    """The outline of a polygon crosses itself; ``row`` says which."""

    def __init__(self, row: int) -> None:
        super().__init__(row)
        self.row = row


def without_repeats(polygons: np.ndarray) -> tuple[np.ndarray, list[tuple[int, np.ndarray]]]:
    """Polygons (m, k) in which neighbouring corners are the same: a mask (m,), and each with its row, shortened.

    Those with fewer than three corners left have no area, and keep two of one kind.
    """
    repeated = np.any(polygons == np.roll(polygons, 1, axis=1), axis=1)
    shorter = []
    for row in np.flatnonzero(repeated):
        polygon = polygons[row]
        polygon = polygon[polygon != np.roll(polygon, 1)]
        if len(polygon) < 3:
            polygon = polygons[row, [0, 0, 0]] if not len(polygon) else polygon[[0, 1, 1]]
        shorter.append((int(row), polygon))
    return repeated, shorter


def quad_triangles(vertices: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Two triangles of each quadrilateral (m, 4), one after the other, (2 m, 3).

    The shorter diagonal is taken, the first of equal ones; in a concave quadrilateral the one that lies inside.

    Raises:
        Crossing: neither diagonal lies inside.
    """
    p = vertices[quads]
    normal = np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1])
    size = np.square(np.ptp(p, axis=1)).sum(axis=1)
    ways = np.array([[(0, 1, 2), (0, 2, 3)], [(0, 1, 3), (1, 2, 3)]])
    inside, length, area = [], [], []
    for way, (a, b) in zip(ways, ((0, 2), (1, 3)), strict=True):
        # twice the area of both triangles, as seen along the normal of the whole
        corner = p[:, way]
        vector = np.cross(corner[:, :, 1] - corner[:, :, 0], corner[:, :, 2] - corner[:, :, 0])
        inside.append(np.all(np.einsum("ijk,ik->ij", vector, normal) > 0.0, axis=1))
        length.append(np.linalg.norm(p[:, b] - p[:, a], axis=1))
        area.append(np.linalg.norm(vector, axis=2).max(axis=1))
    crossed = ~inside[0] & ~inside[1] & (np.minimum(*area) > _ROUNDING * size)
    if np.any(crossed):
        raise Crossing(int(np.argmax(crossed)))
    second = inside[1] & (~inside[0] | (length[1] < (1.0 - _ROUNDING) * length[0]))
    return np.take_along_axis(quads, ways[second.astype(int)].reshape(-1, 6), axis=1).reshape(-1, 3)


def out_of_plane(vertices: np.ndarray, polygons: np.ndarray) -> np.ndarray:
    """Largest distance of a corner from the plane that fits it best, for each polygon (m, k), over its size, (m,)."""
    p = vertices[polygons]
    p = p - p.mean(axis=1, keepdims=True)
    spread = np.linalg.svd(p, compute_uv=True, full_matrices=False)
    distance = np.abs(np.einsum("ijk,ik->ij", p, spread.Vh[:, 2])).max(axis=1)
    return distance / np.maximum(np.linalg.norm(np.ptp(p, axis=1), axis=1), 1e-300)


def polygon_triangles(vertices: np.ndarray, polygons: np.ndarray) -> np.ndarray:
    """k - 2 triangles of each polygon (m, k), which may be concave.

    Raises:
        Crossing: an outline that crosses itself.
    """
    count = polygons.shape[1]
    steps = np.arange(1, count - 1)
    fans = np.stack([polygons[:, [0] * len(steps)], polygons[:, steps], polygons[:, steps + 1]], axis=-1)
    p = vertices[fans]
    vector = np.cross(p[:, :, 1] - p[:, :, 0], p[:, :, 2] - p[:, :, 0])
    normal = vector.sum(axis=1)
    # convex: every corner turns the same way, and all triangles from the first corner face the same way
    edge = np.roll(vertices[polygons], -1, axis=1) - vertices[polygons]
    turn = np.einsum("ijk,ik->ij", np.cross(np.roll(edge, 1, axis=1), edge), normal)
    facing = np.einsum("ijk,ik->ij", vector, normal)
    convex = np.all(facing > 0.0, axis=1) & np.all(turn >= 0.0, axis=1)
    parts = [fans[convex].reshape(-1, 3)]
    for row in np.flatnonzero(~convex):
        parts.append(_clipped(vertices, polygons[row], normal[row], int(row)))
    return np.concatenate(parts)


def _clipped(vertices: np.ndarray, polygon: np.ndarray, normal: np.ndarray, row: int) -> np.ndarray:
    """Triangles of one polygon by clipping ears in the plane that fits it best."""
    from mapbox_earcut import triangulate_float64

    p = vertices[polygon] - vertices[polygon[0]]
    size = float(np.abs(p).max())
    length = float(np.linalg.norm(normal))
    if length <= _ROUNDING * size * size:
        # it covers its plane as often one way as the other, or has no area at all
        spread = np.linalg.svd(p, compute_uv=False)
        if spread[1] > 1e-6 * spread[0]:
            raise Crossing(row)
        return polygon[np.array([(0, k, k + 1) for k in range(1, len(polygon) - 1)])]
    normal = normal / length
    axis = np.eye(3)[np.argmin(np.abs(normal))]
    first = np.cross(axis, normal)
    first /= np.linalg.norm(first)
    plane = p @ np.column_stack([first, np.cross(normal, first)])
    index = triangulate_float64(plane, np.array([len(polygon)], dtype=np.uint32)).reshape(-1, 3).astype(np.int64)
    # clipping ears never fails, but covers something else where the outline crosses itself
    corner = plane[index]
    u, v = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    twice = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    if abs(np.abs(twice).sum() - length) > 1e-6 * length:
        raise Crossing(row)
    index[twice < 0.0] = index[twice < 0.0][:, ::-1]
    return polygon[_with_all_corners(index, len(polygon), row)]


def _with_all_corners(index: np.ndarray, count: int, row: int) -> np.ndarray:
    """Triangles that use all corners: clipping ears drops those on straight lines, where neighbours may be joined."""
    kept = np.unique(index).tolist()
    if len(kept) == count:
        return index
    triangles = [tuple(triangle) for triangle in index.tolist()]
    for start, end in zip(kept, [*kept[1:], kept[0] + count], strict=True):
        between = [k % count for k in range(start, end + 1)]
        if len(between) == 2:
            continue
        for place, (a, b, c) in enumerate(triangles):
            third = {(a, b): c, (b, c): a, (c, a): b}.get((between[0], between[-1]))
            if third is not None:
                pieces = [(s, e, third) for s, e in zip(between, between[1:], strict=False)]
                triangles[place : place + 1] = pieces
                break
        else:
            raise Crossing(row)
    return np.array(triangles)
