"""What is sought at every update of the stable step for one pass of an interface (docs/plies.md).

A node walks from facet to facet by itself. Sought are the nodes that may stand on each facet until the next update,
blocks of nodes that are too far away to touch, and feet of nodes that have none. Every list is made by its owner, in
ascending order: no atomics, and the same bits for any number of threads.
"""

from functools import cache

import warp as wp

from ..lanes import dot, lane_maximum, lane_types
from ..operators import div, mul  # noqa: F401
from ..records import SCALAR, record3, record4, store_record4, vector_of
from ..rows import MOTION_RECORD_LENGTH, PLY_RECORD_LENGTH, ClockEntry, MotionRow, PassEntry, PlyRow
from .data import NO_DEPTH, TOO_MANY, listed_struct, record_struct
from .facet import facets_struct, patch_at, patch_functions

# Plies may move this much farther until the next update than at their largest speeds now.
SPEED_MARGIN = wp.constant(2.0)
# A block is not watched while it is farther away than both plies move until this many updates later.
LEAST_UPDATES = wp.constant(4.0)
# A node has a foot once it is over a facet, within this times the facet's radius, and near above or below it.
NEAR = wp.constant(1.2)


@cache
def search_struct(real: type):
    """Constants of the search of one pass."""

    @wp.struct
    class Search:
        skin: real  # nodes this near to a facet are listed [m]
        thickness: real  # at which the plies touch [m]
        facet_count: wp.int32  # without padding
        steps: wp.int32  # until the next update
        slot: wp.int32  # contact within a sheet: which of its slots the pass is; else -1
        ring: wp.array2d(dtype=wp.int32)  # [facet, place]: facets that share a node with it, itself first; or -1

    return Search


@cache
def watch_struct(real: type):
    """What the search leaves between its kernels; nothing of it outlives an update, except the late ones."""
    vec3 = wp.types.vector(3, real)

    @wp.struct
    class Watch:
        entry: wp.array(dtype=wp.float64)  # see PassEntry
        travel: wp.array(dtype=real)  # [block]: longest way of a node since the lists were made [m]
        late: wp.array(dtype=wp.int32)  # [block]: 1 if a pressed node had gone too far
        deepest: wp.array(dtype=real)  # [block]: deepest penetration that makes a force [m]
        found: wp.array(dtype=wp.int32)  # [node]: 1 if it has just found a foot
        foot: wp.array(dtype=vec3)  # [node]: place of its foot [m]
        stray: wp.array(dtype=wp.int32)  # nodes that have just found a foot

    return Watch


@cache
def watch_speed_kernel(real: type, lane_count: int):
    """Kernel over blocks of nodes of a sheet: their largest squared speed [m^2/s^2]."""
    lanes = lane_types(real, lane_count).lanes

    @wp.kernel(module="unique", enable_backward=False)
    def watch_speed(first_block: wp.int32, motion: wp.array2d(dtype=lanes), squared_speed: wp.array(dtype=real)):
        block = first_block + wp.tid()
        velocity = record3(motion, MOTION_RECORD_LENGTH, MotionRow.velocity, block)
        squared_speed[block] = lane_maximum(dot(velocity, velocity))

    return watch_speed


@cache
def plan_search_kernel(real: type):
    """Kernel of one thread: how far both plies may move until the next update."""
    Search, Watch = search_struct(real), watch_struct(real)

    @wp.func
    def largest(values: wp.array(dtype=real)):
        result = real(0.0)
        for k in range(values.shape[0]):
            result = wp.max(result, values[k])
        return result

    @wp.kernel(module="unique", enable_backward=False)
    def plan_search(
        # In
        search: Search,
        clock: wp.array(dtype=wp.float64),
        squared_speed: wp.array(dtype=real),  # of the nodes' sheet, by groups of blocks
        facet_squared_speed: wp.array(dtype=real),  # of the facets' sheet
        # Out
        watch: Watch,
    ):
        speed = wp.sqrt(largest(squared_speed)) + wp.sqrt(largest(facet_squared_speed))
        time = clock[ClockEntry.step] * wp.float64(search.steps)
        watch.entry[PassEntry.reach] = wp.float64(SPEED_MARGIN) * time * wp.float64(speed)

    return plan_search


