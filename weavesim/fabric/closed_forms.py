"""Closed forms of the fabric tests: trellis, zones of the bias extension, heavy strip (docs/theory.md, section 9)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError

if TYPE_CHECKING:
    from .fabric import Fabric

# Stretches of the family across a pull between which its equilibrium is looked for.
SMALLEST_FREE_STRETCH, LARGEST_FREE_STRETCH = 0.5, 1.2


def bias_zone_areas(length: float, width: float) -> tuple[float, float, float]:
    """Areas of the zones A, B, C of a bias-extension strip [m^2]; A does not shear, B half as much as C.

    Args:
        length, width: between the clamps [m], the length at least twice the width.
    """
    return 0.5 * width**2, width**2, width * (length - 1.5 * width)


def trellis_angle(diagonal: np.ndarray | float, side: float) -> np.ndarray:
    """Shear angle of a rhombus [rad], pi/2 - 2 acos(diagonal / (2 side)), from its longer diagonal [m]."""
    return 0.5 * math.pi - 2.0 * np.arccos(np.clip(np.asarray(diagonal) / (2.0 * side), 0.0, 1.0))


def trellis_angle_rate(diagonal: np.ndarray | float, side: float) -> np.ndarray:
    """d(shear angle)/d(diagonal) of a rhombus [rad/m], 1/(side sin(theta)), theta half the angle at its tip."""
    share = np.clip(np.asarray(diagonal) / (2.0 * side), 0.0, 1.0)
    return 1.0 / (side * np.sqrt(1.0 - share**2))


def moment_along(
    fabric: Fabric, angle: np.ndarray, crossover_pressure: np.ndarray | float = 0.0, *, stretch: float = 1.0
) -> np.ndarray:
    """Shear moment [N/m] along a path of angles (n,) [rad] from rest, from shear law, unit cell and friction.

    Args:
        fabric: its unit cell contributes if its energy depends on the shear angle.
        angle: the path.
        crossover_pressure: along the path [N/m^2].
        stretch: of both yarn families, for the unit cell.
    """
    angle = np.asarray(angle, dtype=float)
    moment = np.asarray(fabric.shear.moment(angle, fabric.thickness))
    if fabric.unit_cell.law().depends_on_shear:
        from .response import respond

        moment = moment + respond(fabric.unit_cell, np.full((len(angle), 2), stretch), angle).moment
    if fabric.shear_friction is not None:
        moment = moment + fabric.shear_friction.moment_along(angle, crossover_pressure)
    return moment


def peirce_stiffness(angle: float, length: float, weight: float) -> float:
    """Peirce's D = w c^3 [N m], c = length (cos(angle/2) / (8 tan(angle)))^(1/3).

    Args:
        angle: of the chord below the horizontal [rad].
        length: of the overhang [m].
        weight: per area [N/m^2].
    """
    return weight * length**3 * math.cos(0.5 * angle) / (8.0 * math.tan(angle))


def heavy_elastica(tip_slope: float, step_count: int = 2000) -> tuple[float, float]:
    """Load w L^3 / D and chord angle [rad] of a clamped, inextensible strip whose tip slope is ``tip_slope`` [rad].

    From the free end, with lengths scaled by (D/w)^(1/3): slope'' = -s cos(slope), slope(0) = tip_slope, slope'(0) = 0,
    up to the clamp, where the slope is zero. Fourth-order Runge-Kutta, with a last step that ends at the clamp.
    """

    def rate(s: float, y: np.ndarray) -> np.ndarray:
        return np.array([y[1], -s * math.cos(y[0]), math.cos(y[0]), math.sin(y[0])])

    def advanced(s: float, y: np.ndarray, h: float) -> np.ndarray:
        k1 = rate(s, y)
        k2 = rate(s + 0.5 * h, y + 0.5 * h * k1)
        k3 = rate(s + 0.5 * h, y + 0.5 * h * k2)
        k4 = rate(s + h, y + h * k3)
        return y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)

    # a nearly straight strip of the same tip slope has this length; for a steep one the loop continues
    h = (6.0 * tip_slope) ** (1.0 / 3.0) / step_count
    s, y = 0.0, np.array([tip_slope, 0.0, 0.0, 0.0])
    while True:
        following = advanced(s, y, h)
        if following[0] <= 0.0:
            break
        s, y = s + h, following
    low, high = 0.0, h
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if advanced(s, y, middle)[0] > 0.0 else (low, middle)
    end = advanced(s, y, low)
    return (s + low) ** 3, math.atan2(end[3], end[2])


def elastica_stiffness(angle: float, length: float, weight: float) -> float:
    """D [N m] of the heavy elastica whose chord has this angle; arguments as ``peirce_stiffness``."""
    low, high = 1.0e-6, 0.5 * math.pi - 1.0e-6
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if heavy_elastica(middle, 400)[1] < angle else (low, middle)
    return weight * length**3 / heavy_elastica(low)[0]


def elastica_profile(length: float, stiffness: float, weight: float, arc: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal distance from the clamp and drop below it [m] of the heavy elastica, (k,) each.

    Args:
        length: of the overhang [m].
        stiffness: D per width [N m].
        weight: per area [N/m^2].
        arc: lengths along the strip from the clamp [m], (k,).
    """
    from scipy.integrate import solve_ivp

    load = weight * length**3 / stiffness
    low, high = 1.0e-9, 0.5 * math.pi - 1.0e-9
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if heavy_elastica(middle, 400)[0] < load else (low, middle)
    scale, end = length / load ** (1.0 / 3.0), load ** (1.0 / 3.0)

    def rate(s: float, y: np.ndarray) -> list[float]:
        return [y[1], -s * math.cos(y[0]), math.cos(y[0]), math.sin(y[0])]

    path = solve_ivp(rate, (0.0, end), [low, 0.0, 0.0, 0.0], dense_output=True, rtol=1.0e-8, atol=1.0e-10).sol
    from_tip = np.clip(end - np.asarray(arc) / scale, 0.0, end)
    _, _, x, drop = path(end)[:, None] - path(from_tip)
    return scale * x, scale * drop


