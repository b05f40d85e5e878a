"""Triangles that may be nearest in the doubted cells of samples, and what tells the side at their edges and corners."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import warp as wp

from ...device import launch_on_all_cores
from ...kernels.contact.list_nearest import count_nearest_kernel, list_nearest_kernel
from ...kernels.contact.mesh_samples import TILE_SIZE
from ...kernels.contact.nearest_triangle import CELL_COUNT, PART_COUNT, NearestTriangles
from ..mesh_features import face_normals
from ..mesh_topology import directed_edges, edge_keys, labels
from ..solid_triangles import SolidTriangles
from .grid import Grid
from .stored import StoredArrays

# Sums of normals shorter than this tell no side.
LEAST_FACING = 1.0e-6


class Candidates(NamedTuple):
    """What the kernels read, and the arrays that it refers to."""

    record: Any
    arrays: tuple[wp.array, ...]


def nearest_candidates(
    triangles: SolidTriangles, grid: Grid, doubted: np.ndarray, largest: float, stored: StoredArrays
) -> Candidates:
    """Lists for the doubted cells.

    Args:
        triangles: those that are searched.
        grid: of the samples.
        doubted: (tile_count, CELL_COUNT), not zero in doubted cells.
        largest: distance up to which all triangles are searched [m].
        stored: may have the lists, or takes them.
    """
    device = triangles.device
    tile, cell = np.nonzero(doubted)
    own_tiles = np.unique(tile)
    place_of_tile = np.full(len(doubted), -1, dtype=np.int32)
    place_of_tile[own_tiles] = np.arange(len(own_tiles))
    number_of_cell = np.zeros((len(own_tiles), int(CELL_COUNT)), dtype=np.int32)
    number_of_cell[place_of_tile[tile], cell] = np.arange(len(tile))
    size = int(TILE_SIZE)
    voxel = grid.first_voxel[tile] + np.column_stack([cell // size**2, cell // size % size, cell % size])
    if (kept := stored.get("first", "away", "triangle")) is not None:
        first, away, triangle = kept
    else:
        first, away, triangle = _lists(triangles, grid.first + grid.spacing * voxel, grid.spacing, largest)
        stored.add(first=first, away=away, triangle=triangle)
    used, triangle = np.unique(triangle, return_inverse=True)
    vertices, faces = triangles.surface.solid_vertices - triangles.surface.centre, triangles.surface.solid_faces
    record, arrays = NearestTriangles(), []
    contents: dict[str, tuple[np.ndarray, Any]] = {
        "tile": (place_of_tile, wp.int32),
        "cell": (number_of_cell.ravel(), wp.int32),
        "first": (first, wp.int32),
        "away": (away, wp.float32),
        "triangle": (triangle, wp.int32),
        "corner": (vertices[faces[used]].reshape(-1, 3), wp.vec3),
        "facing": (facings(vertices, faces, used).reshape(-1, 3), wp.vec3),
    }
    for name, (values, dtype) in contents.items():
        array: wp.array = wp.array(values, dtype=dtype, device=device)
        arrays.append(array)
        setattr(record, name, array.ptr or 0)
    record.tile_count, record.doubted_tile_count, record.cell_count = len(doubted), len(own_tiles), len(tile)
    record.candidate_count, record.triangle_count = len(triangle), len(used)
    record.spacing, record.largest = grid.spacing, largest
    record.mesh, record.crossed = triangles.mesh.id, triangles.crossed
    return Candidates(record, tuple(arrays))


def _lists(
    triangles: SolidTriangles, corner: np.ndarray, spacing: float, largest: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First candidate of each eighth of each cell, and the end; distance [m] and number of each candidate."""
    part_count = int(PART_COUNT) * len(corner)
    if triangles.crossed or not len(corner):  # no triangle tells the side
        return np.zeros(part_count + 1, dtype=np.int32), np.empty(0, dtype=np.float32), np.empty(0, dtype=np.int32)
    device, shape = triangles.device, (len(corner), int(PART_COUNT))
    corners: wp.array = wp.array(corner, dtype=wp.vec3, device=device)
    count = wp.zeros(shape, dtype=wp.int32, device=device)
    mesh, parts = triangles.mesh.id, int(PART_COUNT)
    launch_on_all_cores(
        count_nearest_kernel, shape, lambda own: [mesh, corners[own], spacing, largest, count[own]], device
    )
    first = np.concatenate([[0], np.cumsum(count.numpy().ravel())]).astype(np.int32)
    away = wp.zeros(int(first[-1]), dtype=wp.float32, device=device)
    triangle = wp.zeros(int(first[-1]), dtype=wp.int32, device=device)
    firsts: wp.array = wp.array(first, dtype=wp.int32, device=device)

    def listed(own: slice) -> list[Any]:
        of_own = firsts[parts * own.start : parts * own.stop + 1]
        return [mesh, corners[own], spacing, largest, of_own, away, triangle]

    launch_on_all_cores(list_nearest_kernel, shape, listed, device)
    return first, away.numpy(), triangle.numpy()


