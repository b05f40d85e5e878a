"""Unit normals of a sheet at its nodes, from the positions of the nodes around (docs/plies.md).

The contact of plies uses them, and not the directors: directors tilt by transverse shear, and a gap that follows them
without pushing back on them is unstable under pressure (docs/decisions/0035). Every corner has the weight of N. Max,
"Weights for computing vertex normals from facet normals", Journal of Graphics Tools 4 (1999) 1-6: the cross product of
both edges over their squared lengths, exact for any mesh on a sphere.
"""

from functools import cache

import warp as wp

from ..lane_types import lane_types, step_options
from ..lanes import cross, dot, fill, larger, scale, square_root
from ..operators import add, div, mul, sub  # noqa: F401
from ..records import gather4, record3, store_record4, vector_of
from ..rows import MOTION_RECORD_LENGTH, MotionRow

# Numbers per node in the array of normals: a piece of a record.
NORMAL_ROW_COUNT = 4


@cache
def normal_table_struct(real: type, lane_count: int):
    """Neighbours of the nodes of a sheet."""
    types = lane_types(real, lane_count)

    @wp.struct
    class NormalTable:
        following: wp.array2d(dtype=types.indices)  # [slot, block]: entry of the next corner of an element around
        preceding: wp.array2d(dtype=types.indices)  # of the corner before; the node's own where there is no element
        kept: wp.array2d(dtype=types.lanes)  # [component, block]: 0 where a symmetry plane holds the normal, else 1
        stride: wp.int32  # entries between two rows of the motion

    return NormalTable


@cache
def surface_normals_kernel(real: type, lane_count: int):
    """Kernel over blocks of nodes: the weighted mean normal of the elements around each."""
    types = lane_types(real, lane_count)
    lanes, lanes3, indices = types.lanes, types.lanes3, types.indices
    NormalTable = normal_table_struct(real, lane_count)

    @wp.func
    def away(motion: wp.array(dtype=real), entry: indices, stride: int, position: lanes3):
        return vector_of(gather4(motion, entry, MotionRow.position * stride, stride)) - position

    @wp.kernel(module="unique", enable_backward=False, module_options=step_options(real))
    def surface_normals(
        # In
        first_block: wp.int32,
        table: NormalTable,
        motion: wp.array(dtype=real),
        rows: wp.array2d(dtype=lanes),  # the same motion, by rows
        awake: wp.array(dtype=wp.int32),  # 0: no contact needs them now
        # Out
        normals: wp.array2d(dtype=lanes),
    ):
        if awake[0] == 0:
            return
        block = first_block + wp.tid()
        position = record3(rows, MOTION_RECORD_LENGTH, MotionRow.position, block)
        total = lanes3()
        for slot in range(table.following.shape[0]):
            ahead = away(motion, table.following[slot, block], table.stride, position)
            behind = away(motion, table.preceding[slot, block], table.stride, position)
            squared = mul(dot(ahead, ahead), dot(behind, behind))
            # where there is no element, both are zero
            weight = fill(squared, 1.0) / larger(squared, lanes(real(1.0e-30)))
            total = total + scale(weight, cross(ahead, behind))
        for c in range(3):
            total[c] = mul(table.kept[c, block], total[c])
        # padding has none
        length = larger(square_root(dot(total, total)), lanes(real(1.0e-30)))
        store_record4(normals, NORMAL_ROW_COUNT, 0, block, scale(fill(length, 1.0) / length, total), lanes())

    return surface_normals
