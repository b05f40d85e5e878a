"""Contact of one block of nodes with the tools (docs/theory.md, section 6)."""

from functools import cache

import warp as wp

from ..contact.penalty import friction_spring, normal_force, touch_struct
from ..contact.tool_distance import tool_distance_function, tool_set_struct
from ..lane_types import lane_types
from ..lanes import dot, lane_maximum, lane_sum, larger, negative, rows3, scale, store_rows3
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import ClockEntry, NodeWorkRow
from .node_data import NodeTraits, node_laws_struct, present_struct
from .tool_friction import rub_by_law_function

THICKNESS_WORK = wp.constant(int(NodeWorkRow.thickness_work))


@cache
def contact_function(real: type, lane_count: int, carried: bool = False):
    """wp.func -> (normal spring's force, force of spring and dashpot, of the dashpot, of friction, friction spring).

    The velocity of a tool that is ``carried`` differs between the lanes.
    """
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    velocity_type = types.lanes3 if carried else types.vec3
    Present, NodeLaws = present_struct(real, lane_count), node_laws_struct(real)

    @wp.func
    def contact(
        present: Present,
        laws: NodeLaws,
        friction: real,
        tool_velocity: velocity_type,
        penetration: lanes,
        normal: lanes3,
        stretch: lanes3,
    ):
        stiffness = laws.contact_stiffness * present.mass
        relative = present.velocity
        for c in range(3):
            relative[c] = relative[c] - lanes(tool_velocity[c])
        leaving = dot(relative, normal)
        spring, pressure = normal_force(penetration, -leaving, stiffness, laws.contact_damping_time)
        dashpot = scale(pressure - spring, normal)
        # friction: the spring follows the tangent plane and the sliding since the last step
        stretched = stretch + present.mean_step * relative
        trial = stretched - scale(dot(stretched, normal), normal)
        tangential = laws.tangential_ratio * stiffness
        held = friction_spring(trial, tangential, friction * pressure)
        return spring, scale(pressure, normal), dashpot, scale(negative(tangential), held), held

    return contact


@cache
def on_tool_function(real: type, lane_count: int):
    """wp.func -> what forces, or moments, on a block of points are together on the tool that exerts them."""
    types = lane_types(real, lane_count)
    lanes3, vec3 = types.lanes3, types.vec3

    @wp.func
    def on_tool(force: lanes3):
        return vec3(-lane_sum(force[0]), -lane_sum(force[1]), -lane_sum(force[2]))

    return on_tool


def each_tool_function(real: type, lane_count: int, meet_tool: wp.Function) -> wp.Function:
    """wp.func -> (force with contact, friction, its power, dashpots, their power) of all tools.

    ``meet_tool`` gives what one tool adds to each, and returns early where it is far (decision 80).
    """
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    Present, NodeLaws = present_struct(real, lane_count), node_laws_struct(real)
    Tools, Touch = tool_set_struct(real), touch_struct(real, lane_count)

    @wp.func
    def meet_tools(
        present: Present,
        laws: NodeLaws,
        tools: Tools,
        force: lanes3,
        # Out
        touch: Touch,
        works: wp.array2d(dtype=lanes),
    ):
        friction, friction_power = lanes3(), lanes()
        dashpots, dashpot_power = lanes3(), lanes()
        for k in range(laws.tool_count):
            push, drag, dashpot, by_friction, by_dashpot = meet_tool(present, laws, tools, k, touch, works)
            force, friction, dashpots = force + push, friction + drag, dashpots + dashpot
            friction_power, dashpot_power = friction_power + by_friction, dashpot_power + by_dashpot
        return force, friction, friction_power, dashpots, dashpot_power

    return meet_tools


