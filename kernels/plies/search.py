"""What is sought at every update of the stable step for one pass of an interface (docs/plies.md).

A node walks from facet to facet by itself. Sought are blocks of nodes that are too far away to touch, and feet of nodes
that have none; ``collect.py`` lists the nodes that may stand on each facet until the next update.
"""

from functools import cache

import warp as wp

from ..lane_types import lane_types
from ..lanes import lane_maximum
from ..machine import anew
from ..operators import add, div, mul, sub  # noqa: F401
from ..pass_entries import PassEntry
from ..records import SCALAR, record3, record4, store_record4, vector_of
from ..rows import MOTION_RECORD_LENGTH, PLY_RECORD_LENGTH, ClockEntry, MotionRow, PlyRow
from ..stepping.step import fold_works_function
from .data import FAR, LEAST_STRAY, NO_DEPTH, UNSOUGHT, is_missing, listed_struct, record_struct
from .facet import facets_struct, patch_at, patch_functions
from .stand import settle_function, settling_options

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
        group: wp.array2d(dtype=wp.int32)  # [place, group]: facets that lie together, or -1

    return Search


@cache
def watch_struct(real: type):
    """What the search leaves between its kernels; nothing that a result depends on outlives an update."""
    vec3 = wp.types.vector(3, real)

    @wp.struct
    class Watch:
        entry: wp.array(dtype=wp.float64)  # see PassEntry
        travel: wp.array(dtype=real)  # [block]: longest way of a node since the lists were made [m]
        late: wp.array(dtype=wp.int32)  # [block]: 1 if a pressed node had gone too far, or its facet lacked it
        deepest: wp.array(dtype=real)  # [block]: deepest penetration that makes a force [m]
        found: wp.array(dtype=wp.int32)  # [node]: 1 if it has just found a foot, or its facet lacks it
        foot: wp.array(dtype=vec3)  # [node]: place of its foot [m]
        stray: wp.array(dtype=wp.int32)  # nodes that have just found a foot
        drift: wp.array(dtype=real)  # [0]: how far nodes have moved since the boxes of groups of facets were made [m]
        low: wp.array(dtype=vec3)  # [group]: corners of the box of their middles [m]
        high: wp.array(dtype=vec3)
        radius: wp.array(dtype=real)  # [group]: largest radius of a facet [m]

    return Watch


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
        awake: wp.array(dtype=wp.int32),  # of the nodes' sheet: whether a pass needs its normals, as ``sum_up`` finds
        facets_awake: wp.array(dtype=wp.int32),  # of the facets' sheet
    ):
        # the first pass of a sheet on itself comes after those with other plies, and has the others follow
        if search.slot <= 0:
            awake[0] = 0
            facets_awake[0] = 0
        speed = wp.sqrt(largest(squared_speed)) + wp.sqrt(largest(facet_squared_speed))
        time = clock[ClockEntry.step] * wp.float64(search.steps)
        reach = wp.float64(SPEED_MARGIN) * time * wp.float64(speed)
        passed = watch.entry[PassEntry.reach]
        watch.entry[PassEntry.reach] = reach
        if search.slot == 0:
            quiet = watch.entry[PassEntry.quiet] - reach
            apart = watch.entry[PassEntry.apart] - reach
            sought = wp.where(quiet > wp.float64(0.0), 0, 1)
            sought = wp.where(apart > wp.float64(0.0), sought, 2)
            watch.entry[PassEntry.quiet] = quiet
            watch.entry[PassEntry.apart] = apart
            watch.entry[PassEntry.sought] = wp.float64(sought)
            # the search needs normals, too
            awake[0] = wp.min(sought, 1)
        # boxes of the last update have moved in the interval that is over
        drift = watch.drift[0] + real(passed)
        # 0: new boxes at this update
        watch.drift[0] = wp.where(drift < search.skin, drift, real(0.0))

    return plan_search


