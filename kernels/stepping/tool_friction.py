"""Friction of a block of nodes on a tool by a law: a table, and a viscous film (docs/theory.md, section 6)."""

from functools import cache

import warp as wp

from ..contact.friction import HERSEY, LEAST_PRESSURE, NO_ARGUMENT, tool_friction_struct
from ..contact.penalty import friction_spring, touch_struct
from ..contact.tool_distance import tool_set_struct
from ..lanes import dot, fill, lane_types, larger, rows3, scale, smaller, square_root, where_positive
from ..operators import div, mul  # noqa: F401
from .node_data import node_laws_struct, present_struct


@cache
def tool_coefficient_function(real: type, lane_count: int):
    """wp.func (tools, law, argument) -> coefficient, as ``coefficient_function``."""
    lanes, Tools = lane_types(real, lane_count).lanes, tool_set_struct(real)
    ToolFriction = tool_friction_struct(real)

    @wp.func
    def coefficient(tools: Tools, law: ToolFriction, argument: lanes):
        result = lanes(tools.coefficient[law.first])
        one = fill(argument, 1.0)
        for k in range(law.first + 1, law.last):
            span = tools.argument[k] - tools.argument[k - 1]
            share = (argument - lanes(tools.argument[k - 1])) / lanes(span)
            share = larger(smaller(share, one), lanes())
            result = result + (tools.coefficient[k] - tools.coefficient[k - 1]) * share
        return result

    return coefficient


@cache
def rub_by_law_function(real: type, lane_count: int):
    """wp.func -> (force of friction, friction spring); the extremes of the law's argument are written."""
    types = lane_types(real, lane_count)
    lanes, lanes3, vec3 = types.lanes, types.lanes3, types.vec3
    Present, NodeLaws = present_struct(real, lane_count), node_laws_struct(real)
    Tools, Touch = tool_set_struct(real), touch_struct(real, lane_count)
    ToolFriction = tool_friction_struct(real)
    coefficient = tool_coefficient_function(real, lane_count)

    @wp.func
    def argument_of(law: ToolFriction, pressure: lanes, speed: lanes, touch: Touch, row: wp.int32, block: wp.int32):
        argument = pressure
        if law.argument_kind == HERSEY:
            argument = law.viscosity * speed / larger(pressure, lanes(real(LEAST_PRESSURE)))
        if law.argument_kind != NO_ARGUMENT:
            told = pressure - lanes(real(LEAST_PRESSURE))
            largest_row = row + 1  # behind that of the smallest
            low = touch.argument[row, block]
            high = touch.argument[largest_row, block]
            touch.argument[row, block] = where_positive(told, smaller(low, argument), low)
            touch.argument[largest_row, block] = where_positive(told, larger(high, argument), high)
        return argument

    @wp.func
    def rub_by_law(
        present: Present,
        laws: NodeLaws,
        tools: Tools,
        tool: wp.int32,
        tool_velocity: vec3,
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
        held = friction_spring(trial, tangential, wp.cw_mul(coefficient(tools, law, argument), push))
        film = where_positive(push, law.film * area, lanes())
        drag = -(scale(tangential, held) + scale(film, flat))
        return drag, held

    return rub_by_law
