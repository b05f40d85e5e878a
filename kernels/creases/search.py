"""Search for creases that may touch, at every update of the stable step: lists by their owners, in ascending order."""

from functools import cache

import warp as wp

from ..pass_entries import PassEntry
from ..rows import MotionRow
from .data import GROUP, crease_search_struct, creases_struct, edges_struct, place_functions
from .pair_rows import CreaseCount, CreaseWorkRow, PairRow

# Angles between the facets of an edge [rad]: up to 20 degrees there is no crease, from 40 on it counts whole.
LEAST_TURN = wp.constant(0.349066)
WHOLE_TURN = wp.constant(0.698132)


@cache
def look_at_edges_kernel(real: type):
    """Kernel over groups of edges: how sharp each is, and how many creases there are, with free edges."""
    vec3 = wp.types.vector(3, real)
    Edges, Creases, Search = edges_struct(real), creases_struct(real), crease_search_struct(real)
    _, between = place_functions(real)

    @wp.func
    def into(edges: Edges, edge: int, place: int, along: vec3):
        """Unit vector across the edge into the facet whose other nodes are at ``place``."""
        across = between(edges, place, edge, 0, edge) + between(edges, place + 1, edge, 1, edge)
        return wp.normalize(across - (wp.dot(across, along) / wp.dot(along, along)) * along)

    @wp.kernel(module="unique", enable_backward=False)
    def look_at_edges(
        start: wp.int32, stride: wp.int32, edges: Edges, entry: wp.array(dtype=wp.float64), creases: Creases,
        search: Search,
    ):  # fmt: skip
        # free edges are always as sharp as an edge can be, and touch only where nodes come near to facets
        calm = creases.quiet[0] > real(0.0)
        if calm and entry[PassEntry.sought] == wp.float64(0.0):
            return
        for group in range(start + wp.tid(), search.of_group.shape[0], stride):
            count = wp.int32(0)
            largest = real(0.0)
            last = wp.min((group + 1) * GROUP, wp.where(calm, edges.free_count, edges.edge_count))
            for edge in range(group * GROUP, last):
                along = between(edges, 1, edge, 0, edge)
                one, other = into(edges, edge, 2, along), into(edges, edge, 4, along)
                turn = wp.acos(wp.clamp(-wp.dot(one, other), real(-1.0), real(1.0)))
                share = (turn - real(LEAST_TURN)) / (real(WHOLE_TURN) - real(LEAST_TURN))
                creases.weight[edge] = wp.clamp(share, real(0.0), real(1.0))
                creases.inward[0, edge] = one
                creases.inward[1, edge] = other
                count = count + wp.where(share > real(0.0), 1, 0)
                largest = wp.max(largest, wp.where(edge < edges.free_count, real(0.0), turn))
            search.of_group[group] = count
            search.largest_turn[group] = largest

    return look_at_edges


@cache
def sum_creases_kernel(real: type):
    """Kernel of one thread: where each group lists its creases, and how long there can be none."""
    Edges, Creases, Search = edges_struct(real), creases_struct(real), crease_search_struct(real)

    @wp.kernel(module="unique", enable_backward=False)
    def sum_creases(edges: Edges, entry: wp.array(dtype=wp.float64), creases: Creases, search: Search):
        reach = real(entry[PassEntry.reach])
        calm = creases.quiet[0] > real(0.0)
        if calm and entry[PassEntry.sought] == wp.float64(0.0):
            creases.quiet[0] = creases.quiet[0] - reach
            creases.number[CreaseCount.creases] = 0
            return
        total = wp.int32(0)
        largest = real(0.0)
        for group in range(search.of_group.shape[0]):
            count = search.of_group[group]
            search.of_group[group] = total
            total = total + count
            largest = wp.max(largest, search.largest_turn[group])
        left = wp.where(calm, creases.quiet[0], edges.turning * (real(LEAST_TURN) - largest))
        creases.quiet[0] = left - reach
        # a single crease meets nothing
        creases.number[CreaseCount.creases] = wp.where(total > 1, total, 0)

    return sum_creases


@cache
def list_creases_kernel(real: type):
    """Kernel over groups of edges: the list of all creases."""
    Edges, Creases, Search = edges_struct(real), creases_struct(real), crease_search_struct(real)

    @wp.kernel(module="unique", enable_backward=False)
    def list_creases(start: wp.int32, stride: wp.int32, edges: Edges, creases: Creases, search: Search):
        if creases.number[CreaseCount.creases] == 0:
            return
        for group in range(start + wp.tid(), search.of_group.shape[0], stride):
            place = search.of_group[group]
            for edge in range(group * GROUP, wp.min((group + 1) * GROUP, edges.edge_count)):
                if creases.weight[edge] > real(0.0):
                    creases.crease[place] = edge
                    place = place + 1

    return list_creases


