"""What is sought at every update of the stable step for the contact of a sheet with itself.

A cheap watch first: groups of about sixteen nodes against groups of about sixteen facets, by their boxes; groups that
hang together are looked at only where their normals differ by a right angle, for a sheet does not touch itself where it
bends less. Every group is looked at by its owner, in ascending order: the same bits for any number of threads.
"""

from functools import cache

import warp as wp

from ..lane_types import lane_types
from ..operators import add, div, mul, sub  # noqa: F401
from ..pass_entries import PassEntry
from ..rows import MotionRow, PlyRow
from .data import FAR, NO_DEPTH, UNSOUGHT, record_struct
from .facet import facets_struct, find_foot, normal_at, patch_at, patch_functions, sagitta
from .search import search_struct, watch_struct
from .within import LEAST_COSINE, LEAST_SQUARED_MEAN, flat_patch_function

# Of a node: above or below the facets, facing them or with its back to them.
SLOT_COUNT = wp.constant(4)
# Groups that hang together and whose normals lie within this angle do not touch [rad].
QUIET_ANGLE = wp.constant(1.48)
# Nodes turned by more than the contact allows are followed already.
COSINE_MARGIN = wp.constant(0.1)
# Of the thickness: nearer to the middle of the facet, the side is not known; nearer by this, another facet is taken.
UNKNOWN_SIDE = wp.constant(0.25)
NEARER = wp.constant(0.25)
ITERATIONS = wp.constant(4)
# In place of none, to be divided by [m].
NO_WAY = wp.constant(1.0e-30)


@cache
def bounds_struct(real: type):
    """Groups of nodes, or of facets, and where they are; arrays are [group]."""
    vec3 = wp.types.vector(3, real)

    @wp.struct
    class Bounds:
        member: wp.array2d(dtype=wp.int32)  # [place, group]: nodes or facets, or -1
        node: wp.array2d(dtype=wp.int32)  # [place, group]: nodes of these, or -1
        low: wp.array(dtype=vec3)  # corners of their box [m]
        high: wp.array(dtype=vec3)
        axis: wp.array(dtype=vec3)  # unit vector amid their normals
        spread: wp.array(dtype=real)  # largest angle of a normal from it [rad]
        room: real  # by which their boxes are larger: nodes are so far from where their edges touch [m]

    return Bounds


@cache
def sheet_points_struct(real: type):
    """The nodes of a sheet, one by one; arrays are [node] but for those that have a layout."""

    @wp.struct
    class SheetPoints:
        entry: wp.array(dtype=wp.int32)  # first in the motion
        normal_entry: wp.array(dtype=wp.int32)  # first in the normals, and in the flat coordinates
        facets: facets_struct(real)
        touching: wp.array2d(
            dtype=wp.int32
        )  # [place, group of nodes]: groups of facets that hang together with it, or -1
        thickness: real  # at which the sheet touches itself [m]
        skin: real  # nodes this near are followed [m]
        turning: real  # both faces move at least this far while their normals turn against each other by one radian [m]
        farthest: real  # feet are taken up to this coordinate of a facet, to be walked from
        squared_exclusion: real  # nearer on the flat blank, points are neighbours [m^2]
        squared_edge_distance: real  # farther away, nodes of free edges may stand edge-on [m^2]

    return SheetPoints


@cache
def found_struct(real: type):
    """The nearest facet of every node, for every slot."""

    @wp.struct
    class Found:
        facet: wp.array2d(dtype=wp.int32)  # [slot, node], -1 for none
        # [group of nodes]: inverses of the ways up to which nothing can be found, 1/UNSOUGHT to UNSOUGHT [1/m]
        urgency: wp.array(dtype=real)  # among the groups of facets that hang together with it
        far_urgency: wp.array(dtype=real)  # among all others
        height: wp.array2d(dtype=real)  # of the node over it [m]
        xi: wp.array2d(dtype=real)  # where it stands on it
        eta: wp.array2d(dtype=real)

    return Found


@cache
def point_functions(real: type):
    """wp.funcs (points, node) -> position, normal, and whether the node lies on a free edge."""
    vec3, Points = wp.types.vector(3, real), sheet_points_struct(real)

    @wp.func
    def vector_at(values: wp.array(dtype=real), entry: int, stride: int):
        return vec3(values[entry], values[entry + stride], values[entry + 2 * stride])

    @wp.func
    def position_of(points: Points, node: int):
        return vector_at(points.facets.motion, points.entry[node], points.facets.stride)

    @wp.func
    def normal_of(points: Points, node: int):
        return vector_at(points.facets.normals, points.normal_entry[node], points.facets.normal_stride)

    @wp.func
    def on_edge(points: Points, node: int):
        return points.facets.flat[points.normal_entry[node] + 3 * points.facets.normal_stride] > real(0.5)

    return position_of, normal_of, on_edge


