"""Where the distance to a mesh is sampled: tiles of a grid that come near the surface."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from ...errors import InputError
from ...kernels.contact.fill_samples import TILE_REACH
from ...kernels.contact.mesh_samples import DEEP_TILE, FAR_TILE, TILE_SIZE
from ..mesh_tool import MeshSurface
from ..solid_triangles import SolidTriangles

# Largest number of voxels: the first for an automatic spacing, the second for a given one.
CHOSEN_VOXEL_COUNT = 6_000_000
LARGEST_VOXEL_COUNT = 150_000_000
# Half the diagonal of a cell, in spacings.
HALF_CELL = 0.5 * math.sqrt(3.0)
# Places of the eight cubes in one of twice their edge.
HALVES = np.array(list(product(range(2), repeat=3)))


@dataclass(frozen=True)
class Grid:
    """Sample locations: a box, and those of its tiles in which distances are below the reach.

    Attributes:
        lower, upper: of the box within which samples are read, (3,) [m].
        spacing, reach: [m].
        tiles: number of each tile of the box, which begins one tile below ``lower``; see ``FAR_TILE``.
        first_voxel: of each stored tile, from the first one of the box, (tile_count, 3).
        voxel_count: of all stored tiles.
    """

    lower: np.ndarray
    upper: np.ndarray
    spacing: float
    reach: float
    tiles: np.ndarray
    first_voxel: np.ndarray
    voxel_count: int

    @property
    def first(self) -> np.ndarray:
        """Position of the first voxel of the box, (3,) [m]."""
        return self.lower - int(TILE_SIZE) * self.spacing


def preferred_spacing(surface: MeshSurface, thickness: float, allowed_error: float) -> float:
    """Of the samples [m], for an error of a share of the thickness [m] of a sheet, if there is one."""
    spacing = surface.first_spacing
    if surface.spacing is None and surface.reach is None and thickness and math.isfinite(surface.fillet_radius):
        # samples of a curvature 1/r err by h^2 / 4 r: fine enough that fillets need no search
        spacing = min(spacing, math.sqrt(4.0 * surface.fillet_radius * allowed_error * thickness))
    return spacing


def chosen_grid(triangles: SolidTriangles, spacing: float, thickest: float) -> Grid:
    """The grid of this spacing [m], or the finest one within the voxel limit, for sheets up to ``thickest`` [m].

    Raises:
        InputError: a spacing or a reach that was given needs too many samples.
    """
    surface, name = triangles.surface, triangles.surface.name
    while True:
        grid = _grid(triangles, spacing, thickest)
        if grid.voxel_count <= (CHOSEN_VOXEL_COUNT if surface.spacing is None else LARGEST_VOXEL_COUNT):
            return grid
        if surface.spacing is not None:
            raise InputError(
                f"{name}: a spacing of {spacing} m needs {grid.voxel_count} samples, above {LARGEST_VOXEL_COUNT}; "
                f"give at least {spacing * (grid.voxel_count / LARGEST_VOXEL_COUNT) ** 0.5:.2g} m, or a smaller reach."
            )
        spacing *= 1.02 * (grid.voxel_count / CHOSEN_VOXEL_COUNT) ** (1.0 / 3.0)
        if surface.reach is not None and spacing > 0.5 * surface.reach:
            raise InputError(
                f"{name}: a reach of {surface.reach} m needs too many samples at a spacing that resolves it; "
                "leave reach out, or give a spacing too."
            )


def _grid(triangles: SolidTriangles, spacing: float, thickest: float) -> Grid:
    """The grid for one spacing; without tiles if those near the surface are too many to compute.

    Large blocks of tiles are halved again and again where they come near the surface.
    """
    surface, size = triangles.surface, int(TILE_SIZE)
    reach = 6.0 * spacing if surface.reach is None else surface.reach
    if surface.reach is None and reach < thickest:  # a small tool
        reach = thickest + 3.0 * spacing
    vertices = surface.vertices - surface.centre
    lower, upper = vertices.min(axis=0) - reach, vertices.max(axis=0) + reach
    # one voxel beyond the box on every side
    counts = np.floor((upper - lower) / spacing / size).astype(int) + 2
    level = max(0, math.ceil(math.log2(max(counts.max() / 16, 1))))
    index = np.stack(np.meshgrid(*(np.arange(-(-n // 2**level)) for n in counts), indexing="ij"), axis=-1)
    index = index.reshape(-1, 3)
    deep: list[tuple[int, np.ndarray]] = []
    while True:
        width = size * 2**level
        # as the distance from a tile's middle to its farthest voxel, rounded up
        spread = float(TILE_REACH) + 0.5 * math.sqrt(3.0) * (width - size)
        first = width * index - size
        centre = surface.centre + lower + spacing * (first + 0.5 * (width - 1))
        distance = triangles.distance(centre, triangles.far, triangles.crossed)
        near = np.abs(distance) < reach + spread * spacing
        deep.append((level, index[~near & (distance < 0.0)]))
        index = index[near]
        if level == 0 or len(index) * size**3 > LARGEST_VOXEL_COUNT:
            break
        level -= 1
        index = (2 * index[:, None] + HALVES).reshape(-1, 3)
        index = index[np.all(index < counts, axis=1)]
    if level:
        return Grid(lower, upper, spacing, reach, np.empty(0), np.empty((0, 3)), len(index) * (size * 2**level) ** 3)
    tiles = np.full(counts, int(FAR_TILE), dtype=np.int32)
    for of_level, blocks in deep:
        for i, j, k in np.ndindex(*(3 * (2**of_level,))):
            at = 2**of_level * blocks + (i, j, k)
            tiles[tuple(at[np.all(at < counts, axis=1)].T)] = int(DEEP_TILE)
    tiles[tuple(index.T)] = np.arange(len(index))
    return Grid(lower, upper, spacing, reach, tiles, size * index, len(index) * size**3)
