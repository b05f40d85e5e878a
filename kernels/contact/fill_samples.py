"""Fill tiles with samples of a triangle mesh's distance, and doubt cells in which they err."""

import warp as wp

from .mesh_samples import DEEP_TILE, TILE_CORNERS, TILE_SIZE, TILE_STRIDE, SampledMesh, sampled_distance
from .nearest_triangle import mesh_signed_distance, unsigned_distance

# Distance of a tile's farthest sample from its centre, in spacings: 3.5 sqrt(3), rounded up.
TILE_REACH = wp.constant(6.07)
# Blocks of half a tile's edge, and as much for these, with room for the error of simplified triangles.
BLOCK_SIZE = wp.constant(4)
BLOCK_REACH = wp.constant(2.65)
# A point in one lane.
_matrix = wp.types.matrix((3, 1), wp.float32)


@wp.struct
class SampledTriangles:
    """Triangles whose distance is sampled: finer ones near the surface, or the same twice."""

    near: wp.uint64  # id of a wp.Mesh
    far: wp.uint64  # id of a wp.Mesh of fewer triangles
    band: float  # within this distance the finer ones count [m]
    crossed: wp.int32  # as in NearestTriangles


@wp.struct
class Doubt:
    """When a cell is doubted."""

    tolerance: float  # of the distance [m]
    shortest: float  # length of the gradient; infinitesimal bends shorten it
    longest: float
    sampled: float  # largest distance of a doubted cell's middle, as sampled [m]
    exact: float  # and exact [m]


@wp.kernel(enable_backward=False)
def mesh_distance_kernel(
    # In
    mesh: wp.uint64,
    points: wp.array(dtype=wp.vec3),
    largest: float,  # [m]
    crossed: wp.int32,
    # Out
    distance: wp.array(dtype=float),
):
    i = wp.tid()
    distance[i] = mesh_signed_distance(mesh, points[i], largest, crossed)


@wp.kernel(enable_backward=False)
def sampled_distance_kernel(
    # In
    sampled: wp.array(dtype=SampledMesh),  # (1,)
    points: wp.array(dtype=wp.vec3),
    # Out
    distance: wp.array(dtype=float),
):
    i = wp.tid()
    point = _matrix()
    for c in range(3):
        point[c, 0] = points[i][c]
    value, normal = sampled_distance(sampled[0], point)
    distance[i] = value[0]


@wp.func
def corner_of(voxel: wp.int32):
    """Place in a tile of one of its own samples."""
    return wp.vec3i(voxel / (TILE_SIZE * TILE_SIZE), (voxel / TILE_SIZE) % TILE_SIZE, voxel % TILE_SIZE)


@wp.func
def entry_of(tile: wp.int32, corner: wp.vec3i):
    """Entry of a sample."""
    return tile * TILE_STRIDE + (corner[0] * TILE_CORNERS + corner[1]) * TILE_CORNERS + corner[2]


@wp.kernel(enable_backward=False)
def fill_tiles_kernel(
    # In
    triangles: SampledTriangles,
    first_voxel: wp.array(dtype=wp.vec3i),  # of each tile, from the first one of the box
    centre_distance: wp.array2d(dtype=float),  # signed distance at the middle of the eight blocks of each tile [m]
    first: wp.vec3,  # position of the first voxel of the box [m]
    spacing: float,
    reach: float,  # values are clamped to +-reach [m]
    # Out
    values: wp.array(dtype=float),
):
    tile, voxel = wp.tid()
    at = corner_of(voxel)
    voxels = first_voxel[tile] + at
    point = first + spacing * wp.vec3(float(voxels[0]), float(voxels[1]), float(voxels[2]))
    centre = centre_distance[tile, 4 * (at[0] / BLOCK_SIZE) + 2 * (at[1] / BLOCK_SIZE) + at[2] / BLOCK_SIZE]
    spread = BLOCK_REACH * spacing
    value = wp.sign(centre) * reach
    if wp.abs(centre) < spread:  # the surface may pass through the block
        value = mesh_signed_distance(triangles.far, point, 2.0 * spread, triangles.crossed)
        if wp.abs(value) < triangles.band and triangles.near != triangles.far:
            value = mesh_signed_distance(triangles.near, point, 2.0 * spread, triangles.crossed)
    elif wp.abs(centre) < reach + spread:  # the sign is that of the centre
        value = unsigned_distance(triangles.far, point, reach)
        if value < triangles.band and triangles.near != triangles.far:
            value = unsigned_distance(triangles.near, point, reach)
        value = wp.sign(centre) * value
    values[entry_of(tile, at)] = wp.clamp(value, -reach, reach)


