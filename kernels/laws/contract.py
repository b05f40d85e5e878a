"""Device form of the laws of shear, shear friction and bending: a module with a ``LAW`` of one of these classes.

Such a module contains a struct of the law's constants and its functions of lanes. A function gets the constants of the
sheet, ``laws``, where ``laws.shear``, ``laws.shear_friction`` and ``laws.bending`` are the structs of the sheet's laws.
m is a ``Membrane``, b a ``Bend``, r the ``Resultants`` and t the ``Tangent`` that the functions fill.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any

import warp as wp

from ..lanes import fill, magnitude
from ..operators import add, div, mul, sub  # noqa: F401


@dataclass(frozen=True, eq=False)
class ShearDevice:
    """A shear law without friction, as the kernels use it.

    Attributes:
        parameters: ``parameters(real)`` is the struct of the law's constants in one precision.
        resultants: (laws, m) -> moment dpsi/dgamma [N/m], and T12 in addition to that of the moment.
        energy: (laws, m) -> psi [J/m^2].
        moment: (laws, m) -> total dpsi/dgamma at constant stretches [N/m].
        tangent: (laws, m, sine, cosine, t) -> the filled ``Tangent`` t; sine and cosine are those of the angle.
    """

    parameters: Callable[[type], Any]
    resultants: Any
    energy: Any
    moment: Any
    tangent: Any


@dataclass(frozen=True, eq=False)
class FrictionDevice:
    """A law of friction between yarns that rotate on each other: a spring and slider in series.

    Attributes:
        parameters: ``parameters(real)`` is the struct of the law's constants; one is the spring's ``stiffness`` [N/m].
        limit: (laws, angle, pressure) -> moment at which the yarns slip [N/m], with the crossover pressure [Pa].
    """

    parameters: Callable[[type], Any]
    limit: Any


@dataclass(frozen=True, eq=False)
class BendingDevice:
    """A bending law without friction, as the kernels use it.

    Attributes:
        parameters: ``parameters(real)`` is the struct of the law's constants in one precision.
        resultants: (laws, m, b, r) -> r with the moments and T of bending set.
        energy: (laws, m, b, r) -> psi [J/m^2], with the moments of r.
        widening: (m, sine) -> factor of the largest stiffness for any curvature; the sine is that of the shear angle.
        curvature_stiffening, curvature_coupling: bounds of the second derivatives of psi with respect to positions, and
            to positions and directors, over that stiffness times the squared curvature and times the curvature
            (docs/theory.md, section 7, *Coupled terms*).
    """

    parameters: Callable[[type], Any]
    resultants: Any
    energy: Any
    widening: Any
    curvature_stiffening: float
    curvature_coupling: float


@cache
def device_law(module: str) -> Any:
    """The law of a module, given by its full name; unlike functions, a name can be sent to another process."""
    return import_module(module).LAW


@wp.func
def yarn_widening(m: Any, sine: Any):
    """Laws of the yarns' own curvatures do not contain J; oblique yarns both bend with the diagonal between them."""
    return fill(sine, 1.0) + magnitude(sine)


# Proven for these laws (docs/theory.md, section 7, *Coupled terms*).
YARN_CURVATURE_STIFFENING = 19.0
YARN_CURVATURE_COUPLING = 6.0


@wp.func
def quadratic_energy(laws: Any, m: Any, b: Any, r: Any):
    """psi of moments linear in the curvatures."""
    half = b.k11.dtype(0.5)
    return half * (r.moment11 * b.k11 + r.moment22 * b.k22) + r.moment12 * b.k12
