"""Friction laws of a contact: the coefficient by a table, and a viscous film (docs/plies.md)."""

from functools import cache

import warp as wp

from ..lanes import fill, lane_types, larger, smaller
from ..operators import div, mul  # noqa: F401

# Argument of the table.
NO_ARGUMENT = wp.constant(0)  # Coulomb: one coefficient
PRESSURE = wp.constant(1)  # [Pa]
YARN_ANGLE = wp.constant(2)  # between the warps in touch [rad]
HERSEY = wp.constant(3)  # viscosity times speed over pressure [m]

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


@cache
def coefficient_function(real: type, lane_count: int):
    """wp.func (law, argument) -> coefficient."""
    lanes, FrictionLaw = lane_types(real, lane_count).lanes, friction_law_struct(real)

    @wp.func
    def coefficient(law: FrictionLaw, argument: lanes):
        result = lanes(law.coefficient[0])
        one = fill(argument, 1.0)
        for k in range(1, law.argument.shape[0]):
            span = law.argument[k] - law.argument[k - 1]
            share = (argument - lanes(law.argument[k - 1])) / lanes(span)
            share = larger(smaller(share, one), lanes())
            result = result + (law.coefficient[k] - law.coefficient[k - 1]) * share
        return result

    return coefficient
