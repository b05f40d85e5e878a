"""Signed distance and outward normal of rigid tools (docs/theory.md, section 6). Negative inside the tool.

A tool is a union of parts, each an analytic shape or a sampled volume in its own frame.
"""

from functools import cache

import warp as wp

from ..lanes import (
    fill,
    lane_types,
    mul,  # noqa: F401 - operators of lanes
    smaller,
    spread,
    square_root,
    where_positive,
)
from .tool_shapes import (
    ALL_KINDS,
    CAPSULE,
    DOME_CAVITY,
    DOME_OPENING,
    DOME_PUNCH,
    SPHERE,
    TORUS,
    VOLUME,
    dome_cavity_distance,
    dome_opening_distance,
    part_struct,
    safe_inverse,
    stadium_profile,
)


@cache
def tool_struct(real: type):
    """One tool: its parts, friction and frame at zero displacement."""
    vec3 = wp.types.vector(3, real)

    @wp.struct
    class Tool:
        first_part: wp.int32
        part_count: wp.int32
        axis: vec3  # unit direction of the motion
        friction: real  # Coulomb coefficient
        blind_distance: real  # up to it the distance may jump as points move; beyond, it changes no more than they move

    return Tool


@cache
def tool_set_struct(real: type):
    """All tools and where they are now."""
    Tool, ToolPart = tool_struct(real), part_struct(real)

    @wp.struct
    class Tools:
        tool: wp.array(dtype=Tool)
        part: wp.array(dtype=ToolPart)
        displacement: wp.array(dtype=wp.float64)  # along each tool's axis [m]
        velocity: wp.array(dtype=wp.float64)  # [m/s]

    return Tools