@cache
def bound_groups_kernel(real: type):
    """Kernel over groups: their boxes, and how their normals spread."""
    vec3, Points, Bounds = wp.types.vector(3, real), sheet_points_struct(real), bounds_struct(real)
    position_of, normal_of, _ = point_functions(real)

    @wp.func
    def spread_of(points: Points, bounds: Bounds, group: int, axis: vec3):
        least = real(1.0)
        for place in range(bounds.node.shape[0]):
            node = bounds.node[place, group]
            if node >= 0:
                least = wp.min(least, wp.dot(axis, normal_of(points, node)))
        return wp.acos(wp.clamp(least, real(-1.0), real(1.0)))

    @wp.kernel(module="unique", enable_backward=False)
    def bound_groups(
        first_group: wp.int32, points: Points, entry: wp.array(dtype=wp.float64), bounds: Bounds
    ):  # fmt: skip
        if entry[PassEntry.sought] == wp.float64(0.0):
            return
        group = first_group + wp.tid()
        low = vec3(real(FAR))
        high = vec3(-real(FAR))
        total = vec3()
        for place in range(bounds.node.shape[0]):
            node = bounds.node[place, group]
            if node >= 0:
                position = position_of(points, node)
                low = wp.min(low, position)
                high = wp.max(high, position)
                total = total + normal_of(points, node)
        axis = wp.normalize(total)
        bounds.low[group] = low - vec3(bounds.room)
        bounds.high[group] = high + vec3(bounds.room)
        bounds.axis[group] = axis
        bounds.spread[group] = spread_of(points, bounds, group, axis)

    return bound_groups


@cache
def look_function(real: type):
    """wp.func (points, node, facet, limit, found): keep the facet if it is the nearest of its slot so far."""
    types = lane_types(real, 1)
    vec3, one3, indices, lanes = types.vec3, types.lanes3, types.indices, types.lanes
    Points, Found = sheet_points_struct(real), found_struct(real)
    _, positions, normals, _ = patch_functions(real, 1)
    position_of, normal_of, on_edge = point_functions(real)
    flat_patch = flat_patch_function(real, 1)

    @wp.func
    def column(values: wp.array(dtype=real), entry: int, stride: int):
        result = one3()
        for c in range(3):
            result[c, 0] = values[entry + c * stride]
        return result

    @wp.func
    def is_beside(points: Points, point: vec3, facet: int, limit: real):
        """Whether a point is surely not over a facet, by its plane."""
        facets = points.facets
        x0 = column(facets.motion, facets.corner[4 * facet], facets.stride)
        x1 = column(facets.motion, facets.corner[4 * facet + 1], facets.stride)
        x2 = column(facets.motion, facets.corner[4 * facet + 2], facets.stride)
        x3 = column(facets.motion, facets.corner[4 * facet + 3], facets.stride)
        middle = real(0.25) * ((x0 + x1) + (x2 + x3))
        half1 = real(0.25) * ((x1 + x2) - (x0 + x3))
        half2 = real(0.25) * ((x2 + x3) - (x0 + x1))
        away = point - vec3(middle[0, 0], middle[1, 0], middle[2, 0])
        reach = limit + real(1.5) * (
            wp.length(vec3(half1[0, 0], half1[1, 0], half1[2, 0]))
            + wp.length(vec3(half2[0, 0], half2[1, 0], half2[2, 0]))
        )
        return wp.dot(away, away) > reach * reach

    @wp.func
    def keep(found: Found, slot: int, node: int, facet: int, height: real, xi: real, eta: real):
        if height < found.height[slot, node]:
            found.height[slot, node] = height
            found.facet[slot, node] = facet
            found.xi[slot, node] = xi
            found.eta[slot, node] = eta

    @wp.func
    def slot_of(points: Points, node: int, height: real, normal: vec3, squared_distance: real):
        """Of a node at a signed height over a facet of this normal; -1 if it faces neither way."""
        cosine = wp.dot(normal_of(points, node), normal)
        least = real(LEAST_COSINE) - real(COSINE_MARGIN)
        if on_edge(points, node) and squared_distance > points.squared_edge_distance:
            least = real(0.0)
        slot = wp.where(height > real(0.0), 0, 1) + wp.where(cosine > real(0.0), 2, 0)
        return wp.where(wp.abs(cosine) >= least, slot, -1)

    @wp.func
    def look(points: Points, node: int, facet: int, limit: real, found: Found):
        facets = points.facets
        if is_beside(points, position_of(points, node), facet, limit):
            return
        entry = points.entry[node]
        position = column(facets.motion, entry + MotionRow.position * facets.stride, facets.stride)
        rest = column(facets.motion, entry + MotionRow.remainder * facets.stride, facets.stride)
        x = positions(facets, indices(facet), position, rest)
        d = normals(facets, indices(facet))
        mean = vec3(d.mean[0, 0], d.mean[1, 0], d.mean[2, 0])
        if wp.dot(mean, mean) < real(LEAST_SQUARED_MEAN):
            return
        xi, eta, g = find_foot(x, d, lanes(), lanes(), ITERATIONS)
        if not wp.max(wp.abs(xi[0]), wp.abs(eta[0])) <= points.farthest:
            return
        n = normal_at(x, d, xi, eta)
        normal = vec3(n[0, 0], n[1, 0], n[2, 0])
        length = wp.length(normal)
        bow = sagitta(x, d, xi, eta)
        height = g[0] * length - bow[0] / length
        own = column(facets.flat, points.normal_entry[node], facets.normal_stride)
        apart = patch_at(flat_patch(facets, indices(facet)), xi, eta) - own
        far = wp.dot(vec3(apart[0, 0], apart[1, 0], apart[2, 0]), vec3(apart[0, 0], apart[1, 0], apart[2, 0]))
        near = wp.abs(height) < limit and wp.abs(height) > real(UNKNOWN_SIDE) * points.thickness
        if near and far > points.squared_exclusion:
            slot = slot_of(points, node, height, normal / length, far)
            if slot >= 0:
                keep(found, slot, node, facet, wp.abs(height), xi[0], eta[0])

    return look


