"""Tiles of samples of the distance to a mesh, and the cells among them in which they err."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import warp as wp

from ...device import launch_on_all_cores
from ...kernels.contact.fill_samples import (
    BLOCK_SIZE,
    Doubt,
    doubt_cells_kernel,
    fill_tiles_kernel,
    mark_cells_kernel,
    share_corners_kernel,
    tell_sides_kernel,
)
from ...kernels.contact.mesh_samples import TILE_CORNERS, TILE_STRIDE, SampledMesh
from ...kernels.contact.nearest_triangle import CELL_COUNT
from ..solid_triangles import SolidTriangles
from .grid import HALF_CELL, HALVES, Grid


def record_of(grid: Grid, tiles: wp.array, values: wp.array) -> SampledMesh:
    """What the kernels read, without doubted cells."""
    result = SampledMesh()
    result.values, result.tiles = values.ptr, tiles.ptr
    result.counts, result.first = wp.vec3i(*grid.tiles.shape), wp.vec3(*grid.first)
    result.spacing, result.per_spacing = grid.spacing, 1.0 / grid.spacing
    result.lower, result.upper, result.reach = wp.vec3(*grid.lower), wp.vec3(*grid.upper), grid.reach
    return result


def of_own(values: wp.array, own: slice) -> wp.array:
    """The samples of some tiles."""
    return values[int(TILE_STRIDE) * own.start : int(TILE_STRIDE) * own.stop]


def filled_values(triangles: SolidTriangles, grid: Grid, tiles: wp.array, band: float) -> wp.array:
    """Samples of all stored tiles, by the finer triangles within ``band`` [m] of the surface."""
    device, count = triangles.device, len(grid.first_voxel)
    first_voxel: wp.array = wp.array(grid.first_voxel, dtype=wp.vec3i, device=device)
    middle = grid.first_voxel[:, None] + int(BLOCK_SIZE) * (HALVES + 0.5) - 0.5
    points = triangles.surface.centre + grid.first + grid.spacing * middle.reshape(-1, 3)
    distance = triangles.distance(points, triangles.far, triangles.crossed)
    centre_distance: wp.array = wp.array(distance.reshape(-1, 8), dtype=float, device=device)
    values = wp.zeros(count * int(TILE_STRIDE), dtype=wp.float32, device=device)
    told = wp.zeros((count, int(CELL_COUNT)), dtype=wp.uint8, device=device)
    sampled, first = triangles.sampled(band), wp.vec3(*grid.first)

    def of_tiles(own: slice) -> list[Any]:
        where = [first_voxel[own], centre_distance[own], first, grid.spacing, grid.reach]
        return [sampled, *where, of_own(values, own), told[own]]

    def of_untold(own: slice) -> list[Any]:
        return [sampled, untold[own], first_voxel, tiles, told, first, grid.spacing, values]

    launch_on_all_cores(fill_tiles_kernel, (count, int(CELL_COUNT)), of_tiles, device)
    untold: wp.array = wp.array(np.flatnonzero(told.numpy() == 0), dtype=wp.int32, device=device)
    launch_on_all_cores(tell_sides_kernel, (len(untold),), of_untold, device)
    wp.launch(
        share_corners_kernel,
        dim=(count, int(TILE_CORNERS) ** 3),
        inputs=[first_voxel, tiles, grid.reach],
        outputs=[values],
        device=device,
    )
    return values


def doubt_above(spacing: float, tolerance: float, needed: float) -> Doubt:
    """Doubt cells whose samples err by more than ``tolerance`` [m], where distances may be below ``needed`` [m].

    A crease that turns the gradient by twice an angle makes samples err by h/2 sin(angle) in the middle of a cell of
    size h, where the gradient has the length cos(angle).
    """
    result = Doubt()
    result.tolerance = tolerance
    result.shortest = math.sqrt(1.0 - min(2.0 * tolerance / spacing, 1.0) ** 2)
    result.longest = 2.0 - result.shortest
    result.sampled, result.exact = needed + 2.05 * HALF_CELL * spacing, needed + HALF_CELL * spacing
    return result


def doubted_cells(
    triangles: SolidTriangles, grid: Grid, sampled: SampledMesh, values: wp.array, limits: Doubt
) -> np.ndarray:
    """Which cells of each tile are doubted, (tile_count, CELL_COUNT); they are marked in ``values``."""
    device, shape = triangles.device, (len(grid.first_voxel), int(CELL_COUNT))
    first_voxel: wp.array = wp.array(grid.first_voxel, dtype=wp.vec3i, device=device)
    doubted = wp.zeros(shape, dtype=wp.uint8, device=device)

    def of_tiles(own: slice) -> list[Any]:
        where = [sampled, of_own(values, own), first_voxel[own]]
        return [triangles.near.id, triangles.crossed, *where, limits, doubted[own]]

    launch_on_all_cores(doubt_cells_kernel, shape, of_tiles, device)
    wp.launch(mark_cells_kernel, dim=shape, inputs=[doubted], outputs=[values.view(wp.int32)], device=device)
    return doubted.numpy()