@cache
def visit_functions(real: type):
    """wp.funcs: the box of an edge, with a margin; whether two edges may touch until the next update."""
    vec2, vec3, vec4 = wp.types.vector(2, real), wp.types.vector(3, real), wp.types.vector(4, real)
    Edges = edges_struct(real)
    row_at, _ = place_functions(real)

    @wp.func
    def box_of(edges: Edges, edge: int, margin: real):
        one, other = row_at(edges, 0, edge, MotionRow.position), row_at(edges, 1, edge, MotionRow.position)
        # contact may lie beyond the ends, where the next edge takes over
        spare = real(0.11) * wp.length(other - one) + margin
        room = vec3(spare, spare, spare)
        return wp.min(one, other) - room, wp.max(one, other) + room

    @wp.func
    def apart(low: vec3, high: vec3, other_low: vec3, other_high: vec3):
        result = False
        for c in range(3):
            result = result or low[c] > other_high[c] or other_low[c] > high[c]
        return result

    @wp.func
    def squared_way(point: vec2, segment: vec4):
        start = vec2(segment[0], segment[1])
        along = vec2(segment[2], segment[3]) - start
        at = wp.clamp(wp.dot(point - start, along) / wp.dot(along, along), real(0.0), real(1.0))
        away = point - start - at * along
        return wp.dot(away, away)

    @wp.func
    def are_neighbours(edges: Edges, edge: int, other: int):
        a, b = edges.flat[edge], edges.flat[other]
        way = wp.min(squared_way(vec2(a[0], a[1]), b), squared_way(vec2(a[2], a[3]), b))
        way = wp.min(way, wp.min(squared_way(vec2(b[0], b[1]), a), squared_way(vec2(b[2], b[3]), a)))
        return way < edges.squared_exclusion

    return box_of, apart, are_neighbours


