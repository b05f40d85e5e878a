"""List the triangles that may be nearest to a point in each eighth of the doubted cells."""

import warp as wp

from .nearest_triangle import PART_COUNT, nearest_on_triangle, unsigned_distance

# Distance of an eighth of a cell's farthest point from its middle, in spacings: sqrt(3) / 4, rounded up.
EIGHTH_REACH = wp.constant(0.4331)
# More candidates than these, or more triangles to look at for them, are left to the search of all triangles.
LARGEST_CANDIDATE_COUNT = wp.constant(64)
LARGEST_VISIT_COUNT = wp.constant(512)


@wp.func
def middle_of(corner: wp.vec3, spacing: float, part: wp.int32):
    """Middle of an eighth of the cell with this lowest corner [m]."""
    at = wp.vec3(float(part / 4) + 0.5, float((part / 2) % 2) + 0.5, float(part % 2) + 0.5)
    return corner + 0.5 * spacing * at


@wp.func
def from_face(mesh: wp.uint64, face: wp.int32, point: wp.vec3):
    """Distance of a point from a face of a mesh."""
    a = wp.mesh_eval_position(mesh, face, 1.0, 0.0)
    b = wp.mesh_eval_position(mesh, face, 0.0, 1.0)
    c = wp.mesh_eval_position(mesh, face, 0.0, 0.0)
    nearest, place = nearest_on_triangle(point, a, b, c)
    return wp.length(point - nearest)


@wp.func
def candidate_reach(mesh: wp.uint64, middle: wp.vec3, spacing: float, largest: float):
    """Distance from the middle of an eighth within which the nearest triangle of each of its points lies.

    A point at r from the middle is at most r further from the nearest triangle than the middle is, and that triangle
    another r further from the middle.
    """
    return 1.0001 * unsigned_distance(mesh, middle, largest) + 2.0 * EIGHTH_REACH * spacing


@wp.kernel(enable_backward=False)
def count_nearest_kernel(
    # In
    mesh: wp.uint64,
    corner: wp.array(dtype=wp.vec3),  # lowest one of each doubted cell [m]
    spacing: float,
    largest: float,  # distance from any of them [m]
    # Out
    count: wp.array2d(dtype=wp.int32),  # [cell, eighth]: zero for too many
):
    cell, part = wp.tid()
    middle = middle_of(corner[cell], spacing, part)
    reach = candidate_reach(mesh, middle, spacing, largest)
    around = wp.vec3(reach, reach, reach)
    query = wp.mesh_query_aabb(mesh, middle - around, middle + around)
    face = wp.int32(0)
    found = wp.int32(0)
    visits = wp.int32(0)
    while wp.mesh_query_next(query, face) and visits >= 0:
        visits += 1
        if from_face(mesh, face, middle) <= reach:
            found += 1
        if found > LARGEST_CANDIDATE_COUNT or visits > LARGEST_VISIT_COUNT:
            found = wp.int32(0)
            visits = wp.int32(-1)
    count[cell, part] = found


@wp.kernel(enable_backward=False)
def list_nearest_kernel(
    # In
    mesh: wp.uint64,
    corner: wp.array(dtype=wp.vec3),  # lowest one of each doubted cell [m]
    spacing: float,
    largest: float,  # distance from any of them [m]
    first: wp.array(dtype=wp.int32),  # of each eighth of a cell, and the end
    # Out
    away: wp.array(dtype=float),  # from the middle, ascending [m]
    triangle: wp.array(dtype=wp.int32),
):
    cell, part = wp.tid()
    start = first[PART_COUNT * cell + part]
    room = first[PART_COUNT * cell + part + 1] - start
    if room > 0:
        middle = middle_of(corner[cell], spacing, part)
        reach = candidate_reach(mesh, middle, spacing, largest)
        around = wp.vec3(reach, reach, reach)
        query = wp.mesh_query_aabb(mesh, middle - around, middle + around)
        face = wp.int32(0)
        found = wp.int32(0)
        while wp.mesh_query_next(query, face):
            distance = from_face(mesh, face, middle)
            if distance <= reach and found < room:
                # by insertion; of equal ones the first triangle first, in whatever order they are found
                k = start + found
                while k > start and (away[k - 1] > distance or (away[k - 1] == distance and triangle[k - 1] > face)):
                    away[k] = away[k - 1]
                    triangle[k] = triangle[k - 1]
                    k -= 1
                away[k] = distance
                triangle[k] = face
                found += 1
