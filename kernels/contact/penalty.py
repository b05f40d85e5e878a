"""Contact of a node with a tool: penalty force, dashpot, friction spring (docs/theory.md, section 6)."""

from functools import cache
from typing import Any

import warp as wp

from ..lane_types import lane_types
from ..lanes import dot, fill, larger, scale, square_root, where_positive
from ..operators import add, div, mul, sub  # noqa: F401


@cache
def touch_struct(real: type, lane_count: int):
    """Contact data that nodes keep from step to step, and their forces on the tools; all of it is written."""
    types = lane_types(real, lane_count)

    @wp.struct
    class Touch:
        friction: wp.array2d(dtype=types.lanes)  # tangential spring of each tool [m], three rows each
        gap: wp.array2d(dtype=real)  # [tool, block]: distance before any node can touch [m]; unknown if not > 0
        depth: wp.array2d(dtype=types.lanes)  # [tool, block]: deepest that each node has been in a tool [m]
        argument: wp.array2d(dtype=types.lanes)  # smallest and largest of each tool's friction law; none without laws
        area: wp.array(dtype=types.lanes)  # constant: of each node in contact, for friction laws [m^2]; or none
        reaction: wp.array2d(dtype=types.vec3)  # [tool, block]: force of the sheet on the tool [N]
        moment: wp.array2d(dtype=types.vec3)  # [tool, block]: of it about the pivot, of runs with carried tools [N m]
        thickness: wp.array2d(dtype=types.lanes)  # rows: see ThicknessRow; none for the initial thickness
        moved: wp.array2d(dtype=real)  # [row, block], rows: see MovedRow; none without contact between nodes

    return Touch


@wp.func
def normal_force(penetration: Any, approach: Any, stiffness: Any, damping_time: Any):
    """Penalty force and its damped total, never pulling; ``approach`` > 0 where the sheet moves into the tool."""
    zero = fill(penetration, 0.0)
    spring = stiffness * larger(penetration, zero)
    total = where_positive(penetration, larger(spring + damping_time * (stiffness * approach), zero), zero)
    return spring, total


@wp.func
def friction_spring(trial: Any, stiffness: Any, limit: Any):
    """Coulomb return mapping: the tangential spring, shortened so that its force is within the limit."""
    force = stiffness * square_root(dot(trial, trial))
    # padding nodes have neither force nor limit, and no spring
    slid = limit / larger(force, fill(force, 1.0e-30))
    return scale(where_positive(limit - force, fill(force, 1.0), slid), trial)
