"""In-plane shear without its law (docs/theory.md, section 3): forces from moments, and the friction slider."""

from functools import cache
from typing import Any

import warp as wp

from ..curve import book_loss, slide
from ..lanes import fill, where_positive
from ..laws.contract import device_law
from ..operators import add, div, mul, sub  # noqa: F401
from ..rows import SlipRow
from .laws import SheetTraits


@wp.func
def moment_resultants(moment: Any, m12: Any, inverse1: Any, inverse2: Any, inverse_ratio: Any):
    """T11, T12, T22 of a moment m = dpsi/dgamma: dgamma/da_1 = (a_2 - a_1 m12/m11)/J, likewise for a_2.

    Arguments are the reciprocals of the stretches, whose squares are m11 and m22, and of J.
    """
    t12 = moment * inverse_ratio
    across = -(t12 * m12)
    return across * inverse1 * inverse1, t12, across * inverse2 * inverse2


# --- friction between the yarns that rotate on each other -------------------------------------------------------------


@cache
def shear_friction_function(traits: SheetTraits):
    """Function for the friction moment [N/m]; it writes slip, spring and the work lost."""
    friction_limit = device_law(traits.shear_friction).limit

    @wp.func
    def shear_friction(laws: Any, block: int, angle: Any, crossover_pressure: Any, slip: Any):
        limit = friction_limit(laws, angle, crossover_pressure)
        turned, spring, lost = slide(
            angle,
            slip[SlipRow.shear_slip, block],
            slip[SlipRow.shear_spring, block],
            laws.shear_friction.stiffness,
            limit,
            laws.slip_resolution,
        )
        slip[SlipRow.shear_slip, block] = turned
        slip[SlipRow.shear_spring, block] = spring
        book_loss(slip, SlipRow.shear_friction_loss, SlipRow.shear_friction_remainder, block, lost)
        return laws.shear_friction.stiffness * spring

    return shear_friction


@cache
def sticking_function(traits: SheetTraits):
    """Function that adds friction to a ``Tangent`` of shear: sticking, with the largest possible moment."""
    friction_limit = device_law(traits.shear_friction).limit

    @wp.func
    def sticking_shear(laws: Any, angle: Any, crossover_pressure: Any, t: Any):
        limit = friction_limit(laws, angle, crossover_pressure)
        t.c33 = t.c33 + fill(angle, laws.shear_friction.stiffness)
        t.moment = t.moment + where_positive(t.moment, limit, -limit)
        return t

    return sticking_shear
