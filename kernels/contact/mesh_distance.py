"""Signed distance of a triangle mesh, sampled into the tiles of a sparse volume. Single precision; negative inside."""

from typing import Any

import warp as wp

TILE_SIZE = wp.constant(8)  # voxels along each edge of a tile, fixed by the volume format
# Distance of a tile's farthest voxel from its centre, in voxels: 3.5 sqrt(3), rounded up.
TILE_REACH = wp.constant(6.07)
# Nearest points whose barycentric coordinates all exceed this lie within a face, not on its edge.
FACE_INTERIOR = wp.constant(1.0e-3)


@wp.func
def mesh_signed_distance(mesh: wp.uint64, point: wp.vec3, largest: float):
    """Distance to the nearest triangle of a closed mesh facing outwards; ``largest`` beyond that, which is outside.

    The side of the nearest face gives the sign. Where an edge or a corner is nearest this may be wrong, as at a sharp
    edge or a gap between two patches: there the winding number decides, which costs about twenty times more.
    """
    query = wp.mesh_query_point_no_sign(mesh, point, largest)
    distance = largest
    if query.result:
        away = point - wp.mesh_eval_position(mesh, query.face, query.u, query.v)
        distance = wp.length(away)
        if wp.min(wp.min(query.u, query.v), 1.0 - query.u - query.v) > FACE_INTERIOR:
            if wp.dot(away, wp.mesh_eval_face_normal(mesh, query.face)) < 0.0:
                distance = -distance
        else:
            winding = wp.mesh_query_point_sign_winding_number(mesh, point, 1.001 * distance + 1.0e-9)
            distance = winding.sign * distance
    return distance


@wp.kernel(enable_backward=False)
def mesh_distance_kernel(
    # In
    mesh: wp.uint64,
    points: wp.array(dtype=wp.vec3),
    largest: float,  # [m]
    # Out
    distance: wp.array(dtype=float),
):
    i = wp.tid()
    distance[i] = mesh_signed_distance(mesh, points[i], largest)


@wp.kernel(enable_backward=False)
def volume_distance_kernel(
    # In
    volume: wp.uint64,
    points: wp.array(dtype=wp.vec3),
    # Out
    distance: wp.array(dtype=float),
):
    i = wp.tid()
    distance[i] = wp.volume_sample_f(volume, wp.volume_world_to_index(volume, points[i]), wp.Volume.LINEAR)


@wp.kernel(enable_backward=False)
def fill_tiles_kernel(
    # In
    mesh: wp.uint64,
    first_voxel: wp.array(dtype=wp.vec3i),  # of each tile
    centre_distance: wp.array(dtype=float),  # signed distance at the middle of each tile [m]
    lower: wp.vec3,  # position of voxel (0, 0, 0) [m]
    spacing: float,
    reach: float,  # values are clamped to +-reach [m]
    # Out
    volume: wp.uint64,
):
    tile, voxel = wp.tid()
    i = first_voxel[tile][0] + voxel / (TILE_SIZE * TILE_SIZE)
    j = first_voxel[tile][1] + (voxel / TILE_SIZE) % TILE_SIZE
    k = first_voxel[tile][2] + voxel % TILE_SIZE
    point = lower + spacing * wp.vec3(float(i), float(j), float(k))
    centre = centre_distance[tile]
    spread = TILE_REACH * spacing
    value = wp.sign(centre) * reach
    if wp.abs(centre) < spread:  # the surface may pass through the tile
        value = mesh_signed_distance(mesh, point, 2.0 * spread)
    elif wp.abs(centre) < reach + spread:  # the sign is that of the centre
        query = wp.mesh_query_point_no_sign(mesh, point, reach)
        if query.result:
            value = wp.sign(centre) * wp.length(point - wp.mesh_eval_position(mesh, query.face, query.u, query.v))
    value = wp.clamp(value, -reach, reach)
    wp.volume_store_f(volume, i, j, k, value)


@wp.func
def volume_distance(part: Any, p: Any):
    """Distance and normal of a part that is a volume, for lanes of points; outside its box a lower bound.

    One of the kinds of ``tool_shapes.py``.
    """
    lower = part.lower
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
            index = wp.volume_world_to_index(part.volume, wp.vec3(float(q[0]), float(q[1]), float(q[2])))
            gradient = wp.vec3(0.0, 0.0, 0.0)
            value = wp.volume_sample_grad_f(part.volume, index, wp.Volume.LINEAR, gradient)
            unit = wp.normalize(gradient)
            distance[i] = distance.dtype(value)
            for c in range(3):
                normal[c, i] = distance.dtype(unit[c])
    return distance, normal