@cache
def seek_feet_kernel(real: type, lane_count: int):
    """Kernel over blocks of nodes: which blocks to watch, and feet for nodes that have none."""
    types = lane_types(real, lane_count)
    lanes, lanes3, vec3 = types.lanes, types.lanes3, types.vec3
    Facets, Search, Watch = facets_struct(real), search_struct(real), watch_struct(real)
    Record = record_struct(real, lane_count)
    vectors, _, _, _ = patch_functions(real, lane_count)

    @wp.func
    def corner_place(facets: Facets, facet: int, corner: int):
        entry = facets.corner[4 * facet + corner]
        return vec3(
            facets.motion[entry], facets.motion[entry + facets.stride], facets.motion[entry + 2 * facets.stride]
        )

    @wp.func
    def way_to_facet(facets: Facets, facet: int, thickness: real, point: vec3):
        """How far a point may move before it is over a facet, or near above or below it [m]; negative if it is."""
        first = corner_place(facets, facet, 2) - corner_place(facets, facet, 0)
        second = corner_place(facets, facet, 3) - corner_place(facets, facet, 1)
        middle = vec3()
        for corner in range(4):
            middle = middle + real(0.25) * corner_place(facets, facet, corner)
        radius = real(0.0)
        for corner in range(4):
            radius = wp.max(radius, wp.length(corner_place(facets, facet, corner) - middle))
        away = point - middle
        height = wp.dot(away, wp.normalize(wp.cross(first, second)))
        beside = wp.sqrt(wp.max(wp.dot(away, away) - height * height, real(0.0)))
        return wp.max(beside - real(NEAR) * radius, wp.abs(height) - radius - thickness)

    @wp.func
    def nearest_facet(facets: Facets, search: Search, point: vec3):
        best = wp.int32(0)
        way = way_to_facet(facets, 0, search.thickness, point)
        for facet in range(1, search.facet_count):
            other = way_to_facet(facets, facet, search.thickness, point)
            if other < way:
                way = other
                best = facet
        return best, way

    @wp.func
    def seek_foot(facets: Facets, search: Search, reach: real, position: lanes3, record: Record, block: int, lane: int):
        """Way that a stray node has left, 0 with a foot; its facet is written."""
        left = record.rows[PlyRow.stray, block][lane] - reach
        if left < real(LEAST_UPDATES) * reach or left <= real(0.0):
            point = vec3(position[0, lane], position[1, lane], position[2, lane])
            facet, way = nearest_facet(facets, search, point)
            left = wp.max(way, real(0.0))
            if way <= real(0.0):
                feet = record.facet[block]
                feet[lane] = facet
                record.facet[block] = feet
        return left

    @wp.func
    def free_way(search: Search, depth: lanes, stray: lanes):
        """Smallest way that a node of the block has to go before it touches [m]; 0 where that is not known."""
        result = real(1.0e30)
        for i in range(lane_count):
            free = stray[i]
            if stray[i] <= real(0.0):
                free = real(0.0)
                if depth[i] > real(0.5) * real(NO_DEPTH):
                    free = real(-0.7) * depth[i] - real(0.2) * search.thickness
            result = wp.min(result, free)
        return result

    @wp.func
    def watch_block(search: Search, reach: real, record: Record, block: int):
        """Whether the block is watched until the next update; one that wakes is listed anew at that."""
        old = record.way[block]
        way = old - reach
        if not old > real(0.0):
            way = free_way(search, record.rows[PlyRow.depth, block], record.rows[PlyRow.stray, block]) - reach
        sleeps = way > real(LEAST_UPDATES) * reach and (reach > real(0.0) or search.slot >= 0)
        record.way[block] = wp.where(sleeps, way, real(0.0))
        if old > real(0.0) and not record.way[block] > real(0.0):
            record.rows[PlyRow.travel, block] = lanes(search.skin)

    @wp.func
    def note_feet(facets: Facets, search: Search, record: Record, block: int, watch: Watch):
        xi = record4(record.rows, PLY_RECORD_LENGTH, PlyRow.force, block)[SCALAR]
        eta = record4(record.rows, PLY_RECORD_LENGTH, PlyRow.drag, block)[SCALAR]
        feet = patch_at(vectors(facets, record.facet[block], MotionRow.position), xi, eta)
        travel = record.rows[PlyRow.travel, block]
        late = wp.int32(0)
        for i in range(lane_count):
            watch.foot[block * lane_count + i] = vec3(feet[0, i], feet[1, i], feet[2, i])
            if record.standing[block][i] >= 0 and travel[i] > search.skin:
                late = 1
        watch.late[block] = late
        watch.travel[block] = lane_maximum(travel)
        watch.deepest[block] = lane_maximum(record.rows[PlyRow.depth, block] - record.rows[PlyRow.entry, block])

    @wp.kernel(module="unique", enable_backward=False)
    def seek_feet(
        # In
        first_block: wp.int32,
        facets: Facets,
        search: Search,
        motion: wp.array2d(dtype=lanes),  # of the nodes
        # Out
        record: Record,
        watch: Watch,
    ):
        block = first_block + wp.tid()
        reach = real(watch.entry[PassEntry.reach])
        position = record3(motion, MOTION_RECORD_LENGTH, MotionRow.position, block)
        stray = record.rows[PlyRow.stray, block]
        travel = record.rows[PlyRow.travel, block]
        force = record4(record.rows, PLY_RECORD_LENGTH, PlyRow.force, block)
        drag = record4(record.rows, PLY_RECORD_LENGTH, PlyRow.drag, block)
        for i in range(lane_count):
            # within a sheet, the feet have been found before
            found = wp.where(search.slot >= 0, watch.found[block * lane_count + i], 0)
            if stray[i] > real(0.0):
                stray[i] = seek_foot(facets, search, reach, position, record, block, i)
                found = wp.where(stray[i] <= real(0.0), 1, 0)
            if found == 1:
                travel[i] = wp.where(search.slot >= 0, real(0.0), search.skin)
                force[SCALAR, i] = wp.where(search.slot >= 0, watch.foot[block * lane_count + i][0], real(0.0))
                drag[SCALAR, i] = wp.where(search.slot >= 0, watch.foot[block * lane_count + i][1], real(0.0))
            watch.found[block * lane_count + i] = found
        record.rows[PlyRow.stray, block] = stray
        record.rows[PlyRow.travel, block] = travel
        store_record4(record.rows, PLY_RECORD_LENGTH, PlyRow.force, block, vector_of(force), force[SCALAR])
        store_record4(record.rows, PLY_RECORD_LENGTH, PlyRow.drag, block, vector_of(drag), drag[SCALAR])
        note_feet(facets, search, record, block, watch)
        watch_block(search, reach, record, block)

    return seek_feet


