"""Data of the contact between nodes: constants, what is kept from step to step, and the corners of a block."""

from functools import cache

import warp as wp

from ..contact.penalty import touch_struct
from ..lanes import lane_types


@cache
def samples_struct(real: type, lane_count: int):
    """Constants of the samples of a sheet, and how far its nodes moved in the last step.

    Sample j of the elements of a block has the number ``j * block_count + block`` in all arrays of [row, block].
    """
    types = lane_types(real, lane_count)

    @wp.struct
    class Samples:
        corner_node: wp.array2d(dtype=types.indices)  # 4 rows: first entry of the node in the flat motion array
        node_stride: wp.int32  # entries between two of its rows
        place: wp.array(dtype=wp.vec2d)  # of each sample in any element, -1 to 1 in both directions
        block_count: wp.int32  # of elements
        mass: wp.array(dtype=types.lanes)  # of one sample of each element [kg]; 0 for padding
        node_block: wp.array2d(dtype=wp.int32)  # [slot, block]: blocks of nodes that have the corners of a block
        lever: real  # largest size of an element [m]

    return Samples


@cache
def sampled_struct(real: type, lane_count: int):
    """What samples keep from step to step, and their forces on the tools; all of it is written."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Sampled:
        touch: touch_struct(real, lane_count)  # as of nodes; its thickness is that of elements, [row, block]
        reaction: wp.array2d(dtype=types.vec3)  # [tool, block]: force of all samples of a block on the tool [N]
        moment: wp.array2d(dtype=types.vec3)  # [tool, block]: of them about its pivot, of runs with carried tools [N m]
        memory: wp.array2d(dtype=types.lanes)  # rows: see SampleRow
        works: wp.array2d(dtype=types.lanes)  # rows: see NodeWorkRow

    return Sampled


@cache
def patch_struct(real: type, lane_count: int):
    """Corners of a block of elements; positions are relative to the first corner, and include the remainders."""
    types = lane_types(real, lane_count)
    lanes3 = types.lanes3

    @wp.struct
    class Patch:
        origin: lanes3  # the first corner [m]
        remainder: lanes3  # of its position [m]
        x2: lanes3  # [m]
        x3: lanes3
        x4: lanes3
        d1: lanes3
        d2: lanes3
        d3: lanes3
        d4: lanes3
        v1: lanes3  # [m/s]
        v2: lanes3
        v3: lanes3
        v4: lanes3

    return Patch


@cache
def point_struct(real: type, lane_count: int):
    """A sample of each element of a block: a point of the surface, and what moves it."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Point:
        way: types.lanes3  # from the first corner to the surface [m]
        velocity: types.lanes3  # of the patch [m/s]
        normal: types.lanes3  # interpolated director, of length one
        shrunk: types.lanes  # sagitta over the length of the interpolated director [m]
        x_by_u: types.lanes3  # derivatives of positions [m] and directors along both directions from -1 to 1
        x_by_v: types.lanes3
        d_by_u: types.lanes3
        d_by_v: types.lanes3

    return Point


@cache
def weight_struct(real: type):
    """Shares of the corners in a sample, and their derivatives along both directions from -1 to 1."""
    vec4 = wp.types.vector(4, real)

    @wp.struct
    class Weight:
        share: vec4
        by_u: vec4
        by_v: vec4
        rest_u: real  # (1 - u^2)/2
        rest_v: real

    return Weight


@cache
def load_struct(real: type, lane_count: int):
    """Forces [N] and couples [N m] on the corners of a block of elements."""
    lanes3 = lane_types(real, lane_count).lanes3

    @wp.struct
    class Load:
        force1: lanes3
        force2: lanes3
        force3: lanes3
        force4: lanes3
        couple1: lanes3
        couple2: lanes3
        couple3: lanes3
        couple4: lanes3

    return Load
