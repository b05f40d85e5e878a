"""What is collected at every update of the search between plies: sums, and lists of nodes.

One thread alone would take milliseconds to look through a large sheet on a GPU: threads survey groups of blocks before.
Largest values do not depend on the order, and strays are listed in ascending order, so that groups change no bit. Nodes
that may stand on a facet until the next update are listed by its owner, in ascending order: no atomics, and the same
bits for any number of threads.
"""

from functools import cache

import warp as wp

from ..lane_types import lane_types
from ..lanes import dot, lane_maximum
from ..pass_entries import PassEntry
from ..records import record3
from ..rows import MOTION_RECORD_LENGTH, MotionRow, PlyRow
from .data import TOO_MANY, UNSOUGHT, listed_struct, record_struct
from .facet import facets_struct
from .search import search_struct, watch_struct

# Blocks, or nodes, that one thread looks through.
GROUP = wp.constant(256)


@cache
def survey_struct(real: type):
    """What was found in each group of blocks, or of nodes."""

    @wp.struct
    class Survey:
        travel: wp.array(dtype=real)  # longest way of a node since the lists were made [m]
        deepest: wp.array(dtype=real)  # deepest penetration that makes a force [m]
        late: wp.array(dtype=wp.int32)  # 1 if a pressed node had gone too far
        watched: wp.array(dtype=wp.int32)  # 2 if a block of it is watched, 1 if a node follows a facet, or seeks one
        stray: wp.array(
            dtype=wp.int32
        )  # [group of nodes]: how many have just found a foot; then the place of the first

    return Survey


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
def survey_groups_kernel(real: type):
    """Kernel over groups of blocks of nodes."""
    Watch, Survey = watch_struct(real), survey_struct(real)

    @wp.kernel(module="unique", enable_backward=False)
    def survey_groups(watch: Watch, way: wp.array(dtype=real), survey: Survey):
        if watch.entry[PassEntry.busy] == wp.float64(0.0):
            return
        group = wp.tid()
        first = group * GROUP
        travel = real(0.0)
        deepest = watch.deepest[first]
        late = wp.int32(0)
        watched = wp.int32(0)
        for block in range(first, wp.min(first + GROUP, way.shape[0])):
            travel = wp.max(travel, watch.travel[block])
            deepest = wp.max(deepest, watch.deepest[block])
            late = wp.max(late, watch.late[block])
            if not way[block] > real(0.0):
                watched = 2
            elif way[block] < real(0.5) * real(UNSOUGHT):
                watched = wp.max(watched, 1)
        survey.travel[group] = travel
        survey.deepest[group] = deepest
        survey.late[group] = late
        survey.watched[group] = watched

    return survey_groups


@cache
def count_strays_kernel(real: type):
    """Kernel over groups of nodes: how many have just found a foot."""
    Watch, Survey = watch_struct(real), survey_struct(real)

    @wp.kernel(module="unique", enable_backward=False)
    def count_strays(watch: Watch, survey: Survey):
        if watch.entry[PassEntry.busy] == wp.float64(0.0):
            return
        group = wp.tid()
        first = group * GROUP
        count = wp.int32(0)
        for node in range(first, wp.min(first + GROUP, watch.found.shape[0])):
            count = count + watch.found[node]
        survey.stray[group] = count

    return count_strays