@cache
def seek_own_facets_kernel(real: type):
    """Kernel over groups of nodes: the nearest facet of every node that may touch it before the next update."""
    Points, Bounds, Found = sheet_points_struct(real), bounds_struct(real), found_struct(real)
    position_of, _, _ = point_functions(real)
    look = look_function(real)

    @wp.func
    def gap_between(nodes: Bounds, facets: Bounds, group: int, other: int):
        """Of two boxes, along the axis where it is largest; negative where they overlap."""
        return wp.max(wp.max(facets.low[other] - nodes.high[group], nodes.low[group] - facets.high[other]))

    @wp.func
    def hang_together(points: Points, group: int, other: int):
        shared = wp.int32(0)
        for place in range(points.touching.shape[0]):
            if points.touching[place, group] == other:
                shared = 1
        return shared == 1

    @wp.func
    def quiet_way(points: Points, nodes: Bounds, facets: Bounds, group: int, other: int):
        """Way up to which two groups that hang together bend too little to touch each other; 0 if they may."""
        cosine = wp.clamp(wp.dot(nodes.axis[group], facets.axis[other]), real(-1.0), real(1.0))
        angle = wp.acos(cosine) + nodes.spread[group] + facets.spread[other]
        return wp.max(real(QUIET_ANGLE) - angle, real(0.0)) * points.turning

    @wp.func
    def compare(points: Points, nodes: Bounds, facets: Bounds, group: int, other: int, limit: real, found: Found):
        for place in range(nodes.member.shape[0]):
            node = nodes.member[place, group]
            if node >= 0:
                position = position_of(points, node)
                if not wp.max(wp.max(facets.low[other] - position, position - facets.high[other])) > limit:
                    for k in range(facets.member.shape[0]):
                        if facets.member[k, other] >= 0:
                            look(points, node, facets.member[k, other], limit, found)

    @wp.func
    def seek_near(
        points: Points, nodes: Bounds, facets: Bounds, group: int, limit: real, reach: real, found: Found
    ):  # fmt: skip
        """Urgency of groups that hang together with this one."""
        least = real(UNSOUGHT)
        for place in range(points.touching.shape[0]):
            other = points.touching[place, group]
            if other >= 0:
                way = wp.max(
                    gap_between(nodes, facets, group, other) - limit,
                    quiet_way(points, nodes, facets, group, other) - reach,
                )
                if not way > real(0.0):
                    compare(points, nodes, facets, group, other, limit, found)
                least = wp.min(least, way)
        return real(1.0) / wp.max(least, real(NO_WAY))

    @wp.func
    def seek_far(points: Points, nodes: Bounds, facets: Bounds, group: int, limit: real, found: Found):
        """Urgency of groups that do not hang together with this one."""
        least = real(UNSOUGHT)
        for other in range(facets.low.shape[0]):
            way = gap_between(nodes, facets, group, other) - limit
            # one that is near is found, however near another one is
            if wp.max(way, real(0.0)) <= least:
                if not hang_together(points, group, other):
                    least = wp.max(way, real(0.0))
                    if not way > real(0.0):
                        compare(points, nodes, facets, group, other, limit, found)
        return real(1.0) / wp.max(least, real(NO_WAY))

    @wp.kernel(module="unique", enable_backward=False)
    def seek_own_facets(
        # In
        first_group: wp.int32,
        points: Points,
        nodes: Bounds,
        facets: Bounds,
        entry: wp.array(dtype=wp.float64),  # of a pass; see PassEntry
        # Out
        found: Found,
    ):
        if entry[PassEntry.sought] == wp.float64(0.0):
            return
        group = first_group + wp.tid()
        reach = real(entry[PassEntry.reach])
        limit = points.thickness + points.skin + reach
        for place in range(nodes.member.shape[0]):
            node = nodes.member[place, group]
            if node >= 0:
                for slot in range(SLOT_COUNT):
                    found.facet[slot, node] = -1
                    found.height[slot, node] = real(UNSOUGHT)
        found.urgency[group] = seek_near(points, nodes, facets, group, limit, reach, found)
        if entry[PassEntry.sought] == wp.float64(2.0):
            found.far_urgency[group] = seek_far(points, nodes, facets, group, limit, found)

    return seek_own_facets