@cache
def list_nodes_kernel(real: type):
    """Kernel over facets: the nodes that may stand on each until the lists are made again, from the old lists.

    A node is listed on the facet of its foot, and that is in the ring of every facet near to it.
    """
    vec3 = wp.types.vector(3, real)
    Facets, Search, Watch, Listed = facets_struct(real), search_struct(real), watch_struct(real), listed_struct()

    @wp.func
    def is_near(facets: Facets, skin: real, facet: int, point: vec3):
        inside = True
        for c in range(3):
            low = facets.motion[facets.corner[4 * facet] + c * facets.stride]
            high = low
            for corner in range(1, 4):
                value = facets.motion[facets.corner[4 * facet + corner] + c * facets.stride]
                low = wp.min(low, value)
                high = wp.max(high, value)
            inside = inside and point[c] >= low - skin and point[c] <= high + skin
        return inside

    @wp.func
    def insert(listed: Listed, facet: int, node: int):
        """Into an ascending list, unless it is there already or the list is full."""
        count = listed.count[facet]
        if count == TOO_MANY:
            return
        place = int(count)
        while place > 0 and listed.node[place - 1, facet] > node:
            place = place - 1
        if place > 0 and listed.node[place - 1, facet] == node:
            return
        if count == listed.node.shape[0]:
            listed.count[facet] = TOO_MANY
            return
        for k in range(count - place):
            listed.node[count - k, facet] = listed.node[count - k - 1, facet]
        listed.node[place, facet] = node
        listed.count[facet] = count + 1

    @wp.kernel(module="unique", enable_backward=False)
    def list_nodes(
        # In
        first_facet: wp.int32,
        facets: Facets,
        search: Search,
        watch: Watch,
        feet: wp.array(dtype=wp.int32),  # [node]: facet of its foot
        old: Listed,
        # Out
        listed: Listed,
    ):
        facet = first_facet + wp.tid()
        if watch.entry[PassEntry.rebuild] == wp.float64(0.0) or facet >= search.facet_count:
            return
        listed.count[facet] = 0
        for place in range(search.ring.shape[1]):
            near = search.ring[facet, place]
            if near >= 0:
                count = old.count[near]
                slots = wp.where(count == TOO_MANY, feet.shape[0], count)
                for slot in range(slots):
                    node = slot
                    if count != TOO_MANY:
                        node = old.node[slot, near]
                    if feet[node] == near:
                        if near == facet or is_near(facets, search.skin, facet, watch.foot[node]):
                            insert(listed, facet, node)
        for k in range(int(watch.entry[PassEntry.stray_count])):
            node = watch.stray[k]
            if feet[node] == facet or is_near(facets, search.skin, facet, watch.foot[node]):
                insert(listed, facet, node)

    return list_nodes