@cache
def tool_distance_function(real: type, lane_count: int, shape_kinds: tuple[int, ...], rotated: bool):
    """wp.func (parts, tool, displacement, x) -> (signed distance, outward normal), for lanes of points.

    It knows no other kinds of parts than ``shape_kinds``, and rotated ones only if ``rotated``.
    """
    volumes, openings, cavities, tori = (int(k) in shape_kinds for k in (VOLUME, DOME_OPENING, DOME_CAVITY, TORUS))
    segments = any(int(kind) in shape_kinds for kind in (SPHERE, CAPSULE, DOME_PUNCH))
    types = lane_types(real, lane_count)
    lanes, lanes3, vec3 = types.lanes, types.lanes3, types.vec3
    Tool, ToolPart = tool_struct(real), part_struct(real)

    @wp.func
    def volume_distance(part: ToolPart, p: lanes3):
        distance = lanes()
        normal = lanes3()
        for i in range(lane_count):
            q = vec3(p[0, i], p[1, i], p[2, i])
            inside = vec3(
                wp.clamp(q[0], part.lower[0], part.upper[0]),
                wp.clamp(q[1], part.lower[1], part.upper[1]),
                wp.clamp(q[2], part.lower[2], part.upper[2]),
            )
            outside = wp.length(q - inside)
            if outside > real(0.0):
                distance[i] = part.reach + outside
                normal[2, i] = real(1.0)
            else:
                index = wp.volume_world_to_index(part.volume, wp.vec3(float(q[0]), float(q[1]), float(q[2])))
                gradient = wp.vec3(0.0, 0.0, 0.0)
                value = wp.volume_sample_grad_f(part.volume, index, wp.Volume.LINEAR, gradient)
                unit = wp.normalize(gradient)
                distance[i] = real(value)
                normal[0, i] = real(unit[0])
                normal[1, i] = real(unit[1])
                normal[2, i] = real(unit[2])
        return distance, normal

    @wp.func
    def part_distance(part: ToolPart, p: lanes3):
        x = p[0]
        y = p[1]
        z = p[2]
        zero = fill(x, 0.0)
        # a plane, unless it is something else
        distance = z
        n0 = zero
        n1 = zero
        n2 = fill(x, 1.0)
        if wp.static(volumes):
            if part.kind == VOLUME:
                distance, normal = volume_distance(part, p)
                n0 = normal[0]
                n1 = normal[1]
                n2 = normal[2]
        if wp.static(openings):
            if part.kind == DOME_OPENING:
                distance, n0, n1, n2 = dome_opening_distance(x, y, z, part.radius, part.half_length, part.edge_radius)
        if wp.static(cavities):
            if part.kind == DOME_CAVITY:
                distance, n0, n1, n2 = dome_cavity_distance(x, y, z, part.radius, part.half_length)
        if wp.static(tori):
            if part.kind == TORUS:
                out = square_root(x * x + y * y)
                a = out - spread(x, part.half_length)
                length = square_root(a * a + z * z)
                inverse = safe_inverse(length)
                inverse_out = safe_inverse(out)
                distance = length - spread(x, part.radius)
                n0 = a * inverse * x * inverse_out
                n1 = a * inverse * y * inverse_out
                n2 = z * inverse
        if wp.static(segments):
            if part.kind == SPHERE or part.kind == CAPSULE or part.kind == DOME_PUNCH:
                half_length = part.half_length
                if part.kind == SPHERE:
                    half_length = real(0.0)
                if part.kind == DOME_PUNCH:
                    z = smaller(z, zero)
                out, along, across = stadium_profile(x, y, half_length)
                length = square_root(out * out + z * z)
                inverse = safe_inverse(length)
                distance = length - spread(x, part.radius)
                n0 = along * inverse
                n1 = across * inverse
                n2 = z * inverse
        return distance, wp.matrix_from_rows(n0, n1, n2)

    @wp.func
    def tool_distance(parts: wp.array(dtype=ToolPart), tool: Tool, displacement: real, x: lanes3):
        distance = lanes()
        normal = lanes3()
        for k in range(tool.part_count):
            part = parts[tool.first_part + k]
            centre = part.origin + displacement * tool.axis
            p = wp.matrix_from_rows(x[0] - lanes(centre[0]), x[1] - lanes(centre[1]), x[2] - lanes(centre[2]))
            if wp.static(rotated):
                p = wp.transpose(part.rotation) * p
            part_d, part_n = part_distance(part, p)
            if wp.static(rotated):
                part_n = part.rotation * part_n
            if k == 0:
                distance = part_d
                normal = part_n
            else:
                nearer = distance - part_d
                distance = where_positive(nearer, part_d, distance)
                for c in range(3):
                    normal[c] = where_positive(nearer, part_n[c], normal[c])
        return distance, normal

    return tool_distance


@cache
def sample_distance_kernel(real: type, lane_count: int):
    """Kernel that evaluates one tool at points given one per entry; the last block of lanes repeats the last point."""
    types = lane_types(real, lane_count)
    lanes3, vec3 = types.lanes3, types.vec3
    Tool, ToolPart = tool_struct(real), part_struct(real)
    tool_distance = tool_distance_function(real, lane_count, ALL_KINDS, True)

    @wp.kernel(module="unique", enable_backward=False)
    def sample_distance(
        # In
        tools: wp.array(dtype=Tool),
        parts: wp.array(dtype=ToolPart),
        tool_index: wp.int32,
        displacement: real,
        points: wp.array(dtype=vec3),
        # Out
        distance: wp.array(dtype=real),
        normal: wp.array(dtype=vec3),
    ):
        first = wp.tid() * lane_count
        last = points.shape[0] - 1
        x = lanes3()
        for i in range(lane_count):
            point = points[wp.min(first + i, last)]
            for c in range(3):
                x[c, i] = point[c]
        d, n = tool_distance(parts, tools[tool_index], displacement, x)
        for i in range(lane_count):
            if first + i <= last:
                distance[first + i] = d[i]
                normal[first + i] = vec3(n[0, i], n[1, i], n[2, i])

    return sample_distance
