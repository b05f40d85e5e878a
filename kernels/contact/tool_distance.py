"""Signed distance and outward normal of rigid tools (docs/theory.md, section 6). Negative inside the tool.

A tool is a union of parts, each an analytic shape or a sampled volume in its own frame.
"""

from functools import cache

import warp as wp

from ..lane_types import lane_types
from ..lanes import fill, in_every_lane, smaller, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from .friction import tool_friction_struct
from .mesh_samples import sampled_clearance
from .tool_shapes import SHAPE_KINDS, number, part_struct, shape_kind, shape_number


@cache
def tool_struct(real: type):
    """One tool: its parts, friction and frame at zero displacement."""

    @wp.struct
    class Tool:
        first_part: wp.int32
        part_count: wp.int32
        axis: wp.vec3d  # unit direction of the motion
        friction: real  # Coulomb coefficient

    return Tool


@cache
def tool_set_struct(real: type):
    """All tools and their current positions."""
    Tool, ToolPart = tool_struct(real), part_struct(real)
    ToolFriction = tool_friction_struct(real)

    @wp.struct
    class Tools:
        tool: wp.array(dtype=Tool)
        part: wp.array(dtype=ToolPart)
        displacement: wp.array(dtype=wp.float64)  # along each tool's axis [m]
        velocity: wp.array(dtype=wp.float64)  # [m/s]
        pose: wp.array2d(dtype=wp.float64)  # [tool, entry], entries: see ToolPoseRow; of runs with carried tools
        law: wp.array(dtype=ToolFriction)  # of each tool
        argument: wp.array(dtype=real)  # tables of all laws, ascending within each
        coefficient: wp.array(dtype=real)

    return Tools


@cache
def part_distance_function(real: type, lane_count: int, shape_kinds: tuple[str, ...]):
    """wp.func (part, points in its frame) -> (signed distance, outward normal), for parts of ``shape_kinds``.

    A part of any other kind is a host error: its distance is NaN, which stops the run.

    Raises:
        ValueError: there is no kind of such a name, or two have the same number.
    """
    numbers = {shape_number(name): name for name in shape_kinds}
    if len(numbers) < len(set(shape_kinds)):
        raise ValueError(f"two of {', '.join(shape_kinds)} have the same number; rename the module of one")
    types = lane_types(real, lane_count)
    lanes3 = types.lanes3
    ToolPart = part_struct(real)

    @wp.func
    def part_of_no_kind(part: ToolPart, p: lanes3):
        return fill(p[0], wp.nan), p

    def with_kind(number: int, distance_of: wp.Function, others: wp.Function) -> wp.Function:
        # One function per kind, each calling the next: a loop over wp.static(kinds[k]) would be shorter, but Warp 1.19
        # omits such an expression from the hash, and would use the compiled kernel of another tuple of kinds.
        @wp.func
        def part_distance(part: ToolPart, p: lanes3):
            if part.kind == wp.static(number):
                return distance_of(part, p)
            return others(part, p)

        return part_distance

    result = part_of_no_kind
    for name in shape_kinds:
        result = with_kind(shape_number(name), shape_kind(name).distance, result)
    return result


@cache
def part_clearance_function(real: type, lane_count: int):
    """wp.func (part, distances of points from it) -> their clearances; see ``tool_distance_function``."""
    lanes, ToolPart = lane_types(real, lane_count).lanes, part_struct(real)

    @wp.func
    def part_clearance(part: ToolPart, distance: lanes):
        if part.kind == wp.static(shape_number("volume")):
            return sampled_clearance(part.reach, number(part, 0), number(part, 1), number(part, 2), distance)
        return distance

    return part_clearance


@cache
def nearer_part_function(real: type, lane_count: int):
    """wp.func -> (distance, normal, clearance) of a tool with its part ``k`` too, from those of all before it.

    It returns early: what a branch changes is chosen by its address, so lanes would go through memory (decision 80).
    """
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3

    @wp.func
    def nearer_part(
        k: wp.int32,
        part_distance: lanes,
        part_normal: lanes3,
        part_clearance: lanes,
        distance: lanes,
        normal: lanes3,
        clearance: lanes,
    ):
        if k == 0:
            return part_distance, part_normal, part_clearance
        nearer = distance - part_distance
        for c in range(3):
            normal[c] = where_positive(nearer, part_normal[c], normal[c])
        return where_positive(nearer, part_distance, distance), normal, smaller(clearance, part_clearance)

    return nearer_part


