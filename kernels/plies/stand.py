"""Where the nodes of one ply stand on the facets of another, and how they move there (docs/plies.md)."""

from functools import cache
from typing import Any

import warp as wp

from ..lane_types import lane_types
from ..lanes import cross, dot, fill, magnitude, scale, square_root, where_positive
from ..machine import anew, following
from ..operators import add, div, mul, sub  # noqa: F401
from ..records import SCALAR, record3, record4, store_record4, vector_of
from ..rows import MOTION_RECORD_LENGTH, PLY_RECORD_LENGTH, MotionRow, PlyRow
from .data import NO_DEPTH, contact_law_struct, record_struct
from .facet import (
    facets_struct,
    find_foot,
    first_height,
    inside_function,
    nearer_foot,
    normal_at,
    offset_along1,
    offset_along2,
    patch_along1,
    patch_along2,
    patch_at,
    patch_functions,
    patch_struct,
    sagitta,
    walk_function,
)

# A foot that has gone farther than this from its facet is lost, and sought again among all facets.
LOST = wp.constant(1.9)
# Least cosine between facet and normal, and least length of the mean normal, where a foot is unique.
LEAST_FACING = wp.constant(0.3)
LEAST_NORMAL = wp.constant(0.7)
# Newton iterations on each facet, and facets, on the way of a node to its foot.
SETTLING_ITERATIONS = wp.constant(5)
SETTLING_WALKS = wp.constant(16)


@cache
def ply_place_struct(real: type, lane_count: int):
    """One block of nodes of the pass at the beginning of a step."""
    types = lane_types(real, lane_count)

    @wp.struct
    class PlyPlace:
        block: wp.int32
        mean_step: real  # over which the forces act [s]
        last_step: real  # over which those of the last step acted [s]
        position: types.lanes3  # [m]
        remainder: types.lanes3  # [m]
        velocity: types.lanes3  # half a step ago [m/s]

    return PlyPlace


@cache
def below_struct(real: type, lane_count: int):
    """The facets under a block of nodes: positions from each node, normals, velocities."""
    Patch = patch_struct(real, lane_count)

    @wp.struct
    class Below:
        x: Patch
        d: Patch
        v: Patch

    return Below


@cache
def stand_struct(real: type, lane_count: int):
    """Where a block of nodes stands on the facets under it, and how it moves there."""
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3

    @wp.struct
    class Stand:
        xi: lanes
        eta: lanes
        normal: lanes3  # unit normal of the other ply, interpolated from its nodes
        depth: lanes  # penetration [m]; NO_DEPTH without a foot
        distance: lanes  # of the mid-surfaces, at which they touch [m]
        velocity: lanes3  # of the nodes relative to their feet [m/s]; also just beside the facets
        spin: lanes  # rate at which the facet turns about its normal [1/s]
        has_foot: lanes  # 1 or 0
        lost: lanes  # 1 where the foot is lost, else 0

    return Stand


@cache
def below_function(real: type, lane_count: int):
    """wp.func (facets, facet, place) -> Below."""
    indices = lane_types(real, lane_count).indices
    Facets, Place, Below = facets_struct(real), ply_place_struct(real, lane_count), below_struct(real, lane_count)
    vectors, positions, normals, _ = patch_functions(real, lane_count)

    @wp.func
    def look_below(facets: Facets, facet: indices, place: Place):
        below = Below()
        below.x = positions(facets, facet, place.position, place.remainder)
        below.d = normals(facets, facet)
        below.v = vectors(facets, facet, MotionRow.velocity)
        return below

    return look_below


@wp.func
def touch_distance(law: Any, below: Any, xi: Any, eta: Any):
    """Distance of the mid-surfaces at which the plies touch: the thickness, and the sagitta of the facet."""
    n = normal_at(below.x, below.d, xi, eta)
    return fill(xi, law.thickness) + law.side * (sagitta(below.x, below.d, xi, eta) / square_root(dot(n, n)))


@wp.func
def speed_over(place: Any, below: Any, xi: Any, eta: Any):
    """Velocity of the nodes relative to their feet."""
    return place.velocity - patch_at(below.v, xi, eta)


