"""Forces of the nodes of another ply on the facets under them, added to the corner forces of the elements.

Each element gathers from the nodes that may stand on it, in the order of their numbers: without atomics, and the same
bits for any number of threads.
"""

from functools import cache

import warp as wp

from ..lane_types import CPU_LANE_COUNT, GPU_LANE_COUNT, lane_types, step_options
from ..lanes import scale
from ..pass_entries import PassEntry
from ..records import SCALAR, gather4, record4, store_record4, vector_of
from ..rows import CORNER_ROW_COUNT, PLY_RECORD_LENGTH, ROWS_PER_CORNER, CornerRow, PlyRow
from .data import TOO_MANY, blocks_per_call
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
        stride: wp.int32  # entries between two rows of a record
        row_count: wp.int32  # rows of a block of nodes, with lanes
        entry: wp.array(dtype=wp.float64)  # see PassEntry

    return Reaction


_Index = lane_types(wp.float32, GPU_LANE_COUNT).indices

for _real in (wp.float32, wp.float64):
    _one, _many = lane_types(_real, GPU_LANE_COUNT), lane_types(_real, CPU_LANE_COUNT)
    _scalar = "float" if _real is wp.float32 else "double"

    @wp.func
    def push_block(
        listed: wp.array2d(dtype=_one.indices), count: wp.int32, standing: wp.array(dtype=wp.int32),
        rows: wp.array(dtype=_real), stride: wp.int32, row_count: wp.int32, corners: wp.array2d(dtype=_one.lanes),
        block: wp.int32,
    ):  # fmt: skip
        """Subtract the shares of the corners in the forces of the nodes that are pressed on a block of facets."""
        slots = count
        if count == TOO_MANY:
            slots = standing.shape[0]
        for slot in range(slots):
            node = slot
            if count != TOO_MANY:
                node = listed[slot, block][0]
            if node >= 0 and standing[wp.max(node, 0)] == block:
                entry = _Index(node)
                force = gather4(rows, entry, PlyRow.force * stride, stride)
                drag = gather4(rows, entry, PlyRow.drag * stride, stride)
                for corner in range(4):
                    row = CornerRow.force + corner * ROWS_PER_CORNER
                    piece = record4(corners, CORNER_ROW_COUNT, row, block)
                    share = scale(corner_weight(corner, force[SCALAR], drag[SCALAR]), vector_of(force))
                    store_record4(corners, CORNER_ROW_COUNT, row, block, vector_of(piece) - share, piece[SCALAR])

    # Few nodes are pressed on a facet: one is sooner done with its four corners than sixteen are gathered into lanes.
    @wp.func_native(f"""
        using Piece = {_scalar} __attribute__((ext_vector_type(4)));
        constexpr int lanes = {CPU_LANE_COUNT};
        const int first = lanes * block;
        auto *own = reinterpret_cast<{_scalar} *>(reinterpret_cast<char *>(corners.data) + corners.strides[1] * block);
        auto push = [&](int node, int lane) {{
            const {_scalar} *record = rows.data + node / lanes * lanes * row_count
                + node % lanes * {PLY_RECORD_LENGTH};
            const {_scalar} xi = record[{int(PlyRow.xi)}], eta = record[{int(PlyRow.eta)}];
            const {_scalar} quarter = 0.25;
            const {_scalar} weight[4] = {{
                quarter * ((1 - xi) * (1 - eta)), quarter * ((1 + xi) * (1 - eta)),
                quarter * ((1 + xi) * (1 + eta)), quarter * ((1 - xi) * (1 + eta))}};
            Piece force;
            __builtin_memcpy(&force, record + {int(PlyRow.force)}, sizeof(force));
            force[3] = 0;
            {_scalar} *place = own + {CORNER_ROW_COUNT} * lane + {int(CornerRow.force)};
            for (int corner = 0; corner < 4; ++corner, place += {ROWS_PER_CORNER}) {{
                Piece sum;
                __builtin_memcpy(&sum, place, sizeof(sum));
                sum -= weight[corner] * force;
                __builtin_memcpy(place, &sum, sizeof(sum));
            }}
        }};
        if (count == {int(TOO_MANY)}) {{
            for (int node = 0; node < standing.shape[0]; ++node)
                if (standing.data[node] >= first && standing.data[node] < first + lanes)
                    push(node, standing.data[node] - first);
            return;
        }}
        for (int slot = 0; slot < count; ++slot) {{
            const int *node = reinterpret_cast<const int *>(
                reinterpret_cast<const char *>(listed.data) + listed.strides[0] * slot + listed.strides[1] * block);
            unsigned here = 0;
            for (int lane = 0; lane < lanes; ++lane)
                here |= unsigned(node[lane] >= 0 && standing.data[node[lane] < 0 ? 0 : node[lane]] == first + lane)
                    << lane;
            for (; here; here &= here - 1)
                push(node[__builtin_ctz(here)], __builtin_ctz(here));
        }}
    """)
    def push_block(
        listed: wp.array2d(dtype=_many.indices), count: wp.int32, standing: wp.array(dtype=wp.int32),
        rows: wp.array(dtype=_real), stride: wp.int32, row_count: wp.int32, corners: wp.array2d(dtype=_many.lanes),
        block: wp.int32,
    ): ...  # fmt: skip


@cache
def push_facets_kernel(real: type, lane_count: int):
    """Kernel over groups of blocks of elements, launched after those of their own forces."""
    lanes = lane_types(real, lane_count).lanes
    Reaction = reaction_struct(real, lane_count)
    span = blocks_per_call(lane_count)

    @wp.kernel(module="unique", enable_backward=False, module_options=step_options(real))
    def push_facets(
        # In
        first_block: wp.int32,
        last_block: wp.int32,  # one past the end
        reaction: Reaction,
        # Out
        corners: wp.array2d(dtype=lanes),  # rows: see CornerRow
    ):
        if reaction.entry[PassEntry.watched] == wp.float64(0.0):
            return
        first = first_block + span * wp.tid()
        for block in range(first, wp.min(first + span, last_block)):
            push_block(
                reaction.listed, reaction.count[block], reaction.standing, reaction.rows, reaction.stride,
                reaction.row_count, corners, block,
            )  # fmt: skip

    return push_facets
