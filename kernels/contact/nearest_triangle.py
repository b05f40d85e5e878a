"""Signed distance to the nearest triangle of a mesh: among few candidates of a cell of samples, or among all.

Single precision, about the mesh's own centre; negative inside.
"""

import warp as wp

# Nearest points whose barycentric coordinates all exceed this lie within a face, not on its edge.
FACE_INTERIOR = wp.constant(1.0e-3)
# Least cosine between a face's normal and the way to a point that is nearest to the face's interior.
FACING = wp.constant(0.9)
# A point this near to a triangle has its normal, for the way between them is rounding [m].
TOUCHING = wp.constant(1.0e-7)
# Cells of a tile of samples; halves of a cell along each axis make it eight, each with candidates of its own.
CELL_COUNT = wp.constant(512)
PART_COUNT = wp.constant(8)
# Places on a triangle that may be nearest: its face, three edges (from a, b, c), three corners.
PLACE_COUNT = wp.constant(7)
# A larger distance than any.
NOWHERE = wp.constant(1.0e30)


@wp.struct
class NearestTriangles:
    """Triangles that may be nearest to a point in each doubted cell."""

    tile: wp.uint64  # address of int32, by number of the tile: its place among those with doubted cells
    cell: wp.uint64  # address of int32, [place of the tile, cell]: number among the doubted cells
    first: wp.uint64  # address of int32, (PART_COUNT * cells + 1): first candidate of each eighth of a cell
    away: wp.uint64  # address of float32: distance of each candidate from the middle of its eighth, ascending [m]
    triangle: wp.uint64  # address of int32: its number
    corner: wp.uint64  # address of vec3: three of each triangle [m]
    facing: (
        wp.uint64
    )  # address of vec3: see facings.py, PLACE_COUNT of each triangle; zero where it cannot tell the side
    tile_count: wp.int32
    doubted_tile_count: wp.int32
    cell_count: wp.int32
    candidate_count: wp.int32
    triangle_count: wp.int32
    spacing: float  # of the samples [m]
    largest: float  # distance up to which all triangles are searched, where there are too many candidates [m]
    mesh: wp.uint64  # id of a wp.Mesh: closed, facing outwards
    crossed: wp.int32  # whether surfaces lie inside the solid, so that the winding number alone tells the side


@wp.func
def side_of_face(u: float, v: float, height: float, distance: float):
    """Side of a point ``height`` over the face nearest to it: 1, or -1, or 0 where an edge or a corner may be nearest.

    ``u``, ``v``: barycentric coordinates of the nearest place.
    """
    side = wp.float32(0.0)
    if wp.min(wp.min(u, v), 1.0 - u - v) > FACE_INTERIOR and wp.abs(height) >= FACING * distance:
        side = wp.where(height < 0.0, -1.0, 1.0)
    return side


@wp.func
def winding_side(mesh: wp.uint64, point: wp.vec3, distance: float):
    """Side of a point at a ``distance`` from the nearest triangle, from the winding number."""
    query = wp.mesh_query_point_sign_winding_number(mesh, point, 1.001 * distance + 1.0e-9)
    return query.sign


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
        normal = facing
        side = side_of_face(query.u, query.v, wp.dot(away, facing), distance)
        if crossed == 0 and side != 0.0:
            distance = side * distance
        else:
            distance = winding_side(mesh, point, distance) * distance
            if wp.abs(distance) > TOUCHING:
                normal = away / distance
    return distance, normal


@wp.func
def mesh_signed_distance(mesh: wp.uint64, point: wp.vec3, largest: float, crossed: wp.int32):
    """As ``nearest_on_mesh``, without the normal."""
    distance, normal = nearest_on_mesh(mesh, point, largest, crossed)
    return distance


@wp.func
def distance_and_side(mesh: wp.uint64, point: wp.vec3, largest: float, crossed: wp.int32):
    """Distance to the nearest triangle, at most ``largest``, and the side that its face tells; 0 if it does not."""
    query = wp.mesh_query_point_no_sign(mesh, point, largest)
    distance = largest
    side = wp.float32(0.0)
    if query.result:
        away = point - wp.mesh_eval_position(mesh, query.face, query.u, query.v)
        distance = wp.length(away)
        if crossed == 0:
            height = wp.dot(away, wp.mesh_eval_face_normal(mesh, query.face))
            side = side_of_face(query.u, query.v, height, distance)
    return distance, side


@wp.func
def unsigned_distance(mesh: wp.uint64, point: wp.vec3, largest: float):
    query = wp.mesh_query_point_no_sign(mesh, point, largest)
    distance = largest
    if query.result:
        distance = wp.length(point - wp.mesh_eval_position(mesh, query.face, query.u, query.v))
    return distance


@wp.func
def from_edge(start: wp.vec3, along: wp.vec3, d: float, e: float):
    """Point on an edge, from the products of ``along`` with the ways from its ends to a point."""
    return start + along * (d / wp.max(d - e, 1.0e-30))