@cache
def bound_creases_kernel(real: type):
    """Kernel over groups of creases: their boxes, with half the distance at which they touch and half of their way."""
    Edges, Creases, Search = edges_struct(real), creases_struct(real), crease_search_struct(real)
    box_of, _, _ = visit_functions(real)

    @wp.kernel(module="unique", enable_backward=False)
    def bound_creases(
        start: wp.int32, stride: wp.int32, edges: Edges, entry: wp.array(dtype=wp.float64), creases: Creases,
        search: Search,
    ):  # fmt: skip
        total = creases.number[CreaseCount.creases]
        margin = real(0.5) * (edges.thickness + real(entry[PassEntry.reach]))
        for group in range(start + wp.tid(), (total + GROUP - 1) // GROUP, stride):
            low, high = box_of(edges, creases.crease[group * GROUP], margin)
            for c in range(group * GROUP + 1, wp.min((group + 1) * GROUP, total)):
                own_low, own_high = box_of(edges, creases.crease[c], margin)
                low = wp.min(low, own_low)
                high = wp.max(high, own_high)
            search.low[group] = low
            search.high[group] = high

    return bound_creases


@cache
def list_pairs_kernel(real: type, counts: bool):
    """Kernel over creases: how many others may touch each; or their list, with what was kept of each pair."""
    Edges, Creases, Search = edges_struct(real), creases_struct(real), crease_search_struct(real)
    box_of, apart, are_neighbours = visit_functions(real)
    place_of, release = keep_functions(real)

    @wp.func
    def take(creases: Creases, search: Search, edge: int, other: int, place: int):
        """A new entry, with the rows of the old one."""
        search.partner[place] = other
        old = place_of(creases, edge, other)
        for row in range(creases.rows.shape[0]):
            search.rows[row, place] = wp.where(old >= 0, creases.rows[row, wp.max(old, 0)], real(0.0))
        if old < 0:
            search.rows[PairRow.depth, place] = real(-1.0)

    @wp.func
    def visit(edges: Edges, creases: Creases, search: Search, c: int, margin: real):
        edge, total = creases.crease[c], creases.number[CreaseCount.creases]
        low, high = box_of(edges, edge, margin)
        count = wp.int32(0)
        for group in range((total + GROUP - 1) // GROUP):
            if not apart(low, high, search.low[group], search.high[group]):
                for k in range(group * GROUP, wp.min((group + 1) * GROUP, total)):
                    other = creases.crease[k]
                    other_low, other_high = box_of(edges, other, margin)
                    # a crease ends at a free edge, opposite to others in its plane: both kinds meet their own
                    alike = (edge < edges.free_count) == (other < edges.free_count)
                    near = k != c and alike and not apart(low, high, other_low, other_high)
                    if near and not are_neighbours(edges, wp.min(edge, other), wp.max(edge, other)):
                        if wp.static(not counts) and count < search.count[c]:
                            take(creases, search, edge, other, search.first[c] + count)
                        count = count + 1
        return count

    @wp.func
    def let_go(edges: Edges, creases: Creases, search: Search, c: int, edge: int):
        """What pairs stored that are listed no longer is lost."""
        for old in range(creases.first[edge], creases.first[edge] + creases.count[edge]):
            listed = wp.int32(0)
            for place in range(search.first[c], search.first[c] + search.count[c]):
                listed = listed + wp.where(search.partner[place] == creases.partner[old], 1, 0)
            if listed == 0:
                release(edges, creases, edge, old)

    @wp.kernel(module="unique", enable_backward=False)
    def list_pairs(
        start: wp.int32, stride: wp.int32, edges: Edges, entry: wp.array(dtype=wp.float64), creases: Creases,
        search: Search,
    ):  # fmt: skip
        margin = real(0.5) * (edges.thickness + real(entry[PassEntry.reach]))
        for c in range(start + wp.tid(), creases.number[CreaseCount.creases], stride):
            if wp.static(counts):
                search.count[c] = visit(edges, creases, search, c, margin)
            elif search.count[c] > 0 or creases.count[creases.crease[c]] > 0:
                visit(edges, creases, search, c, margin)
                let_go(edges, creases, search, c, creases.crease[c])

    return list_pairs


@cache
def keep_functions(real: type):
    """wp.funcs: the entry of a pair in the lists so far, or -1; the loss of what a pair stores that ends."""
    Edges, Creases = edges_struct(real), creases_struct(real)

    @wp.func
    def place_of(creases: Creases, edge: int, other: int):
        result = wp.int32(-1)
        for place in range(creases.first[edge], creases.first[edge] + creases.count[edge]):
            if creases.partner[place] == other:
                result = place
        return result

    @wp.func
    def release(edges: Edges, creases: Creases, edge: int, place: int):
        other = creases.partner[place]
        if edge < other:
            press = creases.rows[PairRow.press, place]
            stiffness = creases.rows[PairRow.weight, place] * wp.min(edges.stiffness[edge], edges.stiffness[other])
            lost = wp.float64(real(0.5) * stiffness * press * press)
            creases.works[CreaseWorkRow.damping_loss, edge] = creases.works[CreaseWorkRow.damping_loss, edge] + lost

    return place_of, release


@cache
def sum_pairs_kernel(real: type):
    """Kernel of one thread: where each list begins; too many entries and deep contacts are told to the first pass."""
    Creases, Search = creases_struct(real), crease_search_struct(real)

    @wp.kernel(module="unique", enable_backward=False)
    def sum_pairs(creases: Creases, search: Search, entry: wp.array(dtype=wp.float64)):
        total = wp.int32(0)
        for c in range(creases.number[CreaseCount.creases]):
            search.first[c] = total
            total = total + search.count[c]
            deepest = wp.float64(creases.deepest[creases.crease[c]])
            entry[PassEntry.deepest] = wp.max(entry[PassEntry.deepest], deepest)
        if total > search.partner.shape[0]:
            # no pairs at all, rather than some of which only one edge knows: that ends the run
            for c in range(creases.number[CreaseCount.creases]):
                search.count[c] = 0
            total = 0
            creases.number[CreaseCount.late] = 1
            entry[PassEntry.late] = wp.float64(1.0)
        creases.number[CreaseCount.pairs] = total

    return sum_pairs


@cache
def adopt_pairs_kernel(real: type):
    """Kernel over creases, and over edges that are none: the new lists."""
    Edges, Creases, Search = edges_struct(real), creases_struct(real), crease_search_struct(real)
    _, release = keep_functions(real)

    @wp.func
    def adopt(creases: Creases, search: Search, c: int):
        edge = creases.crease[c]
        creases.first[edge] = search.first[c]
        creases.count[edge] = search.count[c]
        for place in range(search.first[c], search.first[c] + search.count[c]):
            creases.partner[place] = search.partner[place]
            for row in range(creases.rows.shape[0]):
                creases.rows[row, place] = search.rows[row, place]

    @wp.kernel(module="unique", enable_backward=False)
    def adopt_pairs(start: wp.int32, stride: wp.int32, creases: Creases, search: Search):
        for c in range(start + wp.tid(), creases.number[CreaseCount.creases], stride):
            adopt(creases, search, c)

    @wp.kernel(module="unique", enable_backward=False)
    def forget_pairs(start: wp.int32, stride: wp.int32, edges: Edges, creases: Creases):
        alone = creases.number[CreaseCount.creases] == 0
        for edge in range(start + wp.tid(), edges.edge_count, stride):
            if creases.count[edge] > 0 and (alone or creases.weight[edge] <= real(0.0)):
                for place in range(creases.first[edge], creases.first[edge] + creases.count[edge]):
                    release(edges, creases, edge, place)
                creases.count[edge] = 0

    return adopt_pairs, forget_pairs
