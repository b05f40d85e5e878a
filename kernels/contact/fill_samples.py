"""Fill tiles with samples of a triangle mesh's distance, and doubt cells in which they err."""

import warp as wp

from .mesh_samples import DEEP_TILE, FAR_TILE, TILE_CORNERS, TILE_SIZE, TILE_STRIDE, SampledMesh, sampled_distance
from .nearest_triangle import CELL_COUNT, distance_and_side, mesh_signed_distance, winding_side

# Distance of a tile's farthest sample from its centre, in spacings: 3.5 sqrt(3), rounded up.
TILE_REACH = wp.constant(6.07)
# Blocks of half a tile's edge, and as much for these, with room for the error of simplified triangles.
BLOCK_SIZE = wp.constant(4)
BLOCK_REACH = wp.constant(2.65)
# Two points are on the same side of a surface that is further from one of them than they are apart, with as much to
# spare, in spacings: simplified triangles, by which either may be measured, lie elsewhere.
SPARE = wp.constant(0.05)
# Half the diagonal of a cell, in spacings, rounded up.
HALF_DIAGONAL = wp.constant(0.8661)
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


@wp.func
def finer(triangles: SampledTriangles, distance: float):
    """Whether the finer triangles count at a distance from the surface."""
    return triangles.near != triangles.far and distance < triangles.band


@wp.func
def same_side(distance: float, other: float, apart: float, spacing: float):
    """Whether points at these distances from the surface are surely on the same side; ``apart`` in spacings."""
    return wp.max(wp.abs(distance), wp.abs(other)) > (apart + SPARE) * spacing


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
    told: wp.array2d(dtype=wp.uint8),  # [tile, voxel]: zero where the sign is still to be told
):
    tile, voxel = wp.tid()
    at = corner_of(voxel)
    voxels = first_voxel[tile] + at
    point = first + spacing * wp.vec3(float(voxels[0]), float(voxels[1]), float(voxels[2]))
    block = wp.vec3i(at[0] / BLOCK_SIZE, at[1] / BLOCK_SIZE, at[2] / BLOCK_SIZE)
    way = at - BLOCK_SIZE * block
    apart = wp.length(wp.vec3(float(way[0]) - 1.5, float(way[1]) - 1.5, float(way[2]) - 1.5))
    centre = centre_distance[tile, 4 * block[0] + 2 * block[1] + block[2]]
    spread = BLOCK_REACH * spacing
    value = wp.float32(reach)
    side = wp.sign(centre)
    if wp.abs(centre) < reach + spread:
        crosses = wp.abs(centre) < spread  # the surface may pass through the block
        largest = wp.where(crosses, 2.0 * spread, reach)
        of_face = wp.float32(0.0)
        near = finer(triangles, 1.001 * (wp.abs(centre) + apart * spacing))
        if not near:
            value, of_face = distance_and_side(triangles.far, point, largest, triangles.crossed)
            near = finer(triangles, value)
        if near:
            value, of_face = distance_and_side(triangles.near, point, largest, triangles.crossed)
        if crosses and (of_face != 0.0 or not same_side(value, centre, apart, spacing)):
            side = of_face
    told[tile, voxel] = wp.where(side == 0.0, wp.uint8(0), wp.uint8(1))
    values[entry_of(tile, at)] = wp.where(side < 0.0, -1.0, 1.0) * wp.min(value, reach)


@wp.func
def tile_of(tiles: wp.array3d(dtype=wp.int32), voxels: wp.vec3i):
    """Number of the tile that holds a sample, counted from the first one of the box; see ``FAR_TILE``."""
    tile = wp.int32(FAR_TILE)
    x = voxels[0] / TILE_SIZE
    y = voxels[1] / TILE_SIZE
    z = voxels[2] / TILE_SIZE
    if (
        wp.min(voxels[0], wp.min(voxels[1], voxels[2])) >= 0
        and x < tiles.shape[0]
        and y < tiles.shape[1]
        and z < tiles.shape[2]
    ):
        tile = tiles[x, y, z]
    return tile


@wp.func
def within_tile(voxels: wp.vec3i):
    """Place in its tile of a sample, counted from the first one of the box."""
    return wp.vec3i(voxels[0] % TILE_SIZE, voxels[1] % TILE_SIZE, voxels[2] % TILE_SIZE)


