"""A speed for strokes: slow enough that the inertia of the sheet says little, fast enough to be affordable.

A run is quasi-static while the kinetic energy is a small share of the internal one. Under a punch of speed v a sheet of
areal density rho moves with rho v^2 / 2 per area, and shearing it by 30 degrees takes the work w per area, so that a
share s of it is v = sqrt(2 s w / rho). Half a metre per second for the double dome, where s is found in the run.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from ...fabric.fabric import Fabric

# Share of the work of shearing that the kinetic energy may have, and the shear angle of that work [rad].
KINETIC_SHARE = 0.01
SHEAR_ANGLE = math.radians(30.0)
# Speeds between which one is suggested [m/s].
SLOWEST, FASTEST = 0.05, 2.0
_STEPS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)


def shear_work(fabric: Fabric) -> float:
    """Work per area to shear a fabric by 30 degrees [J/m^2]."""
    angle = np.linspace(0.0, SHEAR_ANGLE, 61)
    cell = fabric.unit_cell
    if cell.law().depends_on_shear:
        moment = cell.shear_stiffness * angle
    else:
        moment = fabric.shear.moment(angle, fabric.thickness)
    return float(np.sum(0.5 * (moment[1:] + moment[:-1]) * np.diff(angle)))


def suggested_speed(fabrics: Iterable[Fabric]) -> float:
    """A speed for the strokes that form these fabrics, rounded down [m/s]."""
    speeds = [
        math.sqrt(2.0 * KINETIC_SHARE * max(shear_work(fabric), 0.0) / fabric.areal_density) for fabric in fabrics
    ]
    return rounded_down(float(np.clip(min(speeds), SLOWEST, FASTEST)))


def rounded_down(value: float) -> float:
    """A positive value down to a round number."""
    power = 10.0 ** math.floor(math.log10(value) + 1e-9)
    return float(f"{power * max(step for step in _STEPS if step <= value / power * (1.0 + 1e-9)):.3g}")