def facings(vertices: np.ndarray, faces: np.ndarray, used: np.ndarray) -> np.ndarray:
    """Directions that tell the side of a point nearest to a place on a face, (k, 7, 3), of the ``used`` faces.

    Of a face its normal, of an edge the sum of the normals of its two faces, of a corner the sum of those around it,
    weighted by their angles: J. A. Baerentzen and H. Aanaes, Signed distance computation using the angle weighted
    pseudonormal, IEEE Transactions on Visualization and Computer Graphics 11 (2005) 243-253. Zero where these do not
    tell it: at edges that do not join two faces of the same sense, and at corners whose faces are no single fan.
    """
    near = np.zeros(len(vertices), dtype=bool)
    near[faces[used]] = True
    own = np.flatnonzero(near[faces].any(axis=1))  # all faces around the corners of those that are used
    part = faces[own]
    normal, _ = face_normals(vertices, part)
    edges = directed_edges(part)
    order = np.argsort(edge_keys(edges), kind="stable")
    key = edge_keys(edges)[order]
    start = np.flatnonzero(np.append(True, key[1:] != key[:-1]))
    times = np.diff(np.append(start, len(key)))
    pairs = np.column_stack([order[start[times == 2]], order[start[times == 2] + 1]])
    pairs = pairs[edges[pairs[:, 0], 0] == edges[pairs[:, 1], 1]]
    along = np.zeros((len(edges), 3))
    along[pairs] = (normal[pairs[:, 0] // 3] + normal[pairs[:, 1] // 3])[:, None]
    paired = np.zeros(len(edges), dtype=bool)
    paired[pairs] = True
    at_corner = _corner_facings(vertices, part, normal, pairs, paired)
    index = np.searchsorted(own, used)
    result = np.concatenate([normal[:, None], along.reshape(-1, 3, 3), at_corner[part]], axis=1)[index]
    length = np.linalg.norm(result, axis=2, keepdims=True)
    return np.where(length > LEAST_FACING, result / np.maximum(length, LEAST_FACING), 0.0)


def _corner_facings(
    vertices: np.ndarray, faces: np.ndarray, normal: np.ndarray, pairs: np.ndarray, paired: np.ndarray
) -> np.ndarray:
    """Sum of the normals around each vertex, weighted by angles, (n, 3); zero where they are no single fan."""
    result = np.zeros((len(vertices), 3))
    corner = vertices[faces]
    for k in range(3):
        u, v = corner[:, (k + 1) % 3] - corner[:, k], corner[:, (k + 2) % 3] - corner[:, k]
        angle = np.arctan2(np.linalg.norm(np.cross(u, v), axis=1), np.einsum("ij,ij->i", u, v))
        for c in range(3):
            result[:, c] += np.bincount(faces[:, k], weights=angle * normal[:, c], minlength=len(vertices))
    # corners of faces are linked across the edges that they share, at either end
    row = np.arange(3 * len(faces))
    following = row - row % 3 + (row + 1) % 3
    one, other = pairs[:, 0], pairs[:, 1]
    links = np.concatenate([np.column_stack([one, following[other]]), np.column_stack([following[one], other])])
    fan = labels(len(row), links)
    vertex = faces.ravel()
    several = np.zeros(len(vertices), dtype=bool)
    of_vertex = np.full(len(vertices), -1, dtype=np.int64)
    of_vertex[vertex] = fan
    several[vertex[of_vertex[vertex] != fan]] = True
    several[directed_edges(faces)[~paired].ravel()] = True
    result[several] = 0.0
    return result