@wp.func
def side_beside(
    voxels: wp.vec3i,
    value: float,
    spacing: float,
    tiles: wp.array3d(dtype=wp.int32),
    told: wp.array2d(dtype=wp.uint8),
    values: wp.array(dtype=float),
):
    """Side of a sample from those around it; zero if they do not tell it."""
    side = wp.float32(0.0)
    for k in range(27):
        way = wp.vec3i(k / 9 - 1, (k / 3) % 3 - 1, k % 3 - 1)
        tile = tile_of(tiles, voxels + way)
        if side == 0.0 and tile >= 0:
            at = within_tile(voxels + way)
            if told[tile, (TILE_SIZE * at[0] + at[1]) * TILE_SIZE + at[2]] != wp.uint8(0):
                other = values[entry_of(tile, at)]
                apart = wp.length(wp.vec3(float(way[0]), float(way[1]), float(way[2])))
                if same_side(value, other, apart, spacing):
                    side = wp.sign(other)
    return side


@wp.kernel(enable_backward=False)
def tell_sides_kernel(
    # In
    triangles: SampledTriangles,
    untold: wp.array(dtype=wp.int32),  # samples without a side: CELL_COUNT tile + voxel
    first_voxel: wp.array(dtype=wp.vec3i),  # of each tile, from the first one of the box
    tiles: wp.array3d(dtype=wp.int32),  # number of each tile of the box
    told: wp.array2d(dtype=wp.uint8),  # [tile, voxel]
    first: wp.vec3,  # position of the first voxel of the box [m]
    spacing: float,
    # Out
    values: wp.array(dtype=float),
):
    """Sides of samples to which an edge or a corner is nearest: the winding number costs as much as fifty searches."""
    i = wp.tid()
    tile = untold[i] / CELL_COUNT
    at = corner_of(untold[i] % CELL_COUNT)
    voxels = first_voxel[tile] + at
    value = values[entry_of(tile, at)]
    side = side_beside(voxels, value, spacing, tiles, told, values)
    if side == 0.0:
        point = first + spacing * wp.vec3(float(voxels[0]), float(voxels[1]), float(voxels[2]))
        side = winding_side(wp.where(finer(triangles, value), triangles.near, triangles.far), point, value)
    values[entry_of(tile, at)] = side * value


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
        other = tile_of(tiles, voxels)
        value = reach
        if other >= 0:
            value = values[entry_of(other, within_tile(voxels))]
        elif other == DEEP_TILE:
            value = -reach
        values[entry_of(tile, at)] = value


@wp.kernel(enable_backward=False)
def doubt_cells_kernel(
    # In
    mesh: wp.uint64,
    crossed: wp.int32,
    sampled: SampledMesh,  # where the samples are
    values: wp.array(dtype=float),  # of each tile, without doubts
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
    value, slope, corner = interpolated(values, entry_of(tile, corner_of(voxel)))
    length = slope * sampled.per_spacing
    if wp.abs(value) < limits.sampled:
        exact, side = distance_and_side(mesh, point, 4.0 * limits.sampled, crossed)
        if side == 0.0 and same_side(exact, corner, HALF_DIAGONAL, sampled.spacing):
            side = wp.sign(corner)
        if side == 0.0:
            side = winding_side(mesh, point, exact)
        exact = side * exact
        wrong = length < limits.shortest or length > limits.longest or wp.abs(exact - value) > limits.tolerance
        if wrong and wp.abs(exact) < limits.exact:
            doubt = wp.uint8(1)
    doubted[tile, voxel] = doubt


@wp.func
def interpolated(values: wp.array(dtype=float), entry: wp.int32):
    """Distance in the middle of a cell [m], the length of its gradient times the spacing, and its farthest corner's."""
    total = wp.float32(0.0)
    slope = wp.vec3(0.0, 0.0, 0.0)
    farthest = wp.float32(0.0)
    for k in range(8):
        x = k / 4
        y = (k / 2) % 2
        z = k % 2
        value = values[entry + (x * TILE_CORNERS + y) * TILE_CORNERS + z]
        total += 0.125 * value
        slope += 0.25 * value * wp.vec3(float(2 * x - 1), float(2 * y - 1), float(2 * z - 1))
        farthest = wp.where(wp.abs(value) > wp.abs(farthest), value, farthest)
    return total, wp.length(slope), farthest


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