@cache
def sum_up_kernel(real: type):
    """Kernel of one thread: whether lists are made anew, and where each group lists its strays."""
    Search, Watch, Survey = search_struct(real), watch_struct(real), survey_struct(real)

    @wp.kernel(module="unique", enable_backward=False)
    def sum_up(
        search: Search, watch: Watch, survey: Survey, awake: wp.array(dtype=wp.int32),
        facets_awake: wp.array(dtype=wp.int32),
    ):  # fmt: skip
        if watch.entry[PassEntry.busy] == wp.float64(0.0):
            watch.entry[PassEntry.rebuild] = wp.float64(0.0)
            return
        longest = real(0.0)
        late = watch.entry[PassEntry.late]
        deepest = real(watch.entry[PassEntry.deepest])
        watched = wp.int32(0)
        for group in range(survey.travel.shape[0]):
            longest = wp.max(longest, survey.travel[group])
            late = wp.max(late, wp.float64(survey.late[group]))
            deepest = wp.max(deepest, survey.deepest[group])
            watched = wp.max(watched, survey.watched[group])
        total = wp.int32(0)
        for group in range(survey.stray.shape[0]):
            count = survey.stray[group]
            survey.stray[group] = total
            total = total + count
        watch.entry[PassEntry.late] = late
        watch.entry[PassEntry.deepest] = wp.float64(deepest)
        watch.entry[PassEntry.watched] = wp.float64(watched // 2)
        watch.entry[PassEntry.followed] = wp.float64(wp.min(watched, 1))
        # ``plan_search`` began with 0
        awake[0] = wp.max(awake[0], watched // 2)
        facets_awake[0] = wp.max(facets_awake[0], watched // 2)
        watch.entry[PassEntry.stray_count] = wp.float64(total)
        rebuild = total > 0 or longest > real(0.5) * search.skin
        watch.entry[PassEntry.rebuild] = wp.where(rebuild, wp.float64(1.0), wp.float64(0.0))

    return sum_up


@cache
def list_strays_kernel(real: type):
    """Kernel over groups of nodes: list those that have just found a foot."""
    Watch, Survey = watch_struct(real), survey_struct(real)

    @wp.kernel(module="unique", enable_backward=False)
    def list_strays(watch: Watch, survey: Survey):
        if watch.entry[PassEntry.busy] == wp.float64(0.0):
            return
        group = wp.tid()
        first = group * GROUP
        place = survey.stray[group]
        for node in range(first, wp.min(first + GROUP, watch.found.shape[0])):
            if watch.found[node] == 1:
                watch.stray[place] = node
                place = place + 1

    return list_strays


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
    """Kernel over blocks of nodes: their ways begin anew with the lists."""
    Watch, Record = watch_struct(real), record_struct(real, lane_count)

    @wp.kernel(module="unique", enable_backward=False)
    def begin_travel(first_block: wp.int32, watch: Watch, record: Record):
        block = first_block + wp.tid()
        if watch.entry[PassEntry.rebuild] != wp.float64(0.0):
            travel = record.rows[PlyRow.travel, block]
            for i in range(lane_count):
                # ``seek_feet`` has told those of nodes that have just found a foot
                if watch.found[block * lane_count + i] == 0:
                    travel[i] = real(0.0)
            record.rows[PlyRow.travel, block] = travel

    return begin_travel


@cache
def settle_own_search_kernel(real: type):
    """Kernel of one thread: how far a sheet may move before it is searched again, and which passes are busy."""
    Entries = wp.array(dtype=wp.float64)

    @wp.func
    def way_of(urgency: wp.array(dtype=real)):
        largest = real(1.0) / real(UNSOUGHT)
        for k in range(urgency.shape[0]):
            largest = wp.max(largest, urgency[k])
        return wp.where(largest < real(0.5) * real(UNSOUGHT), wp.float64(1.0) / wp.float64(largest), wp.float64(0.0))

    @wp.func
    def settle(entry: Entries, near: wp.float64):
        entry[PassEntry.busy] = wp.max(near, entry[PassEntry.followed])

    @wp.kernel(module="unique", enable_backward=False)
    def settle_own_search(
        # In
        urgency: wp.array(dtype=real),  # see ``found_struct``; largest ones of many groups
        far_urgency: wp.array(dtype=real),
        # Out
        first: Entries,  # of the four passes: see PassEntry
        second: Entries,
        third: Entries,
        fourth: Entries,
        awake: wp.array(dtype=wp.int32),  # whether the passes need normals, as ``sum_up`` finds
    ):
        awake[0] = 0
        near = wp.float64(0.0)
        if first[PassEntry.sought] > wp.float64(0.0):
            first[PassEntry.quiet] = way_of(urgency)
            if first[PassEntry.sought] > wp.float64(1.0):
                first[PassEntry.apart] = way_of(far_urgency)
            if wp.min(first[PassEntry.quiet], first[PassEntry.apart]) <= wp.float64(0.0):
                near = wp.float64(1.0)
        settle(first, near)
        settle(second, near)
        settle(third, near)
        settle(fourth, near)

    return settle_own_search
