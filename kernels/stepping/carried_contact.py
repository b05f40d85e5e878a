"""Contact of one block of points with tools that are carried: see ``meet_tools_function``."""

from functools import cache

import warp as wp

from ..contact.carried_pose import posed_distance_function, read_pose_function, surface_speed_functions
from ..contact.penalty import touch_struct
from ..contact.tool_distance import away_function, tool_set_struct
from ..lane_types import lane_types
from ..lanes import cross, dot, lane_maximum, larger, rows3, store_rows3
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import NodeWorkRow
from .node_data import NodeTraits, node_laws_struct, present_struct
from .tool_contact import contact_function, each_tool_function, meet_tools_function, on_tool_function
from .tool_friction import rub_by_law_function

THICKNESS_WORK = wp.constant(int(NodeWorkRow.thickness_work))


@cache
def meet_carried_tools_function(real: type, lane_count: int, traits: NodeTraits):
    """wp.func -> (force with contact, friction, its power, dashpots, their power); touch and work are written.

    As for tools that only move along their axes, with the velocity of the tool at each point, and the moment of the
    forces about its pivot.
    """
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    Present, NodeLaws = present_struct(real, lane_count), node_laws_struct(real)
    Tools, Touch = tool_set_struct(real), touch_struct(real, lane_count)
    read_pose, away = read_pose_function(real), away_function(real, lane_count)
    posed_distance = posed_distance_function(real, lane_count, traits.shape_kinds)
    turning, velocity_at, largest_speed = surface_speed_functions(real, lane_count)
    contact, on_tool = contact_function(real, lane_count, True), on_tool_function(real, lane_count)
    rub_by_law = rub_by_law_function(real, lane_count, True)

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
        pose = read_pose(tools, k)
        velocity = velocity_at(pose, away(pose.pivot, present.position, present.remainder))
        stretch = rows3(touch.friction, 3 * k, block)
        stretch = stretch + present.mean_step * turning(pose.spin, stretch)
        spring, pressed, dashpot, drag, held = contact(
            present, laws, tools.tool[k].friction, velocity, penetration, normal, stretch
        )
        if wp.static(traits.friction_laws):
            store_rows3(touch.friction, 3 * k, block, stretch)
            drag, held = rub_by_law(present, laws, tools, k, velocity, normal, pressed, touch)
        if wp.static(traits.follows_thickness):
            works[THICKNESS_WORK, block] = works[THICKNESS_WORK, block] + spring * present.growth
        touch.depth[k, block] = larger(touch.depth[k, block], penetration)
        return pressed + drag, drag, dashpot, held, dot(velocity, drag), dot(velocity, dashpot)

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
        pose = read_pose(tools, k)
        arm = away(pose.pivot, present.position, present.remainder)
        way = real(2.0) * present.mean_step * largest_speed(pose, arm)
        distance_left = touch.gap[k, block] - way - present.thickened
        if distance_left > real(0.0):
            touch.gap[k, block] = distance_left
            return lanes3(), lanes3(), lanes3(), lanes(), lanes()
        distance, normal, clearance = posed_distance(
            tools.part, tools.tool[k], pose, present.position, present.remainder
        )
        touch.gap[k, block] = -lane_maximum(present.half_thickness - clearance) - laws.spare_distance
        push, drag, dashpot, stretch, friction_power, dashpot_power = pushed(
            present, laws, tools, k, present.half_thickness - distance, normal, touch, works
        )
        store_rows3(touch.friction, 3 * k, block, stretch)
        touch.reaction[k, block] = on_tool(push)
        touch.moment[k, block] = on_tool(cross(arm, push))
        return push, drag, dashpot, friction_power, dashpot_power

    return each_tool_function(real, lane_count, meet_tool)


def meeting_function(real: type, lane_count: int, traits: NodeTraits):
    """The function with which points meet the tools of a run: of carried tools, or of others."""
    return (meet_carried_tools_function if traits.carried else meet_tools_function)(real, lane_count, traits)