@wp.kernel(enable_backward=False)
def share_corners_kernel(
    # In
    first_voxel: wp.array(dtype=wp.vec3i),  # of each tile, from the first one of the box
    tiles: wp.array3d(dtype=wp.int32),  # number of each tile of the box
    reach: float,
    # Out
    values: wp.array(dtype=float),
):
    """Copy to each tile the samples of the tiles beside it that are corners of its cells."""
    tile, corner = wp.tid()
    square = TILE_CORNERS * TILE_CORNERS
    at = wp.vec3i(corner / square, (corner / TILE_CORNERS) % TILE_CORNERS, corner % TILE_CORNERS)
    if at[0] == TILE_SIZE or at[1] == TILE_SIZE or at[2] == TILE_SIZE:
        voxels = first_voxel[tile] + at
        x = voxels[0] / TILE_SIZE
        y = voxels[1] / TILE_SIZE
        z = voxels[2] / TILE_SIZE
        value = reach
        if x < tiles.shape[0] and y < tiles.shape[1] and z < tiles.shape[2]:
            other = tiles[x, y, z]
            if other >= 0:
                value = values[entry_of(other, wp.vec3i(at[0] % TILE_SIZE, at[1] % TILE_SIZE, at[2] % TILE_SIZE))]
            elif other == DEEP_TILE:
                value = -reach
        values[entry_of(tile, at)] = value


@wp.kernel(enable_backward=False)
def doubt_cells_kernel(
    # In
    mesh: wp.uint64,
    crossed: wp.int32,
    sampled: SampledMesh,  # without doubts
    first_voxel: wp.array(dtype=wp.vec3i),  # of each tile, from the first one of the box
    limits: Doubt,
    # Out
    doubted: wp.array2d(dtype=wp.uint8),  # [tile, cell]
):
    """Doubt cells in whose middle the samples' distance is wrong, or their gradient has another length than one.

    Both are where the distance bends within the cell, as at edges and between the faces of a thin wall.
    """
    tile, voxel = wp.tid()
    at = first_voxel[tile] + corner_of(voxel)
    middle = wp.vec3(float(at[0]) + 0.5, float(at[1]) + 0.5, float(at[2]) + 0.5)
    point = sampled.first + sampled.spacing * middle
    doubt = wp.uint8(0)
    value, length = value_and_slope(sampled, entry_of(tile, corner_of(voxel)))
    if wp.abs(value) < limits.sampled:
        exact = mesh_signed_distance(mesh, point, 4.0 * limits.sampled, crossed)
        wrong = length < limits.shortest or length > limits.longest or wp.abs(exact - value) > limits.tolerance
        if wrong and wp.abs(exact) < limits.exact:
            doubt = wp.uint8(1)
    doubted[tile, voxel] = doubt


@wp.func
def value_and_slope(sampled: SampledMesh, entry: wp.int32):
    """Interpolated distance in the middle of a cell [m], and the length of its gradient."""
    values = wp.array(ptr=sampled.values, shape=(entry + TILE_STRIDE,), dtype=wp.float32)
    total = wp.float32(0.0)
    slope = wp.vec3(0.0, 0.0, 0.0)
    for k in range(8):
        x = k / 4
        y = (k / 2) % 2
        z = k % 2
        value = values[entry + (x * TILE_CORNERS + y) * TILE_CORNERS + z]
        total += 0.125 * value
        slope += 0.25 * value * wp.vec3(float(2 * x - 1), float(2 * y - 1), float(2 * z - 1))
    return total, wp.length(slope) * sampled.per_spacing


@wp.kernel(enable_backward=False)
def mark_cells_kernel(
    # In
    doubted: wp.array2d(dtype=wp.uint8),  # [tile, cell]
    # Out
    values: wp.array(dtype=wp.int32),  # the bits of the samples
):
    """Mark the lowest corners of doubted cells by their last bit."""
    tile, voxel = wp.tid()
    entry = entry_of(tile, corner_of(voxel))
    values[entry] = (values[entry] & -2) | wp.int32(doubted[tile, voxel])
