"""Forces of the nodes of another ply on the facets under them, added to the corner forces of the elements.

Each element gathers from the nodes that may stand on it, in the order of their numbers: without atomics, and the same
bits for any number of threads.
"""

from functools import cache

import warp as wp

from ..lanes import lane_maximum, lane_types, scale, step_options
from ..operators import div, mul  # noqa: F401
from ..records import SCALAR, gather4, record4, store_record4, vector_of
from ..rows import CORNER_ROW_COUNT, PLY_RECORD_LENGTH, ROWS_PER_CORNER, CornerRow, PlyRow
from .data import TOO_MANY
from .facet import corner_weight


@cache
def reaction_struct(real: type, lane_count: int):
    """What one pass leaves for the facets."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Reaction:
        listed: wp.array2d(dtype=types.indices)  # [slot, block of facets]: nodes that may stand on them, or -1
        count: wp.array(dtype=wp.int32)  # [block]: slots in use, or TOO_MANY
        standing: wp.array(dtype=wp.int32)  # [node]: facet on which it is pressed, or -1
        rows: wp.array(dtype=real)  # flat; see PlyRow
        row_count: wp.int32  # entries between two blocks of nodes over the lane count
        stride: wp.int32  # entries between two rows of a record

    return Reaction


@cache
def push_facets_kernel(real: type, lane_count: int):
    """Kernel over blocks of elements, launched after those of their own forces."""
    types = lane_types(real, lane_count)
    lanes, lanes3, indices = types.lanes, types.lanes3, types.indices
    Reaction = reaction_struct(real, lane_count)
    # one lane keeps whole rows
    record_length = 1 if lane_count == 1 else PLY_RECORD_LENGTH

    @wp.struct
    class Push:
        first: lanes3
        second: lanes3
        third: lanes3
        fourth: lanes3

    @wp.func
    def stand_here(reaction: Reaction, node: indices, block: int):
        """1 in the lanes on whose facet the node is pressed, else 0."""
        result = lanes()
        for i in range(lane_count):
            if node[i] >= 0 and reaction.standing[wp.max(node[i], 0)] == block * lane_count + i:
                result[i] = real(1.0)
        return result

    @wp.func
    def entries(reaction: Reaction, node: indices):
        result = indices()
        for i in range(lane_count):
            place = wp.max(node[i], 0)
            block = place / lane_count
            lane = place - block * lane_count
            result[i] = block * lane_count * reaction.row_count + lane * record_length
        return result

    @wp.func
    def push_corners(reaction: Reaction, node: indices, here: lanes, push: Push):
        entry = entries(reaction, node)
        stride = reaction.stride
        force = gather4(reaction.rows, entry, PlyRow.force * stride, stride)
        drag = gather4(reaction.rows, entry, PlyRow.drag * stride, stride)
        xi = force[SCALAR]
        eta = drag[SCALAR]
        back = vector_of(force)
        push.first = push.first - scale(here * corner_weight(0, xi, eta), back)
        push.second = push.second - scale(here * corner_weight(1, xi, eta), back)
        push.third = push.third - scale(here * corner_weight(2, xi, eta), back)
        push.fourth = push.fourth - scale(here * corner_weight(3, xi, eta), back)
        return push

    @wp.func
    def add(corners: wp.array2d(dtype=lanes), block: int, corner: int, push: lanes3):
        row = CornerRow.force + corner * ROWS_PER_CORNER
        piece = record4(corners, CORNER_ROW_COUNT, row, block)
        store_record4(corners, CORNER_ROW_COUNT, row, block, vector_of(piece) + push, piece[SCALAR])

    @wp.kernel(module="unique", enable_backward=False, module_options=step_options(real))
    def push_facets(
        # In
        first_block: wp.int32,
        reaction: Reaction,
        # Out
        corners: wp.array2d(dtype=lanes),  # rows: see CornerRow
    ):
        block = first_block + wp.tid()
        push = Push()
        count = reaction.count[block]
        slots = count
        if count == TOO_MANY:
            slots = reaction.standing.shape[0]
        pressed = wp.int32(0)
        for slot in range(slots):
            node = indices(slot)
            if count != TOO_MANY:
                node = reaction.listed[slot, block]
            here = stand_here(reaction, node, block)
            if lane_maximum(here) > real(0.0):
                push = push_corners(reaction, node, here, push)
                pressed = 1
        if pressed == 1:
            add(corners, block, 0, push.first)
            add(corners, block, 1, push.second)
            add(corners, block, 2, push.third)
            add(corners, block, 3, push.fourth)

    return push_facets
