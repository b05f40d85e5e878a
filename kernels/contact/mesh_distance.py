"""Signed distance of a triangle mesh, sampled into the tiles of a sparse volume. Single precision; negative inside."""

from typing import Any

import warp as wp

TILE_SIZE = wp.constant(8)  # voxels along each edge of a tile, fixed by the volume format
# Distance of a tile's farthest voxel from its centre, in voxels: 3.5 sqrt(3), rounded up.
TILE_REACH = wp.constant(6.07)
# Blocks of half a tile's edge, and as much for these, with room for the error of simplified triangles.
BLOCK_SIZE = wp.constant(4)
BLOCK_REACH = wp.constant(2.65)
# Nearest points whose barycentric coordinates all exceed this lie within a face, not on its edge.
FACE_INTERIOR = wp.constant(1.0e-3)


# Least cosine between a face's normal and the way to a point that is nearest to the face's interior.
FACING = wp.constant(0.9)
# A point this near to a triangle has its normal, for the way between them is rounding [m].
TOUCHING = wp.constant(1.0e-7)


@wp.struct
class SampledMesh:
    """A triangle mesh with samples of its distance; single precision, in the mesh's own frame."""

    volume: wp.uint64  # id of a wp.Volume: the samples
    mesh: wp.uint64  # id of a wp.Mesh: closed, facing outwards
    crossed: wp.int32  # whether surfaces lie inside the solid, so that the winding number alone tells the side
    doubted: wp.uint64  # id of a wp.Volume: 1 in each cell (by its lowest corner) whose triangles are searched
    searched: float  # only for distances below this [m]


@wp.struct
class SampledTriangles:
    """Triangles whose distance is sampled: finer ones near the surface, or the same twice."""

    near: wp.uint64  # id of a wp.Mesh
    far: wp.uint64  # id of a wp.Mesh of fewer triangles
    band: float  # within this distance the finer ones count [m]
    crossed: wp.int32  # as in SampledMesh


@wp.func
def nearest_on_mesh(mesh: wp.uint64, point: wp.vec3, largest: float, crossed: wp.int32):
    """Signed distance to the nearest triangle, and the outward normal; ``largest`` and zero if none is nearer.

    The side of the nearest face gives the sign. Where an edge or a corner is nearest this may be wrong, as at a sharp
    edge or a gap between two patches: there the winding number decides, which costs about twenty times more.
    """
    query = wp.mesh_query_point_no_sign(mesh, point, largest)
    distance = largest
    normal = wp.vec3(0.0, 0.0, 0.0)
    if query.result:
        away = point - wp.mesh_eval_position(mesh, query.face, query.u, query.v)
        facing = wp.mesh_eval_face_normal(mesh, query.face)
        distance = wp.length(away)
        height = wp.dot(away, facing)
        normal = facing
        if (
            crossed == 0
            and wp.min(wp.min(query.u, query.v), 1.0 - query.u - query.v) > FACE_INTERIOR
            and wp.abs(height) >= FACING * distance
        ):
            if height < 0.0:
                distance = -distance
        else:
            winding = wp.mesh_query_point_sign_winding_number(mesh, point, 1.001 * distance + 1.0e-9)
            distance = winding.sign * distance
            if wp.abs(distance) > TOUCHING:
                normal = away / distance
    return distance, normal


@wp.func
def mesh_signed_distance(mesh: wp.uint64, point: wp.vec3, largest: float, crossed: wp.int32):
    """As ``nearest_on_mesh``, without the normal."""
    distance, normal = nearest_on_mesh(mesh, point, largest, crossed)
    return distance


@wp.func
def sampled_mesh_distance(sampled: SampledMesh, point: wp.vec3):
    """Signed distance and outward normal: of the samples, or of the triangles where the samples are doubted."""
    index = wp.volume_world_to_index(sampled.volume, point)
    gradient = wp.vec3(0.0, 0.0, 0.0)
    distance = wp.volume_sample_grad_f(sampled.volume, index, wp.Volume.LINEAR, gradient)
    normal = wp.normalize(gradient)
    if wp.abs(distance) < sampled.searched:
        i = int(wp.floor(index[0]))
        j = int(wp.floor(index[1]))
        k = int(wp.floor(index[2]))
        if wp.volume_lookup_i(sampled.doubted, i, j, k) != 0:
            largest = 4.0 * sampled.searched
            exact, direction = nearest_on_mesh(sampled.mesh, point, largest, sampled.crossed)
            if wp.abs(exact) < largest:
                distance = exact
                normal = direction
    return distance, normal


