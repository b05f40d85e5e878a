"""What one thread sums up at every update of the search between plies, from groups of blocks that threads surveyed.

One thread alone would take milliseconds to look through a large sheet on a GPU. Largest values do not depend on the
order, and strays are listed in ascending order, so that groups change no bit.
"""

from functools import cache

import warp as wp

from ..rows import PassEntry
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
        watched: wp.array(dtype=wp.int32)  # 1 if a block of it is watched
        stray: wp.array(
            dtype=wp.int32
        )  # [group of nodes]: how many have just found a foot; then the place of the first

    return Survey


@cache
def group_speed_kernel(real: type):
    """Kernel over groups of blocks of nodes: their largest squared speed [m^2/s^2]."""

    @wp.kernel(module="unique", enable_backward=False)
    def group_speed(squared_speed: wp.array(dtype=real), largest: wp.array(dtype=real)):
        group = wp.tid()
        first = group * GROUP
        result = real(0.0)
        for block in range(first, wp.min(first + GROUP, squared_speed.shape[0])):
            result = wp.max(result, squared_speed[block])
        largest[group] = result

    return group_speed


@cache
def survey_groups_kernel(real: type):
    """Kernel over groups of blocks of nodes."""
    Watch, Survey = watch_struct(real), survey_struct(real)

    @wp.kernel(module="unique", enable_backward=False)
    def survey_groups(watch: Watch, way: wp.array(dtype=real), survey: Survey):
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
                watched = 1
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
    def sum_up(search: Search, watch: Watch, survey: Survey, awake: wp.array(dtype=wp.int32)):
        longest = real(0.0)
        late = watch.entry[PassEntry.late]
        deepest = real(watch.entry[PassEntry.deepest])
        # the first of a sheet's passes begins anew; contact between plies needs its normals always
        wakes = wp.where(search.slot > 0, awake[0], 0)
        if search.slot < 0:
            wakes = 1
        for group in range(survey.travel.shape[0]):
            longest = wp.max(longest, survey.travel[group])
            late = wp.max(late, wp.float64(survey.late[group]))
            deepest = wp.max(deepest, survey.deepest[group])
            wakes = wp.max(wakes, survey.watched[group])
        total = wp.int32(0)
        for group in range(survey.stray.shape[0]):
            count = survey.stray[group]
            survey.stray[group] = total
            total = total + count
        watch.entry[PassEntry.late] = late
        watch.entry[PassEntry.deepest] = wp.float64(deepest)
        awake[0] = wakes
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
        group = wp.tid()
        first = group * GROUP
        place = survey.stray[group]
        for node in range(first, wp.min(first + GROUP, watch.found.shape[0])):
            if watch.found[node] == 1:
                watch.stray[place] = node
                place = place + 1

    return list_strays
