"""Contact of creases in a step: forces on the ends of the edges, and those of the nodes.

Both edges of a pair compute it, from the same numbers in the same order, and each writes what is its own: no atomics.
"""

from functools import cache

import warp as wp

from ..rows import ClockEntry
from .data import creases_struct, edges_struct
from .pair import SUDDEN_WEIGHT, pair_force_function, pair_function
from .pair_rows import CreaseCount, PairRow


@cache
def meet_creases_kernel(real: type):
    """Kernel over creases, each thread every ``stride``-th of them, before anything moves."""
    vec3 = wp.types.vector(3, real)
    Edges, Creases = edges_struct(real), creases_struct(real)
    (meet, _), force_of = pair_function(real), pair_force_function(real)

    @wp.kernel(module="unique", enable_backward=False)
    def meet_creases(
        start: wp.int32, stride: wp.int32, edges: Edges, clock: wp.array(dtype=wp.float64), creases: Creases
    ):
        step = real(clock[ClockEntry.mean_step])
        for c in range(start + wp.tid(), creases.number[CreaseCount.creases], stride):
            edge = creases.crease[c]
            begin = vec3()
            end = vec3()
            for place in range(creases.first[edge], creases.first[edge] + creases.count[edge]):
                other = creases.partner[place]
                pair = meet(edges, creases, wp.min(edge, other), wp.max(edge, other))
                if pair.weight > real(0.0) or creases.rows[PairRow.press, place] > real(0.0):
                    force = force_of(edges, creases, pair, edge, other, place, step)
                    at = wp.where(edge < other, pair.first, pair.second)
                    force = wp.where(edge < other, real(1.0), real(-1.0)) * force
                    begin = begin + (real(1.0) - at) * force
                    end = end + at * force
                    press, entry = creases.rows[PairRow.press, place], creases.rows[PairRow.entry, place]
                    # of a contact that hardly pushes, the depth says nothing
                    if pair.weight > real(SUDDEN_WEIGHT):
                        creases.deepest[edge] = wp.max(creases.deepest[edge], press)
                    creases.largest_entry[edge] = wp.max(creases.largest_entry[edge], entry)
                else:
                    creases.rows[PairRow.depth, place] = real(-1.0)
            creases.force[0, edge] = begin
            creases.force[1, edge] = end

    return meet_creases


@cache
def gather_creases_kernel(real: type):
    """Kernel over nodes, after the passes of the nodes: the forces of their edges are added, in order."""
    Creases = creases_struct(real)

    @wp.kernel(module="unique", enable_backward=False)
    def gather_creases(
        # In
        first_node: wp.int32,
        last_node: wp.int32,  # one past the end
        stride: wp.int32,
        around: wp.array2d(dtype=wp.int32),  # [slot, node]: twice the edge, and its end; -1 for none
        creases: Creases,
        # Out
        total: wp.array2d(dtype=real),  # [component, node]
    ):
        if creases.number[CreaseCount.pairs] == 0:
            return
        for node in range(first_node + wp.tid(), last_node, stride):
            for slot in range(around.shape[0]):
                code = around[slot, node]
                if code >= 0 and creases.count[code // 2] > 0:
                    force = creases.force[code % 2, code // 2]
                    for c in range(3):
                        total[c, node] = total[c, node] + force[c]

    return gather_creases
