"""Contact of one block of points with tools that are carried: see ``meet_tools_function``."""

from functools import cache

import warp as wp

from ..contact.carried_pose import posed_distance_function, read_pose_function, surface_speed_functions
from ..contact.penalty import touch_struct
from ..contact.tool_distance import away_function, tool_set_struct
from ..lane_types import lane_types
from ..lanes import cross, lane_maximum, lane_sum, larger, rows3, store_rows3
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import NodeWorkRow
from .node_data import NodeTraits, node_laws_struct, present_struct
from .tool_contact import contact_function, meet_tools_function
from .tool_friction import rub_by_law_function

THICKNESS_WORK = wp.constant(int(NodeWorkRow.thickness_work))


@cache
def meet_carried_tools_function(real: type, lane_count: int, traits: NodeTraits):
    """wp.func -> (force with contact, friction, its power, dashpots, their power); touch and work are written.

    As for tools that only move along their axes, with the velocity of the tool at each point, and the moment of the
    forces about its pivot.
    """
    types = lane_types(real, lane_count)
    lanes, lanes3, vec3 = types.lanes, types.lanes3, types.vec3
    Present, NodeLaws = present_struct(real, lane_count), node_laws_struct(real)
    Tools, Touch = tool_set_struct(real), touch_struct(real, lane_count)
    read_pose, away = read_pose_function(real), away_function(real, lane_count)
    posed_distance = posed_distance_function(real, lane_count, traits.shape_kinds)
    turning, velocity_at, largest_speed = surface_speed_functions(real, lane_count)
    contact = contact_function(real, lane_count, True)
    rub_by_law = rub_by_law_function(real, lane_count, True)

    @wp.func
    def power(velocity: lanes3, force: lanes3, total: lanes):
        for c in range(3):
            total = total + velocity[c] * force[c]
        return total

    @wp.func
    def on_tool(force: lanes3):
        return vec3(-lane_sum(force[0]), -lane_sum(force[1]), -lane_sum(force[2]))

    @wp.func
    def meet_carried_tools(
        present: Present,
        laws: NodeLaws,
        tools: Tools,
        force: lanes3,
        # Out
        touch: Touch,
        works: wp.array2d(dtype=lanes),
    ):
        block = present.block
        friction, friction_power = lanes3(), lanes()
        dashpots, dashpot_power = lanes3(), lanes()
        for k in range(laws.tool_count):
            pose = read_pose(tools, k)
            arm = away(pose.pivot, present.position, present.remainder)
            way = real(2.0) * present.mean_step * largest_speed(pose, arm)
            distance_left = touch.gap[k, block] - way - present.thickened
            if not distance_left > real(0.0):
                tool = tools.tool[k]
                distance, normal, clearance = posed_distance(
                    tools.part, tool, pose, present.position, present.remainder
                )
                penetration = present.half_thickness - distance
                deepest = lane_maximum(penetration)
                distance_left = -lane_maximum(present.half_thickness - clearance) - laws.spare_distance
                stretch, push = lanes3(), lanes3()
                if not deepest <= real(0.0):
                    velocity = velocity_at(pose, arm)
                    stretch = rows3(touch.friction, 3 * k, block)
                    stretch = stretch + present.mean_step * turning(pose.spin, stretch)
                    spring, pressed, dashpot, drag, held = contact(
                        present, laws, tool.friction, velocity, penetration, normal, stretch
                    )
                    if wp.static(traits.friction_laws):
                        store_rows3(touch.friction, 3 * k, block, stretch)
                        drag, held = rub_by_law(present, laws, tools, k, velocity, normal, pressed, touch)
                    stretch = held
                    if wp.static(traits.follows_thickness):
                        works[THICKNESS_WORK, block] = works[THICKNESS_WORK, block] + spring * present.growth
                    touch.depth[k, block] = larger(touch.depth[k, block], penetration)
                    push = pressed + drag
                    force, friction, dashpots = force + push, friction + drag, dashpots + dashpot
                    friction_power = power(velocity, drag, friction_power)
                    dashpot_power = power(velocity, dashpot, dashpot_power)
                store_rows3(touch.friction, 3 * k, block, stretch)
                touch.reaction[k, block] = on_tool(push)
                touch.moment[k, block] = on_tool(cross(arm, push))
            touch.gap[k, block] = distance_left
        return force, friction, friction_power, dashpots, dashpot_power

    return meet_carried_tools


def meeting_function(real: type, lane_count: int, traits: NodeTraits):
    """The function with which points meet the tools of a run: of carried tools, or of others."""
    return (meet_carried_tools_function if traits.carried else meet_tools_function)(real, lane_count, traits)
