"""Data of the contact between nodes: constants, what is kept from step to step, and the corners of a block."""

from functools import cache

import warp as wp

from ..contact.penalty import touch_struct
from ..lane_types import lane_types


@cache
def samples_struct(real: type, lane_count: int):
    """Constants of the samples of a sheet, and how far its nodes moved in the last step.

    Sample j of the elements of a block has the number ``j * block_count + block`` in all arrays of [row, block]. Blocks
    are not those of the elements: they are as compact as the sheet allows, so that few have to be looked at.
    """
    types = lane_types(real, lane_count)

    @wp.struct
    class Samples:
        corner_node: wp.array2d(dtype=types.indices)  # 4 rows: first entry of the node in the flat motion array
        node_stride: wp.int32  # entries between two of its rows
        element: wp.array(dtype=types.indices)  # of a block: its first entry in the flat array of corners
        corner_stride: wp.int32  # entries between two of its rows
        place: wp.array(dtype=wp.vec2d)  # of each sample in any element, -1 to 1 in both directions
        block_count: wp.int32  # of elements
        mass: wp.array(dtype=types.lanes)  # of one sample of each element [kg]; 0 for padding
        node_block: wp.array2d(dtype=wp.int32)  # [slot, block]: blocks of nodes that have the corners of a block
        allowance: real  # depth of the surface in a tool from which samples push [m]
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
def layer_struct(real: type, lane_count: int):
    """Thickness of a block of elements in contact, and how it changes."""
    lanes = lane_types(real, lane_count).lanes

    @wp.struct
    class Layer:
        half_thickness: lanes  # less the depth that is allowed [m]
        growth: lanes  # from half a step ago to half a step ahead [m]
        thickened: real  # the largest growth in the last step [m]

    return Layer


@cache
def patch_struct(real: type, lane_count: int):
    """Corners of a block of elements as a + u b + v c + u v d with -1 <= u, v <= 1.

    Positions are relative to the first corner, and include the remainders.
    """
    types = lane_types(real, lane_count)
    lanes3 = types.lanes3

    @wp.struct
    class Patch:
        origin: lanes3  # the first corner [m]
        remainder: lanes3  # of its position [m]
        x: lanes3  # [m]
        x_u: lanes3
        x_v: lanes3
        x_uv: lanes3
        d: lanes3  # director
        d_u: lanes3
        d_v: lanes3
        d_uv: lanes3
        v: lanes3  # [m/s]
        v_u: lanes3
        v_v: lanes3
        v_uv: lanes3

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
def load_struct(real: type, lane_count: int):
    """Forces [N] and couples [N m] on a block of elements; corner I gets a quarter of a + u_I b + v_I c + u_I v_I d."""
    lanes3 = lane_types(real, lane_count).lanes3

    @wp.struct
    class Load:
        force: lanes3
        force_u: lanes3
        force_v: lanes3
        force_uv: lanes3
        couple: lanes3
        couple_u: lanes3
        couple_v: lanes3
        couple_uv: lanes3

    return Load