@cache
def meet_tools_function(real: type, lane_count: int, traits: NodeTraits):
    """wp.func -> (force with contact, friction, its power, dashpots, their power); touch and work are written.

    The powers are those of the moving tools on forces that do not derive from an energy. The five are not a struct:
    Warp passes structs by value, and in this loop the compiler would copy them through memory: 44 instead of 31 ns per
    node (16 lanes, float32).
    """
    types = lane_types(real, lane_count)
    lanes, lanes3, vec3 = types.lanes, types.lanes3, types.vec3
    Present, NodeLaws = present_struct(real, lane_count), node_laws_struct(real)
    Tools, Touch = tool_set_struct(real), touch_struct(real, lane_count)
    tool_distance = tool_distance_function(real, lane_count, traits.shape_kinds, traits.rotated)
    contact, on_tool = contact_function(real, lane_count), on_tool_function(real, lane_count)
    rub_by_law = rub_by_law_function(real, lane_count)

    @wp.func
    def power(tool_velocity: vec3, force: lanes3):
        return (tool_velocity[0] * force[0] + tool_velocity[1] * force[1]) + tool_velocity[2] * force[2]

    @wp.func
    def pushed(
        present: Present,
        laws: NodeLaws,
        tools: Tools,
        k: wp.int32,
        penetration: lanes,
        normal: lanes3,
        # Out
        touch: Touch,
        works: wp.array2d(dtype=lanes),
    ):
        block = present.block
        if lane_maximum(penetration) <= real(0.0):
            return lanes3(), lanes3(), lanes3(), lanes3(), lanes(), lanes()
        tool = tools.tool[k]
        tool_velocity = real(tools.velocity[k]) * vec3(real(tool.axis[0]), real(tool.axis[1]), real(tool.axis[2]))
        spring, pressed, dashpot, drag, stretch = contact(
            present, laws, tool.friction, tool_velocity, penetration, normal, rows3(touch.friction, 3 * k, block)
        )
        if wp.static(traits.friction_laws):
            drag, stretch = rub_by_law(present, laws, tools, k, tool_velocity, normal, pressed, touch)
        if wp.static(traits.follows_thickness):
            works[THICKNESS_WORK, block] = works[THICKNESS_WORK, block] + spring * present.growth
        touch.depth[k, block] = larger(touch.depth[k, block], penetration)
        return pressed + drag, drag, dashpot, stretch, power(tool_velocity, drag), power(tool_velocity, dashpot)

    @wp.func
    def meet_tool(
        present: Present,
        laws: NodeLaws,
        tools: Tools,
        k: wp.int32,
        # Out
        touch: Touch,
        works: wp.array2d(dtype=lanes),
    ):
        block = present.block
        # the tool moved over the last step, which is at most twice the mean step
        moved = real(2.0) * present.mean_step * wp.abs(real(tools.velocity[k]))
        distance_left = touch.gap[k, block] - moved - present.thickened
        if distance_left > real(0.0):
            touch.gap[k, block] = distance_left
            return lanes3(), lanes3(), lanes3(), lanes(), lanes()
        distance, normal, clearance = tool_distance(
            tools.part, tools.tool[k], tools.displacement[k], present.position, present.remainder
        )
        touch.gap[k, block] = -lane_maximum(present.half_thickness - clearance) - laws.spare_distance
        push, drag, dashpot, stretch, friction_power, dashpot_power = pushed(
            present, laws, tools, k, present.half_thickness - distance, normal, touch, works
        )
        store_rows3(touch.friction, 3 * k, block, stretch)
        touch.reaction[k, block] = on_tool(push)
        return push, drag, dashpot, friction_power, dashpot_power

    return each_tool_function(real, lane_count, meet_tool)


@cache
def touching_struct(real: type):
    """Points of a sheet, nodes or samples, whose distances to the tools are known; constants and the present."""
    types = lane_types(real, 1)

    @wp.struct
    class Touching:
        clock: wp.array(dtype=wp.float64)  # see ClockEntry
        mass: wp.array(dtype=real)  # on the contact spring of each [kg]
        half_thickness: wp.array(dtype=real)  # of the sheet there [m]
        velocity: wp.array2d(dtype=types.vec3)  # [tool, point]; of carried tools, relative to their surface [m/s]
        distance: wp.array2d(dtype=real)  # [tool, point] [m]
        normal: wp.array2d(dtype=types.vec3)  # [tool, point], outward

    return Touching


@cache
def tool_push_kernel(real: type, friction_laws: bool):
    """Kernel of (tool, point): the forces of ``meet_tools`` at points, one by one, without moving anything.

    ``touch`` has the friction springs of the points, their areas, and room for the extremes of friction laws.
    """
    types = lane_types(real, 1)
    lanes, lanes3, vec3 = types.lanes, types.lanes3, types.vec3
    Present, NodeLaws, Touching = present_struct(real, 1), node_laws_struct(real), touching_struct(real)
    Tools, Touch = tool_set_struct(real), touch_struct(real, 1)
    contact, rub_by_law = contact_function(real, 1), rub_by_law_function(real, 1)

    @wp.func
    def column(vector: vec3):
        result = lanes3()
        for c in range(3):
            result[c, 0] = vector[c]
        return result

    @wp.func
    def present_point(k: wp.int32, point: wp.int32, points: Touching):
        present = Present()
        present.block = point
        present.mean_step = real(points.clock[ClockEntry.mean_step])
        present.mass = lanes(points.mass[point])
        present.velocity = column(points.velocity[k, point])
        return present

    @wp.kernel(module="unique", enable_backward=False)
    def tool_push(
        # In
        laws: NodeLaws,
        tools: Tools,
        points: Touching,
        touch: Touch,
        # Out
        pushed: wp.array2d(dtype=real),  # [tool, point]: force along the normal [N]
        dragged: wp.array2d(dtype=vec3),  # [tool, point]: force of friction [N]
    ):
        k, point = wp.tid()
        present = present_point(k, point, points)
        penetration = lanes(points.half_thickness[point] - points.distance[k, point])
        push = lanes()
        drag = lanes3()
        if not penetration[0] <= real(0.0):
            normal = column(points.normal[k, point])
            tool = tools.tool[k]
            tool_velocity = real(tools.velocity[k]) * vec3(real(tool.axis[0]), real(tool.axis[1]), real(tool.axis[2]))
            stretch = rows3(touch.friction, 3 * k, point)
            spring, pressed, dashpot, drag, stretch = contact(
                present, laws, tool.friction, tool_velocity, penetration, normal, stretch
            )
            if wp.static(friction_laws):
                drag, stretch = rub_by_law(present, laws, tools, k, tool_velocity, normal, pressed, touch)
            push = dot(pressed, normal)
        pushed[k, point] = push[0]
        dragged[k, point] = vec3(drag[0, 0], drag[1, 0], drag[2, 0])

    return tool_push