def yarn_forces(fabric: Fabric, stretch: np.ndarray) -> np.ndarray:
    """Forces per width of warp and weft (n, 2) [N/m] at stretches of both (n, 2), without shear.

    Those of the unit cell, and of the sheet itself where a family is pushed together.
    """
    from .response import respond

    stretch = np.asarray(stretch, dtype=float)
    pushed = fabric.compressive_stiffness * np.minimum(stretch - 1.0, 0.0)
    return respond(fabric.unit_cell, stretch).force_per_width + pushed


def free_stretch(fabric: Fabric, stretch: np.ndarray, *, pulled: int) -> np.ndarray:
    """Stretch (n,) of the family across a pull at which it carries no force, by bisection.

    Args:
        fabric: its unit cell and its compressive stiffness count.
        stretch: of the pulled family, (n,).
        pulled: 0 for the warp, 1 for the weft.

    Raises:
        InputError: there is none between a half and 1.2.
    """
    stretch = np.asarray(stretch, dtype=float)
    low, high = (np.full(len(stretch), limit) for limit in (SMALLEST_FREE_STRETCH, LARGEST_FREE_STRETCH))

    def force(across: np.ndarray) -> np.ndarray:
        pair = (stretch, across) if pulled == 0 else (across, stretch)
        return yarn_forces(fabric, np.stack(pair, axis=1))[:, 1 - pulled]

    if np.any(force(low) > 0.0) or np.any(force(high) < 0.0):
        raise InputError(
            f"uniaxial pull to a stretch of {stretch.max():.4g}: the other family finds no equilibrium between "
            f"stretches of {SMALLEST_FREE_STRETCH:g} and {LARGEST_FREE_STRETCH:g}; reduce the strain"
        )
    for _ in range(50):
        middle = 0.5 * (low + high)
        above = force(middle) > 0.0
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return 0.5 * (low + high)