@wp.func
def unsigned_distance(mesh: wp.uint64, point: wp.vec3, largest: float):
    query = wp.mesh_query_point_no_sign(mesh, point, largest)
    distance = largest
    if query.result:
        distance = wp.length(point - wp.mesh_eval_position(mesh, query.face, query.u, query.v))
    return distance


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
    value, normal = sampled_mesh_distance(sampled[0], points[i])
    distance[i] = value


@wp.kernel(enable_backward=False)
def fill_tiles_kernel(
    # In
    triangles: SampledTriangles,
    first_voxel: wp.array(dtype=wp.vec3i),  # of each tile
    centre_distance: wp.array2d(dtype=float),  # signed distance at the middle of the eight blocks of each tile [m]
    lower: wp.vec3,  # position of voxel (0, 0, 0) [m]
    spacing: float,
    reach: float,  # values are clamped to +-reach [m]
    # Out
    volume: wp.uint64,
):
    tile, voxel = wp.tid()
    x = voxel / (TILE_SIZE * TILE_SIZE)
    y = (voxel / TILE_SIZE) % TILE_SIZE
    z = voxel % TILE_SIZE
    i = first_voxel[tile][0] + x
    j = first_voxel[tile][1] + y
    k = first_voxel[tile][2] + z
    point = lower + spacing * wp.vec3(float(i), float(j), float(k))
    centre = centre_distance[tile, 4 * (x / BLOCK_SIZE) + 2 * (y / BLOCK_SIZE) + z / BLOCK_SIZE]
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
    value = wp.clamp(value, -reach, reach)
    wp.volume_store_f(volume, i, j, k, value)


@wp.kernel(enable_backward=False)
def doubt_cells_kernel(
    # In
    mesh: wp.uint64,
    crossed: wp.int32,
    volume: wp.uint64,
    first_voxel: wp.array(dtype=wp.vec3i),  # of each tile of doubted
    tolerance: float,  # of the distance [m]
    gradient_range: wp.vec2,  # of the gradient's length times the spacing [m]
    limits: wp.vec2,  # largest distance of a doubted cell's middle: as sampled, and exact [m]
    # Out
    doubted: wp.uint64,
):
    """Doubt cells in whose middle the samples' distance is wrong, or their gradient has another length than one.

    Both are where the distance bends within the cell, as at edges and between the faces of a thin wall.
    """
    tile, voxel = wp.tid()
    i = first_voxel[tile][0] + voxel / (TILE_SIZE * TILE_SIZE)
    j = first_voxel[tile][1] + (voxel / TILE_SIZE) % TILE_SIZE
    k = first_voxel[tile][2] + voxel % TILE_SIZE
    gradient = wp.vec3(0.0, 0.0, 0.0)
    middle = wp.vec3(float(i) + 0.5, float(j) + 0.5, float(k) + 0.5)
    value = wp.volume_sample_grad_f(volume, middle, wp.Volume.LINEAR, gradient)
    doubt = 0
    if wp.abs(value) < limits[0]:
        point = wp.volume_index_to_world(volume, middle)
        exact = mesh_signed_distance(mesh, point, 4.0 * limits[0], crossed)
        length = wp.length(gradient)
        wrong = length < gradient_range[0] or length > gradient_range[1] or wp.abs(exact - value) > tolerance
        if wrong and wp.abs(exact) < limits[1]:
            doubt = 1
    wp.volume_store_i(doubted, i, j, k, doubt)


@wp.func
def volume_distance(part: Any, p: Any):
    """Distance and normal of a part that is a sampled mesh, for lanes of points; outside its box a lower bound.

    One of the kinds of ``tool_shapes.py``.
    """
    lower = part.lower
    sampled = wp.array(ptr=part.volume, shape=(1,), dtype=SampledMesh)[0]
    distance = type(p[0])()
    normal = type(p)()
    for i in range(len(distance)):
        q = type(lower)(p[0, i], p[1, i], p[2, i])
        inside = type(lower)(
            wp.clamp(q[0], part.lower[0], part.upper[0]),
            wp.clamp(q[1], part.lower[1], part.upper[1]),
            wp.clamp(q[2], part.lower[2], part.upper[2]),
        )
        outside = wp.length(q - inside)
        if outside > distance.dtype(0.0):
            distance[i] = part.reach + outside
            normal[2, i] = distance.dtype(1.0)
        else:
            value, unit = sampled_mesh_distance(sampled, wp.vec3(float(q[0]), float(q[1]), float(q[2])))
            distance[i] = distance.dtype(value)
            for c in range(3):
                normal[c, i] = distance.dtype(unit[c])
    return distance, normal
