"""Where a tool stands and how it moves: a turn and a shift, the velocity of its pivot, and its spin."""

from functools import cache

import warp as wp

from ..lane_types import lane_types
from ..lanes import dot, from_rows, in_every_lane, lane_maximum
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import ToolPoseRow
from .tool_distance import (
    away_function,
    nearer_part_function,
    part_clearance_function,
    part_distance_function,
    tool_set_struct,
    tool_struct,
)
from .tool_shapes import part_struct


@cache
def pose_struct(real: type):
    """Pose of one tool: a point X of it, as drawn, is at rotation X + shift."""
    vec3, mat33 = wp.types.vector(3, real), wp.types.matrix((3, 3), real)

    @wp.struct
    class Pose:
        rotation: wp.mat33d
        shift: wp.vec3d  # [m]
        pivot: wp.vec3d  # where the point is about which it turns [m]
        turn: mat33  # the rotation in the precision of the run
        velocity: vec3  # of the pivot, half a step ago [m/s]
        spin: vec3  # half a step ago [rad/s]

    return Pose


@wp.func
def vector_entries(poses: wp.array2d(dtype=wp.float64), k: int, first: int):
    """Three entries of the pose of tool ``k``."""
    return wp.vec3d(poses[k, first], poses[k, first + 1], poses[k, first + 2])


@wp.func
def store_vector(poses: wp.array2d(dtype=wp.float64), k: int, first: int, value: wp.vec3d):
    """Write three entries of the pose of tool ``k``."""
    for c in range(3):
        poses[k, first + c] = value[c]


@cache
def read_pose_function(real: type):
    """wp.func (tools, number of one) -> its ``Pose``."""
    Pose, Tools = pose_struct(real), tool_set_struct(real)
    vec3, mat33 = wp.types.vector(3, real), wp.types.matrix((3, 3), real)

    @wp.func
    def in_precision(value: wp.vec3d):
        return vec3(real(value[0]), real(value[1]), real(value[2]))

    @wp.func
    def read_pose(tools: Tools, k: wp.int32):
        poses = tools.pose
        rotation = wp.mat33d()
        turn = mat33()
        for i in range(3):
            for j in range(3):
                rotation[i, j] = poses[k, ToolPoseRow.rotation + 3 * i + j]
                turn[i, j] = real(rotation[i, j])
        pose = Pose()
        pose.rotation = rotation
        pose.turn = turn
        pose.shift = vector_entries(poses, k, ToolPoseRow.shift)
        pose.pivot = vector_entries(poses, k, ToolPoseRow.pivot)
        along = tools.velocity[k] * tools.tool[k].axis
        pose.velocity = in_precision(vector_entries(poses, k, ToolPoseRow.velocity) + along)
        pose.spin = in_precision(vector_entries(poses, k, ToolPoseRow.spin))
        return pose

    return read_pose


@cache
def posed_distance_function(real: type, lane_count: int, shape_kinds: tuple[str, ...]):
    """wp.func (parts, tool, pose, x, remainder) -> (distance, normal, clearance); see ``tool_distance_function``.

    Points are taken into the frame of each part, and normals back.
    """
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    Tool, ToolPart, Pose = tool_struct(real), part_struct(real), pose_struct(real)
    part_distance, away = part_distance_function(real, lane_count, shape_kinds), away_function(real, lane_count)
    part_clearance, nearer_part = part_clearance_function(real, lane_count), nearer_part_function(real, lane_count)

    @wp.func
    def posed_distance(parts: wp.array(dtype=ToolPart), tool: Tool, pose: Pose, x: lanes3, remainder: lanes3):
        distance = lanes()
        normal = lanes3()
        clearance = lanes()
        for k in range(tool.part_count):
            part = parts[tool.first_part + k]
            turn = pose.turn * part.rotation
            p = wp.transpose(turn) * away(pose.rotation * part.origin + pose.shift, x, remainder)
            part_d, part_n = part_distance(part, p)
            part_n = turn * part_n
            part_c = part_clearance(part, part_d)
            distance, normal, clearance = nearer_part(k, part_d, part_n, part_c, distance, normal, clearance)
        return distance, normal, clearance

    return posed_distance


@cache
def surface_speed_functions(real: type, lane_count: int):
    """Functions for the velocity of a tool at points, a bound of it, and a friction spring that turns with the tool."""
    types = lane_types(real, lane_count)
    lanes3, vec3 = types.lanes3, types.vec3
    Pose = pose_struct(real)

    @wp.func
    def turning(spin: vec3, arm: lanes3):
        return from_rows(
            spin[1] * arm[2] - spin[2] * arm[1],
            spin[2] * arm[0] - spin[0] * arm[2],
            spin[0] * arm[1] - spin[1] * arm[0],
        )

    @wp.func
    def velocity_at(pose: Pose, arm: lanes3):
        """Of the points of the tool at ``arm`` from its pivot."""
        return turning(pose.spin, arm) + in_every_lane(arm, pose.velocity)

    @wp.func
    def largest_speed(pose: Pose, arm: lanes3):
        """Of any of these points."""
        return wp.length(pose.velocity) + wp.length(pose.spin) * wp.sqrt(lane_maximum(dot(arm, arm)))

    return turning, velocity_at, largest_speed