@cache
def way_functions(real: type):
    """wp.funcs (facets, facet, ...) -> middle and radius of a facet; way of a point to it."""
    vec3, Facets = wp.types.vector(3, real), facets_struct(real)

    @wp.func
    def corner_place(facets: Facets, facet: int, corner: int):
        entry = facets.corner[4 * facet + corner]
        return vec3(
            facets.motion[entry], facets.motion[entry + facets.stride], facets.motion[entry + 2 * facets.stride]
        )

    @wp.func
    def size_of(facets: Facets, facet: int):
        middle = vec3()
        for corner in range(4):
            middle = middle + real(0.25) * corner_place(facets, facet, corner)
        radius = real(0.0)
        for corner in range(4):
            radius = wp.max(radius, wp.length(corner_place(facets, facet, corner) - middle))
        return middle, radius

    @wp.func
    def way_to_facet(facets: Facets, facet: int, thickness: real, point: vec3):
        """How far a point may move before it is over a facet, or near above or below it [m]; negative if it is."""
        first = corner_place(facets, facet, 2) - corner_place(facets, facet, 0)
        second = corner_place(facets, facet, 3) - corner_place(facets, facet, 1)
        middle, radius = size_of(facets, facet)
        away = point - middle
        height = wp.dot(away, wp.normalize(wp.cross(first, second)))
        beside = wp.sqrt(wp.max(wp.dot(away, away) - height * height, real(0.0)))
        return wp.max(beside - real(NEAR) * radius, wp.abs(height) - radius - thickness)

    return size_of, way_to_facet


@cache
def bound_facets_kernel(real: type):
    """Kernel over groups of facets: boxes of their middles, where those of before are too old."""
    vec3 = wp.types.vector(3, real)
    Facets, Search, Watch = facets_struct(real), search_struct(real), watch_struct(real)
    size_of, _ = way_functions(real)

    @wp.kernel(module="unique", enable_backward=False)
    def bound_facets(first_group: wp.int32, facets: Facets, search: Search, watch: Watch):
        group = first_group + wp.tid()
        if watch.drift[0] > real(0.0):
            return
        low = vec3(real(FAR))
        high = vec3(-real(FAR))
        largest = real(0.0)
        for place in range(search.group.shape[0]):
            facet = search.group[place, group]
            if facet >= 0:
                middle, radius = size_of(facets, facet)
                low = wp.min(low, middle)
                high = wp.max(high, middle)
                largest = wp.max(largest, radius)
        watch.low[group] = low
        watch.high[group] = high
        watch.radius[group] = largest

    return bound_facets


@cache
def nearest_facet_function(real: type):
    """wp.func (facets, search, watch, start, point) -> facet to which the point has the shortest way, and that way.

    Of equal ways, to the lowest facet: as a look through all of them finds. Groups are passed over by their boxes.
    """
    vec3 = wp.types.vector(3, real)
    Facets, Search, Watch = facets_struct(real), search_struct(real), watch_struct(real)
    _, way_to_facet = way_functions(real)

    @wp.func
    def least_way(search: Search, watch: Watch, group: int, point: vec3):
        """No way to a facet of a group is shorter."""
        drift = watch.drift[0]
        beyond = wp.max(wp.max(watch.low[group] - point, point - watch.high[group]), vec3())
        radius = watch.radius[group] + real(2.0) * drift
        # away^2 = beside^2 + height^2, so that one of them is 0.7 of it
        return real(0.7) * (wp.length(beyond) - drift) - wp.max(real(NEAR) * radius, radius + search.thickness)

    @wp.func
    def nearest_facet(facets: Facets, search: Search, watch: Watch, start: int, point: vec3):
        best = start
        way = way_to_facet(facets, start, search.thickness, point)
        for group in range(search.group.shape[1]):
            if not least_way(search, watch, group, point) > way:
                for place in range(search.group.shape[0]):
                    facet = search.group[place, group]
                    if facet >= 0:
                        other = way_to_facet(facets, facet, search.thickness, point)
                        if other < way or (other == way and facet < best):
                            way = other
                            best = facet
        return best, way

    return nearest_facet


