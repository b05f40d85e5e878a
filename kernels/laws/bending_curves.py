"""Bending per yarn family by moment curves (docs/theory.md, section 4): like ``yarn_bending``, with D_nu = 0.

psi_k is the integral of the family's moment over k_kk/m_kk.
"""

from functools import cache
from typing import Any

import warp as wp

from ..curve import curve_energy, curve_struct, odd_curve
from ..operators import add, div, mul, sub  # noqa: F401
from .contract import YARN_CURVATURE_COUPLING, YARN_CURVATURE_STIFFENING, BendingDevice, yarn_widening
from .yarn_bending import family_resultants


@cache
def parameters(real: type):
    """Constants of the law in one precision, as a Warp struct."""

    @wp.struct
    class BendingCurves:
        twist_stiffness: real  # D_12 [N m]
        warp_curve: curve_struct(real)  # moment over curvature [N]
        weft_curve: curve_struct(real)

    return BendingCurves


@wp.func
def curve_resultants(laws: Any, m: Any, b: Any, r: Any):
    """psi_k is the integral of the family's moment over k_kk/m_kk; D_nu = 0."""
    warp_moment, warp_tangent = odd_curve(laws.bending.warp_curve, b.k11 / m.m11)
    weft_moment, weft_tangent = odd_curve(laws.bending.weft_curve, b.k22 / m.m22)
    return family_resultants(laws, m, b, warp_moment / m.m11, weft_moment / m.m22, r)


@wp.func
def curve_psi(laws: Any, m: Any, b: Any, r: Any):
    return (
        curve_energy(laws.bending.warp_curve, b.k11 / m.m11)
        + curve_energy(laws.bending.weft_curve, b.k22 / m.m22)
        + r.moment12 * b.k12
    )


LAW = BendingDevice(
    parameters,
    curve_resultants,
    curve_psi,
    widening=yarn_widening,
    curvature_stiffening=YARN_CURVATURE_STIFFENING,
    curvature_coupling=YARN_CURVATURE_COUPLING,
)