@cache
def follow_own_facets_kernel(real: type, lane_count: int):
    """Kernel over blocks of nodes, for each pass: nodes that begin to follow a facet, take another one, or stop."""
    vec3 = wp.types.vector(3, real)
    Search, Watch, Record, Found = (
        search_struct(real), watch_struct(real), record_struct(real, lane_count), found_struct(real),
    )  # fmt: skip

    @wp.func
    def is_lost(search: Search, reach: real, depth: real):
        """A node without a foot, or too far away to follow it any longer."""
        return depth < real(0.5) * real(NO_DEPTH) or -depth > real(1.1) * search.skin + reach

    @wp.func
    def begins(search: Search, record: Record, found: Found, block: int, lane: int, stray: real):
        """Whether a node takes the facet that was found."""
        node = block * lane_count + lane
        facet = found.facet[search.slot, node]
        if facet < 0:
            return False
        if stray > real(0.0):
            return True
        # a facet that has come between; not while the spring of the last one holds energy
        height = search.thickness - record.rows[PlyRow.depth, block][lane]
        nearer = found.height[search.slot, node] < height - real(NEARER) * search.thickness
        free = record.standing[block][lane] < 0 and record.rows[PlyRow.push, block][lane] <= real(0.0)
        return nearer and free and facet != record.facet[block][lane]

    @wp.kernel(module="unique", enable_backward=False)
    def follow_own_facets(first_block: wp.int32, search: Search, found: Found, record: Record, watch: Watch):
        block = first_block + wp.tid()
        if watch.entry[PassEntry.busy] == wp.float64(0.0):
            return
        reach = real(watch.entry[PassEntry.reach])
        stray = record.rows[PlyRow.stray, block]
        depth = record.rows[PlyRow.depth, block]
        for i in range(lane_count):
            if stray[i] > real(0.0) or is_lost(search, reach, depth[i]):
                stray[i] = real(UNSOUGHT)
            began = begins(search, record, found, block, i, stray[i])
            watch.found[block * lane_count + i] = wp.where(began, 1, 0)
            if began:
                stray[i] = real(0.0)
                depth[i] = real(NO_DEPTH)
                facet = record.facet[block]
                facet[i] = found.facet[search.slot, block * lane_count + i]
                record.facet[block] = facet
                record.way[block] = real(0.0)
                # the foot from which the pass goes on
                node = block * lane_count + i
                watch.foot[node] = vec3(found.xi[search.slot, node], found.eta[search.slot, node], real(0.0))
        record.rows[PlyRow.stray, block] = stray
        record.rows[PlyRow.depth, block] = depth

    return follow_own_facets
