"""Shear by a curve of the moment over the angle: dpsi/da_1 = m dgamma/da_1 (docs/theory.md, section 3)."""

from functools import cache
from typing import Any

import warp as wp

from ..curve import curve_energy, curve_struct, odd_curve
from ..lanes import fill, larger
from .contract import ShearDevice


@cache
def parameters(real: type):
    """Constants of the law in one precision, as a Warp struct."""

    @wp.struct
    class MomentCurve:
        curve: curve_struct(real)  # moment per reference area over the angle [N/m]

    return MomentCurve


@wp.func
def curve_resultants(laws: Any, m: Any):
    moment, tangent = odd_curve(laws.shear.curve, m.angle)
    return moment, fill(moment, 0.0)


@wp.func
def curve_psi(laws: Any, m: Any):
    return curve_energy(laws.shear.curve, m.angle)


@wp.func
def curve_moment(laws: Any, m: Any):
    moment, tangent = odd_curve(laws.shear.curve, m.angle)
    return moment


@wp.func
def curve_tangent(laws: Any, m: Any, sine: Any, cosine: Any, t: Any):
    moment, stiffness = odd_curve(laws.shear.curve, m.angle)
    t.c33 = larger(stiffness, fill(stiffness, 0.0))
    t.moment = moment
    return t


LAW = ShearDevice(parameters, curve_resultants, curve_psi, curve_moment, curve_tangent)
