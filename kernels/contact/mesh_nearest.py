"""The triangle of a mesh that is nearest to each point, for distances in double precision."""

import warp as wp

from .nearest_triangle import mesh_signed_distance


@wp.kernel(enable_backward=False)
def nearest_face_kernel(
    # In
    mesh: wp.uint64,
    points: wp.array(dtype=wp.vec3),
    largest: float,  # [m]
    crossed: wp.int32,
    # Out
    face: wp.array(dtype=wp.int32),
    distance: wp.array(dtype=float),  # signed [m]
):
    i = wp.tid()
    query = wp.mesh_query_point_no_sign(mesh, points[i], largest)
    face[i] = -1
    if query.result:
        face[i] = query.face
    distance[i] = mesh_signed_distance(mesh, points[i], largest, crossed)