@cache
def away_function(real: type, lane_count: int):
    """wp.func (centre, x, remainder) -> x + remainder - centre, exact to the rounding of the result."""
    types = lane_types(real, lane_count)
    lanes3, vec3 = types.lanes3, types.vec3

    @wp.func
    def away(centre: wp.vec3d, x: lanes3, remainder: lanes3):
        near = vec3(centre)
        rest = vec3(centre - wp.vec3d(near))
        return (x - in_every_lane(x, near)) + (remainder - in_every_lane(x, rest))

    return away


@cache
def tool_distance_function(real: type, lane_count: int, shape_kinds: tuple[str, ...], rotated: bool):
    """wp.func (parts, tool, displacement, x, remainder) -> (signed distance, outward normal, clearance), in lanes.

    The clearance is a lower bound of the distance that changes by at most the way of a point: samples err, and outside
    their box nothing is known. The points are x + remainder. In single precision both, and the place of a part as such
    a pair, make the vector between them as exact far from the origin as at the origin. Supported are only parts of
    ``shape_kinds``, and rotated ones only if ``rotated``.
    """
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    Tool, ToolPart = tool_struct(real), part_struct(real)
    part_distance = part_distance_function(real, lane_count, shape_kinds)
    part_clearance, away = part_clearance_function(real, lane_count), away_function(real, lane_count)
    nearer_part = nearer_part_function(real, lane_count)

    @wp.func
    def tool_distance(
        parts: wp.array(dtype=ToolPart), tool: Tool, displacement: wp.float64, x: lanes3, remainder: lanes3
    ):
        distance = lanes()
        normal = lanes3()
        clearance = lanes()
        for k in range(tool.part_count):
            part = parts[tool.first_part + k]
            p = away(part.origin + displacement * tool.axis, x, remainder)
            if wp.static(rotated):
                p = wp.transpose(part.rotation) * p
            part_d, part_n = part_distance(part, p)
            if wp.static(rotated):
                part_n = part.rotation * part_n
            part_c = part_d
            if wp.static("volume" in shape_kinds):
                part_c = part_clearance(part, part_d)
            distance, normal, clearance = nearer_part(k, part_d, part_n, part_c, distance, normal, clearance)
        if wp.static("volume" not in shape_kinds):
            clearance = distance
        return distance, normal, clearance

    return tool_distance


@cache
def sample_distance_kernel(real: type, lane_count: int, further_kinds: tuple[str, ...]):
    """Kernel that evaluates one tool at points, one per entry; the last block of lanes repeats the last point.

    It knows all ``SHAPE_KINDS``, so that most tools share one kernel, and ``further_kinds``.
    """
    types = lane_types(real, lane_count)
    lanes3, vec3 = types.lanes3, types.vec3
    Tool, ToolPart = tool_struct(real), part_struct(real)
    tool_distance = tool_distance_function(real, lane_count, (*SHAPE_KINDS, *further_kinds), True)

    @wp.kernel(module="unique", enable_backward=False)
    def sample_distance(
        # In
        tools: wp.array(dtype=Tool),
        parts: wp.array(dtype=ToolPart),
        tool_index: wp.int32,
        displacement: wp.float64,
        points: wp.array(dtype=wp.vec3d),
        # Out
        distance: wp.array(dtype=real),
        normal: wp.array(dtype=vec3),
    ):
        first = wp.tid() * lane_count
        last = points.shape[0] - 1
        x = lanes3()
        remainder = lanes3()
        for i in range(lane_count):
            point = points[wp.min(first + i, last)]
            for c in range(3):
                x[c, i] = real(point[c])
                remainder[c, i] = real(point[c] - wp.float64(real(point[c])))
        d, n, _ = tool_distance(parts, tools[tool_index], displacement, x, remainder)
        for i in range(lane_count):
            if first + i <= last:
                distance[first + i] = d[i]
                normal[first + i] = vec3(n[0, i], n[1, i], n[2, i])

    return sample_distance
