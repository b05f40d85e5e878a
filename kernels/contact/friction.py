"""Friction laws of a contact: the coefficient by a table, and a viscous film (docs/plies.md)."""

from functools import cache
from typing import Any

import warp as wp

from ..lane_types import lane_types
from ..lanes import fill, larger, smaller, where_positive
from ..operators import add, div, mul, sub  # noqa: F401

# Argument of the table.
NO_ARGUMENT = wp.constant(0)  # Coulomb: one coefficient
PRESSURE = wp.constant(1)  # [Pa]
YARN_ANGLE = wp.constant(2)  # between the warps in touch [rad]
HERSEY = wp.constant(3)  # viscosity times speed over pressure [m]
# Smallest argument of a law that has met none yet; the largest is its opposite.
UNMET = wp.constant(1.0e30)

# Below this pressure nothing is said about a Hersey number [Pa].
LEAST_PRESSURE = wp.constant(1.0)


@cache
def friction_law_struct(real: type):
    """One law: a coefficient that is piecewise linear in its argument, constant beyond the ends, and a film."""

    @wp.struct
    class FrictionLaw:
        argument_kind: wp.int32
        argument: wp.array(dtype=real)  # ascending; see above
        coefficient: wp.array(dtype=real)
        viscosity: real  # for the Hersey number [Pa s]
        film: real  # drag over speed and area, bounded for the stable step [Pa s/m]

    return FrictionLaw


@cache
def tool_friction_struct(real: type):
    """The law of one tool: as ``friction_law_struct``, with its table among those of all tools."""

    @wp.struct
    class ToolFriction:
        argument_kind: wp.int32
        first: wp.int32  # entries of its table
        last: wp.int32  # one past its end
        viscosity: real  # for the Hersey number [Pa s]
        film: real  # drag over speed and area, bounded for the stable step [Pa s/m]

    return ToolFriction


@wp.func
def law_argument(law: Any, pressure: Any, speed: Any):
    """Of a law's table: the Hersey number, or else the pressure."""
    argument = pressure
    if law.argument_kind == HERSEY:
        argument = law.viscosity * speed / larger(pressure, fill(pressure, LEAST_PRESSURE))
    return argument


@wp.func
def widened(low: Any, high: Any, argument: Any, pressure: Any):
    """Extremes of an argument so far, with the present one where there is pressure."""
    told = pressure - fill(pressure, LEAST_PRESSURE)
    return where_positive(told, smaller(low, argument), low), where_positive(told, larger(high, argument), high)


@cache
def table_function(real: type, lane_count: int):
    """wp.func (arguments, coefficients, first, last, x) -> coefficient at x, from the entries first to last - 1."""
    lanes = lane_types(real, lane_count).lanes

    @wp.func
    def coefficient_at(
        argument: wp.array(dtype=real), coefficient: wp.array(dtype=real), first: wp.int32, last: wp.int32, x: lanes
    ):
        result = lanes(coefficient[first])
        one = fill(x, 1.0)
        for k in range(first + 1, last):
            span = argument[k] - argument[k - 1]
            share = (x - lanes(argument[k - 1])) / lanes(span)
            share = larger(smaller(share, one), lanes())
            result = result + (coefficient[k] - coefficient[k - 1]) * share
        return result

    return coefficient_at