@cache
def stand_function(real: type, lane_count: int):
    """wp.func (law, facets, facet, place, below, xi, eta, iterations) -> Stand, sought from the foot (xi, eta)."""
    types = lane_types(real, lane_count)
    lanes, indices = types.lanes, types.indices
    Facets, Law = facets_struct(real), contact_law_struct(real)
    Place, Below, Stand = (
        ply_place_struct(real, lane_count),
        below_struct(real, lane_count),
        stand_struct(real, lane_count),
    )
    inside = inside_function(real, lane_count)

    @wp.func
    def turn_of(below: Below, stand: Stand, g: lanes, length: lanes):
        """``stand`` with the spin of its facets; feet that are not unique are taken away."""
        x1 = patch_along1(below.x, stand.eta)
        x2 = patch_along2(below.x, stand.xi)
        along1 = offset_along1(below.x, below.d, stand.xi, stand.eta, g)
        along2 = offset_along2(below.x, below.d, stand.xi, stand.eta, g)
        offset = cross(along1, along2)
        facing = dot(offset, stand.normal) - real(LEAST_FACING) * square_root(dot(offset, offset))
        stand.has_foot = where_positive(facing, stand.has_foot, lanes())
        stand.has_foot = where_positive(length - lanes(real(LEAST_NORMAL)), stand.has_foot, lanes())
        area = dot(cross(x1, x2), stand.normal)
        turning = dot(patch_along1(below.v, stand.eta), x2) - dot(patch_along2(below.v, stand.xi), x1)
        stand.spin = where_positive(stand.has_foot, real(0.5) * turning / area, lanes())
        return stand

    @wp.func
    def stand_on(
        law: Law, facets: Facets, facet: indices, place: Place, below: Below, xi: lanes, eta: lanes, iterations: int
    ):
        stand = Stand()
        new_xi, new_eta, g = find_foot(below.x, below.d, xi, eta, iterations)
        stand.xi = new_xi
        stand.eta = new_eta
        n = normal_at(below.x, below.d, new_xi, new_eta)
        length = square_root(dot(n, n))
        stand.normal = scale(fill(length, 1.0) / length, n)
        stand.distance = touch_distance(law, below, new_xi, new_eta)
        stand.has_foot = inside(facets, facet, new_xi, new_eta, law.farthest)
        farther = where_positive(magnitude(new_xi) - magnitude(new_eta), magnitude(new_xi), magnitude(new_eta))
        stand.lost = where_positive(farther - lanes(real(LOST)), fill(xi, 1.0), lanes())
        stand = turn_of(below, stand, g, length)
        depth = stand.distance - law.side * (g * length)
        stand.depth = where_positive(stand.has_foot, depth, lanes(real(NO_DEPTH)))
        stand.velocity = speed_over(place, below, new_xi, new_eta)
        return stand

    return stand_on


def settling_options(real: type) -> dict[str, Any]:
    """Options of a kernel that settles nodes, for what it takes of a GPU's registers.

    In a loop over nodes, all that one of them may leave undefined would be kept for the next. In double precision the
    compiler would read so far ahead that it takes 122 registers; with 106 it has nothing on the stack, either.
    """
    return {"grid_stride": False, "cuda_max_registers": None if real is wp.float32 else 106}


@cache
def settle_function(real: type, lane_count: int):
    """wp.func (facets, motion, record, block, chosen) -> facets; 1 where a node is on its way to its foot, else 0.

    Chosen nodes walk from the middles of their facets to their feet; coordinates are written, facets are not.
    """
    types, Facets, Record = lane_types(real, lane_count), facets_struct(real), record_struct(real, lane_count)
    lanes, indices = types.lanes, types.indices
    _, positions, normals, _ = patch_functions(real, lane_count)
    walk = walk_function(real, lane_count)

    @wp.func
    def write(record: Record, row: int, block: int, chosen: lanes, coordinate: lanes):
        old = record4(record.rows, PLY_RECORD_LENGTH, row, block)
        value = where_positive(chosen, coordinate, old[SCALAR])
        store_record4(record.rows, PLY_RECORD_LENGTH, row, block, vector_of(old), value)

    @wp.func
    def all_anew(facet: indices):
        result = indices()
        for i in range(lane_count):
            result[i] = anew(facet[i])
        return result

    @wp.func
    def approach(
        facets: Facets, motion: wp.array2d(dtype=lanes), block: int, facet: indices, old_xi: lanes, old_eta: lanes
    ):
        """Feet on these facets, as ``find_foot`` finds them; a GPU does not keep facets in registers meanwhile."""
        xi = old_xi
        eta = old_eta
        g = lanes()
        iteration = wp.int32(0)
        while iteration < SETTLING_ITERATIONS:
            here = anew(block)
            below = all_anew(facet)
            position = record3(motion, MOTION_RECORD_LENGTH, MotionRow.position, here)
            x = positions(facets, below, position, record3(motion, MOTION_RECORD_LENGTH, MotionRow.remainder, here))
            d = normals(facets, below)
            if iteration == 0:
                g = first_height(x, d, xi, eta)
            xi, eta, g = nearer_foot(x, d, xi, eta, g)
            iteration = following(iteration)
        return xi, eta

    @wp.func
    def settle(facets: Facets, motion: wp.array2d(dtype=lanes), record: Record, block: int, chosen: lanes):
        facet = record.facet[block]
        before = facet
        xi = lanes()
        eta = lanes()
        left = wp.int32(SETTLING_WALKS)
        while left > 0:
            before = facet
            near_xi, near_eta = approach(facets, motion, block, before, xi, eta)
            near_xi = where_positive(chosen, near_xi, lanes())
            near_eta = where_positive(chosen, near_eta, lanes())
            facet, xi, eta, moved = walk(facets, before, near_xi, near_eta)
            left = wp.where(moved > 0, left - 1, 0)
        write(record, PlyRow.force, block, chosen, xi)
        write(record, PlyRow.drag, block, chosen, eta)
        under_way = lanes()
        for i in range(lane_count):
            under_way[i] = wp.where(facet[i] != before[i], real(1.0), real(0.0))
        return facet, under_way

    return settle