@cache
def new_feet_functions(real: type, lane_count: int):
    """wp.funcs that write the feet of nodes that have just found one: within a sheet, and on another."""
    lanes, Listed = lane_types(real, lane_count).lanes, listed_struct()
    Facets, Search, Watch = facets_struct(real), search_struct(real), watch_struct(real)
    Record, settle = record_struct(real, lane_count), settle_function(real, lane_count)

    @wp.func
    def take_own_feet(record: Record, block: int, watch: Watch):
        """Within a sheet, feet have been found before."""
        travel = record.rows[PlyRow.travel, block]
        force = record4(record.rows, PLY_RECORD_LENGTH, PlyRow.force, block)
        drag = record4(record.rows, PLY_RECORD_LENGTH, PlyRow.drag, block)
        for i in range(lane_count):
            node = block * lane_count + i
            if watch.found[node] == 1:
                travel[i] = real(0.0)
                force[SCALAR, i] = watch.foot[node][0]
                drag[SCALAR, i] = watch.foot[node][1]
        record.rows[PlyRow.travel, block] = travel
        store_record4(record.rows, PLY_RECORD_LENGTH, PlyRow.force, block, vector_of(force), force[SCALAR])
        store_record4(record.rows, PLY_RECORD_LENGTH, PlyRow.drag, block, vector_of(drag), drag[SCALAR])

    @wp.func
    def settle_feet(
        facets: Facets, search: Search, motion: wp.array2d(dtype=lanes), record: Record, block: int, listed: Listed,
        watch: Watch, wakes: int,
    ):  # fmt: skip
        """Find the feet of nodes that the old lists may lack: those are listed as ones that have just found a foot."""
        stray = record.rows[PlyRow.stray, block]
        travel = record.rows[PlyRow.travel, block]
        chosen = lanes()
        for i in range(lane_count):
            node = block * lane_count + i
            if not stray[i] > real(0.0):
                if travel[i] >= search.skin or is_missing(listed, record.facet[block][i], node):
                    watch.found[node] = 1
                chosen[i] = real(wp.max(watch.found[node], wakes))
        if lane_maximum(chosen) > real(0.0):
            facet, under_way = settle(facets, motion, record, block, chosen)
            here = anew(block)
            travel = record.rows[PlyRow.travel, here]
            for i in range(lane_count):
                node = block * lane_count + i
                if facet[i] != record.facet[here][i]:
                    watch.found[node] = 1
                if watch.found[node] == 1:
                    travel[i] = search.skin * under_way[i]
            record.facet[here] = facet
            record.rows[PlyRow.travel, block] = travel

    return take_own_feet, settle_feet