@cache
def adopt_lists_kernel(real: type, lane_count: int):
    """Kernel over blocks of facets: take the new lists, and tell how many slots each block uses."""
    Search, Watch, Listed = search_struct(real), watch_struct(real), listed_struct()

    @wp.kernel(module="unique", enable_backward=False)
    def adopt_lists(
        # In
        first_block: wp.int32,
        search: Search,
        watch: Watch,
        made: Listed,
        # Out
        listed: Listed,
        block_count: wp.array(dtype=wp.int32),
    ):
        block = first_block + wp.tid()
        if watch.entry[PassEntry.rebuild] == wp.float64(0.0):
            return
        most = wp.int32(0)
        for i in range(lane_count):
            facet = block * lane_count + i
            if facet < search.facet_count:
                count = made.count[facet]
                listed.count[facet] = count
                for slot in range(listed.node.shape[0]):
                    listed.node[slot, facet] = wp.where(slot < count, made.node[slot, facet], -1)
                most = wp.where(count == TOO_MANY or most == TOO_MANY, TOO_MANY, wp.max(most, count))
        block_count[block] = most

    return adopt_lists


@cache
def begin_travel_kernel(real: type, lane_count: int):
    """Kernel over blocks of nodes: their ways begin anew with the lists; those without lists yet wait for the next."""
    lanes = lane_types(real, lane_count).lanes
    Search, Watch, Record = search_struct(real), watch_struct(real), record_struct(real, lane_count)

    @wp.kernel(module="unique", enable_backward=False)
    def begin_travel(first_block: wp.int32, search: Search, watch: Watch, record: Record):
        block = first_block + wp.tid()
        if watch.entry[PassEntry.rebuild] != wp.float64(0.0):
            travel = lanes()
            for i in range(lane_count):
                if watch.found[block * lane_count + i] == 1 and search.slot < 0:
                    travel[i] = search.skin
            record.rows[PlyRow.travel, block] = travel

    return begin_travel
