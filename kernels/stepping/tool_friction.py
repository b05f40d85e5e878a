"""Friction of a block of nodes on a tool by a law: a table, and a viscous film (docs/theory.md, section 6)."""

from functools import cache

import warp as wp

from ..contact.friction import NO_ARGUMENT, law_argument, table_function, tool_friction_struct, widened
from ..contact.penalty import friction_spring, touch_struct
from ..contact.tool_distance import tool_set_struct
from ..lane_types import lane_types
from ..lanes import dot, larger, negative, rows3, scale, square_root, where_positive
from ..operators import add, div, mul, sub  # noqa: F401
from .node_data import node_laws_struct, present_struct


@cache
def rub_by_law_function(real: type, lane_count: int, carried: bool = False):
    """wp.func -> (force of friction, friction spring); the extremes of the law's argument are written.

    The velocity of a tool that is ``carried`` differs between the lanes.
    """
    types = lane_types(real, lane_count)
    lanes, lanes3 = types.lanes, types.lanes3
    velocity_type = types.lanes3 if carried else types.vec3
    Present, NodeLaws = present_struct(real, lane_count), node_laws_struct(real)
    Tools, Touch = tool_set_struct(real), touch_struct(real, lane_count)
    ToolFriction = tool_friction_struct(real)
    coefficient_at = table_function(real, lane_count)

    @wp.func
    def argument_of(law: ToolFriction, pressure: lanes, speed: lanes, touch: Touch, row: wp.int32, block: wp.int32):
        argument = law_argument(law, pressure, speed)
        if law.argument_kind != NO_ARGUMENT:
            largest_row = row + 1  # behind that of the smallest
            low, high = widened(touch.argument[row, block], touch.argument[largest_row, block], argument, pressure)
            touch.argument[row, block] = low
            touch.argument[largest_row, block] = high
        return argument

    @wp.func
    def rub_by_law(
        present: Present,
        laws: NodeLaws,
        tools: Tools,
        tool: wp.int32,
        tool_velocity: velocity_type,
        n: lanes3,
        pressed: lanes3,
        touch: Touch,
    ):
        law = tools.law[tool]
        push = dot(pressed, n)
        relative = present.velocity
        for c in range(3):
            relative[c] = relative[c] - lanes(tool_velocity[c])
        flat = relative - scale(dot(relative, n), n)
        area = touch.area[present.block]  # none of padding
        pressure = push / larger(area, lanes(real(1.0e-30)))
        speed = square_root(dot(flat, flat))
        argument = argument_of(law, pressure, speed, touch, 2 * tool, present.block)
        stretched = rows3(touch.friction, 3 * tool, present.block) + present.mean_step * relative
        trial = stretched - scale(dot(stretched, n), n)
        tangential = laws.tangential_ratio * (laws.contact_stiffness * present.mass)
        coefficient = coefficient_at(tools.argument, tools.coefficient, law.first, law.last, argument)
        held = friction_spring(trial, tangential, mul(coefficient, push))
        film = where_positive(push, law.film * area, lanes())
        return negative(scale(tangential, held) + scale(film, flat)), held

    return rub_by_law