@cache
def seek_feet_kernel(real: type, lane_count: int):
    """Kernel over blocks of nodes: which blocks to watch, and feet for nodes that have none."""
    types = lane_types(real, lane_count)
    lanes, lanes3, vec3 = types.lanes, types.lanes3, types.vec3
    Facets, Search, Watch = facets_struct(real), search_struct(real), watch_struct(real)
    Record, Listed = record_struct(real, lane_count), listed_struct()
    vectors = patch_functions(real, lane_count)[0]
    take_own_feet, settle_feet = new_feet_functions(real, lane_count)
    nearest_facet, fold_works = nearest_facet_function(real), fold_works_function(real, lane_count)

    @wp.func
    def seek_foot(
        facets: Facets, search: Search, watch: Watch, position: lanes3, record: Record, block: int, lane: int,
        updates: real,
    ):  # fmt: skip
        """Way that a stray node has left, 0 with a foot; its facet is written.

        It is sought anew where less is left than both plies move in ``updates`` updates.
        """
        reach = real(watch.entry[PassEntry.reach])
        left = record.rows[PlyRow.stray, block][lane] - reach
        if left < updates * reach or left <= real(0.0):
            point = vec3(position[0, lane], position[1, lane], position[2, lane])
            feet = record.facet[block]
            facet, way = nearest_facet(facets, search, watch, feet[lane], point)
            # at the end of the coming interval
            left = wp.where(way > real(0.0), wp.max(way - reach, real(LEAST_STRAY)), real(0.0))
            if way <= real(0.0):
                feet[lane] = facet
                record.facet[block] = feet
        return left

    @wp.func
    def free_way(search: Search, reach: real, depth: lanes, stray: lanes):
        """Smallest way of a node of the block from the next update on until it touches [m]; 0 where not known."""
        result = real(UNSOUGHT)
        for i in range(lane_count):
            free = stray[i]
            if stray[i] <= real(0.0):
                free = real(0.0)
                if depth[i] > real(0.5) * real(NO_DEPTH):
                    free = real(-0.7) * depth[i] - real(0.2) * search.thickness - reach
            result = wp.min(result, free)
        return result

    @wp.func
    def watch_block(search: Search, reach: real, record: Record, block: int):
        """1 if the block wakes; it is watched until the next update where its way is 0."""
        old = record.way[block]
        way = old - reach
        if not old > real(0.0):
            way = free_way(search, reach, record.rows[PlyRow.depth, block], record.rows[PlyRow.stray, block])
        sleeps = way > real(LEAST_UPDATES) * reach and (reach > real(0.0) or search.slot >= 0)
        record.way[block] = wp.where(sleeps, way, real(0.0))
        return wp.where(old > real(0.0) and not sleeps, 1, 0)

    @wp.func
    def note_travel(search: Search, record: Record, block: int, listed: Listed, watch: Watch):
        """How far nodes have moved, and whether a pressed one has moved past the facets on which it was listed."""
        travel = record.rows[PlyRow.travel, block]
        late = wp.int32(0)
        for i in range(lane_count):
            facet = record.standing[block][i]
            if facet >= 0:
                missing = search.slot < 0 and is_missing(listed, facet, block * lane_count + i)
                late = wp.where(missing or travel[i] > search.skin, 1, late)
        watch.late[block] = late
        watch.travel[block] = lane_maximum(travel)
        watch.deepest[block] = lane_maximum(record.rows[PlyRow.depth, block] - record.rows[PlyRow.entry, block])

    @wp.func
    def note_feet(facets: Facets, record: Record, block: int, watch: Watch):
        xi = record4(record.rows, PLY_RECORD_LENGTH, PlyRow.force, block)[SCALAR]
        eta = record4(record.rows, PLY_RECORD_LENGTH, PlyRow.drag, block)[SCALAR]
        feet = patch_at(vectors(facets, record.facet[block], MotionRow.position), xi, eta)
        for i in range(lane_count):
            watch.foot[block * lane_count + i] = vec3(feet[0, i], feet[1, i], feet[2, i])

    @wp.kernel(module="unique", enable_backward=False, **settling_options(real))
    def seek_feet(
        # In
        first_block: wp.int32,
        facets: Facets,
        search: Search,
        motion: wp.array2d(dtype=lanes),  # of the nodes
        listed: Listed,  # in the interval that is over
        # Out
        record: Record,
        watch: Watch,
        works_sum: wp.array2d(dtype=wp.float64),  # of all steps before the last ones [J]
    ):
        if watch.entry[PassEntry.busy] == wp.float64(0.0):
            return
        block = first_block + wp.tid()
        fold_works(block, record.works, works_sum)
        reach = real(watch.entry[PassEntry.reach])
        position = record3(motion, MOTION_RECORD_LENGTH, MotionRow.position, block)
        stray = record.rows[PlyRow.stray, block]
        # a block that is watched anyway need not know whether it may sleep
        updates = wp.where(lane_maximum(-stray) >= real(0.0), real(1.0), real(LEAST_UPDATES))
        for i in range(lane_count):
            node = block * lane_count + i
            if stray[i] > real(0.0):
                stray[i] = seek_foot(facets, search, watch, position, record, block, i, updates)
                watch.found[node] = wp.where(stray[i] <= real(0.0), 1, 0)
            elif search.slot < 0:
                watch.found[node] = 0
        record.rows[PlyRow.stray, block] = stray
        wakes = watch_block(search, reach, record, block)
        note_travel(search, record, block, listed, watch)
        if search.slot >= 0:
            take_own_feet(record, block, watch)
        else:
            settle_feet(facets, search, motion, record, block, listed, watch, wakes)
        note_feet(facets, record, block, watch)
        if wakes == 1:
            # within a sheet, lists are made anew at the next update
            if search.slot >= 0:
                record.rows[PlyRow.travel, block] = lanes(search.skin)
            else:
                watch.travel[block] = search.skin

    return seek_feet