@wp.func
def nearest_on_triangle(p: wp.vec3, a: wp.vec3, b: wp.vec3, c: wp.vec3):
    """Nearest point of a triangle, and its place: 0 the face, 1 to 3 the edges from a, b, c, 4 to 6 a, b, c.

    By the Voronoi regions of the triangle: C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5.
    """
    ab = b - a
    ac = c - a
    d1 = wp.dot(ab, p - a)
    d2 = wp.dot(ac, p - a)
    d3 = wp.dot(ab, p - b)
    d4 = wp.dot(ac, p - b)
    d5 = wp.dot(ab, p - c)
    d6 = wp.dot(ac, p - c)
    va = d3 * d6 - d5 * d4
    vb = d5 * d2 - d1 * d6
    vc = d1 * d4 - d3 * d2
    point = a
    place = wp.int32(4)
    if d1 <= 0.0 and d2 <= 0.0:
        point = a
    elif d3 >= 0.0 and d4 <= d3:
        point = b
        place = wp.int32(5)
    elif d6 >= 0.0 and d5 <= d6:
        point = c
        place = wp.int32(6)
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        point = from_edge(a, ab, d1, d3)
        place = wp.int32(1)
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        point = from_edge(a, ac, d2, d6)
        place = wp.int32(3)
    elif va <= 0.0 and d4 >= d3 and d5 >= d6:
        point = from_edge(b, c - b, d4 - d3, d6 - d5)
        place = wp.int32(2)
    else:
        share = 1.0 / (va + vb + vc)
        point = a + ab * (vb * share) + ac * (vc * share)
        place = wp.int32(0)
    return point, place


@wp.func
def side_of(nearest: NearestTriangles, index: wp.int32, point: wp.vec3, away: wp.vec3):
    """Signed distance and outward normal of a point ``away`` from a place on a triangle."""
    facings = wp.array(ptr=nearest.facing, shape=(PLACE_COUNT * nearest.triangle_count,), dtype=wp.vec3)
    facing = facings[index]
    distance = wp.length(away)
    normal = facing
    if facing[0] == 0.0 and facing[1] == 0.0 and facing[2] == 0.0:
        distance = winding_side(nearest.mesh, point, distance) * distance
    elif wp.dot(away, facing) < 0.0:
        distance = -distance
    if index % PLACE_COUNT != 0 and wp.abs(distance) > TOUCHING:
        normal = away / distance
    return distance, normal


@wp.func
def eighth_of(along: wp.vec3, cell: wp.vec3i):
    """Which eighth of a cell a place lies in, and its middle; both in spacings."""
    x = wp.where(along[0] - float(cell[0]) < 0.5, 0, 1)
    y = wp.where(along[1] - float(cell[1]) < 0.5, 0, 1)
    z = wp.where(along[2] - float(cell[2]) < 0.5, 0, 1)
    corner = wp.vec3(float(cell[0]), float(cell[1]), float(cell[2]))
    return 4 * x + 2 * y + z, corner + 0.5 * wp.vec3(float(x) + 0.5, float(y) + 0.5, float(z) + 0.5)


@wp.func
def nearest_in_cell(nearest: NearestTriangles, tile: wp.int32, cell: wp.vec3i, point: wp.vec3, along: wp.vec3):
    """Signed distance and outward normal of a point in a doubted cell; ``along`` is its place in spacings."""
    places = wp.array(ptr=nearest.tile, shape=(nearest.tile_count,), dtype=wp.int32)
    cells = wp.array(ptr=nearest.cell, shape=(CELL_COUNT * nearest.doubted_tile_count,), dtype=wp.int32)
    firsts = wp.array(ptr=nearest.first, shape=(PART_COUNT * nearest.cell_count + 1,), dtype=wp.int32)
    aways = wp.array(ptr=nearest.away, shape=(nearest.candidate_count,), dtype=wp.float32)
    triangles = wp.array(ptr=nearest.triangle, shape=(nearest.candidate_count,), dtype=wp.int32)
    corners = wp.array(ptr=nearest.corner, shape=(3 * nearest.triangle_count,), dtype=wp.vec3)
    own = CELL_COUNT * places[tile] + 64 * (cell[0] % 8) + 8 * (cell[1] % 8) + cell[2] % 8
    part, middle = eighth_of(along, cell)
    index = PART_COUNT * cells[own] + part
    first = firsts[index]
    last = firsts[index + 1]
    distance = float(nearest.largest)
    normal = wp.vec3(0.0, 0.0, 0.0)
    if first < last:
        slack = 1.0001 * nearest.spacing * wp.length(along - middle)
        least = float(NOWHERE)
        best = wp.int32(0)
        way = wp.vec3(0.0, 0.0, 0.0)
        for k in range(first, last):
            if aways[k] - slack > least:
                break
            t = triangles[k]
            q, place = nearest_on_triangle(point, corners[3 * t], corners[3 * t + 1], corners[3 * t + 2])
            length = wp.length(point - q)
            if length < least:
                least = length
                way = point - q
                best = PLACE_COUNT * t + place
        distance, normal = side_of(nearest, best, point, way)
    else:
        distance, normal = nearest_on_mesh(nearest.mesh, point, nearest.largest, nearest.crossed)
    return distance, normal
