"""How a tool moves along its axis: fixed, by a prescribed stroke, or by a force."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .errors import InputError
from .shapes import finite, positive

# Knots of each smooth ramp: the speed of the piecewise linear stroke then changes by less than 0.4 % at a knot.
RAMP_KNOT_COUNT = 400


@dataclass(frozen=True)
class Fixed:
    """A tool that stays where it is."""

    def curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Times [s] and displacements along the axis [m]."""
        return np.zeros(1), np.zeros(1)


@dataclass(frozen=True)
class Stroke:
    """Displacement along the axis prescribed in time: linear between the knots, constant before and after them.

    Attributes:
        times: increasing [s].
        displacements: one per time [m].
    """

    times: tuple[float, ...]
    displacements: tuple[float, ...]

    def __post_init__(self) -> None:
        _check_curve(self, "displacements")

    @property
    def duration(self) -> float:
        """Time of the last knot [s]."""
        return self.times[-1]

    @classmethod
    def smooth(cls, distance: float, speed: float, ramp_time: float, start_time: float = 0.0) -> Stroke:
        """Constant speed with a smooth start and stop.

        The speed follows 3s^2 - 2s^3 over each ramp, so that the acceleration has no jump. A ramp too long for the
        distance is shortened to ``distance / speed``.

        Args:
            distance: of the whole stroke [m]; negative moves against the axis.
            speed: between the ramps [m/s], positive.
            ramp_time: of the start, and of the stop [s]; zero gives a constant speed at once.
            start_time: rest before the stroke [s].

        Returns:
            A stroke of duration ``start_time + |distance| / speed + ramp_time``.
        """
        distance = finite("distance of the stroke", distance)
        speed = positive("speed of the stroke", speed)
        ramp_time = finite("ramp_time of the stroke", ramp_time)
        start_time = finite("start_time of the stroke", start_time)
        if distance == 0.0 or ramp_time < 0.0 or start_time < 0.0:
            raise InputError(
                f"Stroke.smooth is given distance {distance} m, ramp_time {ramp_time} s and start_time {start_time} s; "
                "the distance must not be zero and the times must not be negative. A tool at rest is Fixed()."
            )
        ramp_time = min(ramp_time, abs(distance) / speed)
        end = abs(distance) / speed + ramp_time
        if ramp_time > 0.0:
            s = np.linspace(0.0, 1.0, RAMP_KNOT_COUNT + 1)
            rise = speed * ramp_time * (s**3 - 0.5 * s**4)
            times = np.concatenate([ramp_time * s, (end - ramp_time * s)[::-1]])
            way = np.concatenate([rise, (abs(distance) - rise)[::-1]])
            keep = np.append(True, np.diff(times) > 1e-9 * end)  # the ramps may meet
            times, way = times[keep], way[keep]
        else:
            times, way = np.array([0.0, end]), np.array([0.0, abs(distance)])
        return cls(tuple((start_time + times).tolist()), tuple((math.copysign(1.0, distance) * way).tolist()))

    def curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Times [s] and displacements along the axis [m]."""
        return np.array(self.times), np.array(self.displacements)


@dataclass(frozen=True)
class Driven:
    """A tool that a force moves along its axis, such as a blank holder under pressure.

    Attributes:
        times: increasing [s].
        forces: along the axis, one per time [N]; linear between the knots, constant before and after them.
        mass: that the force moves [kg].
    """

    times: tuple[float, ...]
    forces: tuple[float, ...]
    mass: float

    def __post_init__(self) -> None:
        _check_curve(self, "forces")
        object.__setattr__(self, "mass", positive("Driven.mass", self.mass))

    @classmethod
    def constant(cls, force: float, mass: float, ramp_time: float = 0.0) -> Driven:
        """A force [N] along the axis that is reached at ``ramp_time`` [s] and then kept."""
        if ramp_time > 0.0:
            return cls((0.0, ramp_time), (0.0, force), mass)
        return cls((0.0,), (force,), mass)

    def curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Times [s] and forces along the axis [N]."""
        return np.array(self.times), np.array(self.forces)


Motion = Fixed | Stroke | Driven


def _check_curve(motion: Stroke | Driven, values_name: str) -> None:
    name = type(motion).__name__
    times = _numbers(f"{name}.times", motion.times)
    values = _numbers(f"{name}.{values_name}", getattr(motion, values_name))
    if len(times) == 0 or len(times) != len(values):
        raise InputError(
            f"{name} has {len(times)} times and {len(values)} {values_name}; it needs as many of one as of the other, "
            "and at least one."
        )
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if len(late):
        k = int(late[0])
        raise InputError(f"{name}.times goes from {times[k]} s to {times[k + 1]} s; times must increase.")
    object.__setattr__(motion, "times", tuple(times))
    object.__setattr__(motion, values_name, tuple(values))


def _numbers(what: str, values: Sequence[float]) -> list[float]:
    try:
        return [finite(f"entry of {what}", value) for value in values]
    except TypeError:
        raise InputError(f"{what} is {values!r}; it must be a list of numbers.") from None
