"""A damping for a new set-up: vibrations die away while the tools move, and what moves slowly hardly feels it.

Mass-proportional damping of rate c lets the amplitude of any vibration fall by exp(-c t / 2), whatever its frequency,
and takes rho c v^2 of power per area from a sheet of areal density rho that moves at the speed v. So the time of the
strokes decides: a vibration should fall by e a few times within it. With a speed at which the kinetic energy is a share
s of the work w of shearing (``speed.py``), a sheet that moved as fast as its punch all the way would lose 2 c T s of w;
most of a sheet moves far less. In the double dome, whose default is this suggestion, it is 0.6 % of the work.

A sheet that is released swings in its slowest bending, which critical damping of 2 omega stops soonest; with more it
creeps. For a flat free strip of length L, omega = 22.37 sqrt(B / rho) / L^2 (Blevins, Formulas for natural frequency
and mode shape, 1979, table 8-1); a formed part is stiffer, and swings faster.
"""

from __future__ import annotations

import math

import numpy as np

from ...fabric.fabric import Fabric

# A vibration falls by e so often within the strokes.
DECAYS = 6.0
# Of a free strip: (omega L^2)^2 rho / B is the square of it.
FREE_STRIP = 22.373
# Over the suggested damping, either way: beyond it is doubtful.
FAR_OFF = 8.0
_STEPS = np.array([1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0])


def suggested_damping(time: float) -> float:
    """For a run whose strokes take a ``time`` [s]: a damping rate, to a round number [1/s]."""
    return _rounded(2.0 * DECAYS / time)


def slowest_bending(fabric: Fabric, length: float) -> float:
    """Angular frequency of a flat free sheet of some length [m] in its slowest bending [rad/s]."""
    return FREE_STRIP * math.sqrt(fabric.bending_stiffness_scale / fabric.areal_density) / length**2


def release_damping(fabric: Fabric, length: float) -> float:
    """For a sheet of some length [m] that is released to come to rest: a damping rate, to a round number [1/s]."""
    return _rounded(2.0 * slowest_bending(fabric, length))


def _rounded(value: float) -> float:
    """A positive value to the nearest round number."""
    power = 10.0 ** math.floor(math.log10(value))
    nearest = _STEPS[np.argmin(np.abs(np.log(_STEPS * power / value)))]
    return float(f"{nearest * power:.3g}")
