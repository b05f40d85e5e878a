"""Which tiles of a grid are stored, and what the others say."""

import numpy as np

from tests.support.solids import ball
from weavesim.kernels.contact.mesh_samples import DEEP_TILE, FAR_TILE
from weavesim.tools.mesh_tool import MeshSurface
from weavesim.tools.samples.grid import chosen_grid
from weavesim.tools.sampling import exact_distance
from weavesim.tools.solid_triangles import SolidTriangles


def test_tiles_are_stored_near_the_surface_and_the_others_tell_the_side():
    surface = MeshSurface(*ball(0.05))
    grid = chosen_grid(SolidTriangles(surface, "cpu"), 0.0008, 0.0)
    index = np.stack(np.meshgrid(*(np.arange(n) for n in grid.tiles.shape), indexing="ij"), axis=-1)
    corner = (grid.first + grid.spacing * 8 * index).reshape(-1, 1, 3)
    cube = np.array([[x, y, z] for x in (0, 7) for y in (0, 7) for z in (0, 7)]) * grid.spacing
    distance = exact_distance(surface, (corner + cube).reshape(-1, 3)).reshape(-1, 8)
    tile = grid.tiles.ravel()
    # a tile with a corner within the reach is stored
    assert np.all(tile[np.abs(distance).min(axis=1) < grid.reach] >= 0)
    assert np.all(distance[tile == int(FAR_TILE)] > 0.0) and np.all(distance[tile == int(DEEP_TILE)] < 0.0)
    assert np.count_nonzero(tile == int(DEEP_TILE)) > 100
    stored = tile >= 0
    assert sorted(tile[stored]) == list(range(np.count_nonzero(stored)))
    np.testing.assert_array_equal(grid.first_voxel[tile[stored]], 8 * index.reshape(-1, 3)[stored])
    assert grid.voxel_count == 512 * np.count_nonzero(stored)
