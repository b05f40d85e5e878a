"""How a tool moves along its axis (fixed, by a prescribed stroke, or by a force), and how a support moves."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import model_validator

from ..checks import Finite, Kinded, NotNegative, Positive
from ..errors import InputError
from ..quantities import Numbers, finite
from ..ranges import Quantity, argument

# Knots of each smooth ramp: the speed of the piecewise linear stroke then changes by less than 0.4 % at a knot.
RAMP_KNOT_COUNT = 400
# Rate at which the damper of a tool fades over the frequency of its mass on the contact: it is there for the landing.
FADING = 0.1


class Motion(Kinded):
    """How a tool moves along its axis, or a support along its directions.

    Attributes:
        moves_tools: whether it has a ``curve``.
        moves_supports: whether it has ``pieces``.
    """

    moves_tools: ClassVar[bool] = True
    moves_supports: ClassVar[bool] = False

    @property
    def by_force(self) -> bool:
        """Whether the curve is that of a force, which moves ``driven_mass``."""
        return False

    @property
    def is_carried(self) -> bool:
        """Whether it has a pose beside its displacement along the axis: a ``PathMotion``."""
        return False

    @property
    def along_axis(self) -> Motion:
        """The part of it that moves a tool along its axis."""
        return self

    @property
    def driven_mass(self) -> float:
        """What the force moves [kg]; zero where the displacement is prescribed."""
        return 0.0

    @property
    def limiting_force(self) -> float:
        """Force of the sheets at which a stroke waits [N]; zero where it never does."""
        return 0.0

    @property
    def spacers(self) -> tuple[float, float]:
        """Displacement at which spacers hold a tool that a force moves [m], and the way there; zeros for none."""
        return 0.0, 0.0

    def damper(self, stiffness: float) -> tuple[float, float]:
        """Damper of a tool that a force moves, on contact of ``stiffness`` [N/m]: where it lands [N s/m], fading [1/s].

        Zeros for none.
        """
        return 0.0, 0.0

    def force_at(self, time: float) -> float:
        """Force along the axis that drives a tool at ``time`` [s], in N; not a number where none does."""
        return math.nan

    def displacement_at(self, time: float) -> float:
        """Displacement along the axis of an unhindered stroke at ``time`` [s], in m; not a number by force."""
        return math.nan if self.by_force else float(np.interp(time, *self.curve()))

    def curve(self) -> tuple[np.ndarray, np.ndarray]:
        """For a tool: times [s], and displacements [m] or forces [N] along its axis, (n,) each."""
        raise NotImplementedError

    def pieces(self) -> tuple[np.ndarray, np.ndarray]:
        """For a support: start of every cubic piece (n,) [s], and c0 to c3 of its polynomial in the time since then.

        The coefficients are (n, 4) [m]; c0 is the displacement at a knot.
        """
        raise NotImplementedError

    @property
    def duration(self) -> float:
        """Time after which nothing changes [s]."""
        return 0.0

    @property
    def travel_time(self) -> float:
        """Time after which a prescribed motion is over [s]; zero by force."""
        return 0.0 if self.by_force else self.duration


class Knots(Motion):
    """Base class of motions given at knots in time.

    Attributes:
        times: increasing [s].
        values_name: name of the field with one value per time.
    """

    is_kind: ClassVar[bool] = False
    values_name: ClassVar[str]

    times: Annotated[Numbers, Quantity("time")]

    @model_validator(mode="after")
    def _is_a_curve(self) -> Self:
        times, values = self.times, getattr(self, self.values_name)
        if len(times) == 0 or len(times) != len(values):
            raise ValueError(
                f"it has {len(times)} times and {len(values)} {self.values_name}; give the same number of both, at "
                "least one"
            )
        late = np.flatnonzero(np.diff(times) <= 0.0)
        if len(late):
            k = int(late[0])
            raise ValueError(f"times goes from {times[k]} s to {times[k + 1]} s; times must increase")
        return self

    @property
    def duration(self) -> float:
        """Time of the last knot [s]."""
        return self.times[-1]


class Fixed(Motion):
    """A tool that does not move."""

    def curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Times [s] and displacements along the axis [m]."""
        return np.zeros(1), np.zeros(1)


class Stroke(Knots):
    """Displacement along the axis prescribed in time: linear between the knots, constant before and after them.

    Attributes:
        times: increasing [s].
        displacements: one per time [m].
        largest_force: of a tool, along its axis [N]: near it the stroke slows down, waits, and backs off where the
            sheets push with more; None for a press that is always strong enough. With it, times are those of an
            unhindered stroke.
    """

    positional = ("times", "displacements", "largest_force")
    values_name = "displacements"
    moves_supports = True

    displacements: Annotated[Numbers, Quantity("displacement")]
    largest_force: Annotated[Positive, Quantity("force")] | None = None

    @property
    def limiting_force(self) -> float:
        """``largest_force``, or zero [N]."""
        return self.largest_force or 0.0

    @classmethod
    def smooth(
        cls,
        distance: float,
        speed: float,
        ramp_time: float,
        start_time: float = 0.0,
        largest_force: float | None = None,
    ) -> Stroke:
        """Constant speed with a smooth start and stop.

        The speed follows 3s^2 - 2s^3 over each ramp, so that the acceleration is continuous. A ramp that is too long
        for the distance is shortened to ``distance / speed``.

        Args:
            distance: of the whole stroke [m]; negative values move against the axis.
            speed: between the ramps [m/s], positive.
            ramp_time: duration of the start, and of the stop [s]; with zero the speed is constant throughout.
            start_time: pause before the stroke [s].
            largest_force: of the stroke [N]; None for none.

        Returns:
            A stroke of duration ``start_time + |distance| / speed + ramp_time``.
        """
        distance = argument("distance of the stroke", distance, "displacement", zero=True, negative=True)
        speed = argument("speed of the stroke", speed, "speed")
        ramp_time = argument("ramp_time of the stroke", ramp_time, "time", zero=True, negative=True)
        start_time = argument("start_time of the stroke", start_time, "time", zero=True, negative=True)
        if distance == 0.0 or ramp_time < 0.0 or start_time < 0.0:
            raise InputError(
                f"Stroke.smooth got distance {distance} m, ramp_time {ramp_time} s and start_time {start_time} s; "
                "the distance must not be zero and the times must not be negative. For a tool at rest use Fixed()."
            )
        ramp_time = min(ramp_time, abs(distance) / speed)
        end = abs(distance) / speed + ramp_time
        if ramp_time > 0.0:
            s = np.linspace(0.0, 1.0, RAMP_KNOT_COUNT + 1)
            rise = speed * ramp_time * (s**3 - 0.5 * s**4)
            times = np.concatenate([ramp_time * s, (end - ramp_time * s)[::-1]])
            travel = np.concatenate([rise, (abs(distance) - rise)[::-1]])
            keep = np.append(True, np.diff(times) > 1e-9 * end)  # the ramps may meet
            times, travel = times[keep], travel[keep]
        else:
            times, travel = np.array([0.0, end]), np.array([0.0, abs(distance)])
        travel = math.copysign(1.0, distance) * travel
        return cls(tuple((start_time + times).tolist()), tuple(travel.tolist()), largest_force)

    def curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Times [s] and displacements along the axis [m]."""
        return np.array(self.times), np.array(self.displacements)

    def pieces(self) -> tuple[np.ndarray, np.ndarray]:
        """Straight pieces; the speed jumps at every knot."""
        times, pieces, rise = _pieces(self.times, self.displacements)
        pieces[:-1, 1] = rise
        return times, pieces


class ForceDriven(Knots):
    """A tool that is moved along its axis by a force, such as a blank holder under pressure.

    Attributes:
        times: increasing [s].
        forces: along the axis, one per time [N]; linear between the knots, constant before and after them.
        mass: moved by the force [kg].
        damping_ratio: of a damper between the tool and the ground that keeps it from bouncing, as a share of critical
            for its mass on the contact with all sheets. It acts when the tool lands and fades while it carries, so that
            a sheet which lifts the tool slowly feels the force alone. Zero for no damper.
        in_touch: whether the tool starts where it just touches a sheet, moved there along its axis, instead of where
            its shape was placed.
        stop: displacement along the axis, in the direction of the largest force, at which spacers hold the tool: a shut
            height [m]; None for none. In a stage too it counts from where the shape was placed.
    """

    positional = ("times", "forces", "mass")
    values_name = "forces"

    forces: Annotated[Numbers, Quantity("force")]
    mass: Annotated[Positive, Quantity("mass")]
    damping_ratio: Annotated[NotNegative, Quantity("damping ratio")] = 1.0
    in_touch: bool = False
    stop: Annotated[Finite, Quantity("displacement")] | None = None

    @classmethod
    def constant(cls, force: float, mass: float, ramp_time: float = 0.0, **values: Any) -> ForceDriven:
        """A force [N] along the axis that is reached at ``ramp_time`` [s] and then held constant.

        Args:
            force, mass, ramp_time: of the tool.
            **values: the other attributes.

        Raises:
            InputError: a ramp time that is negative or not finite.
        """
        if not finite("ramp_time", ramp_time) >= 0.0:
            raise InputError(f"ramp_time = {ramp_time}: a time [s] of zero or more is needed")
        if ramp_time > 0.0:
            return cls((0.0, ramp_time), (0.0, force), mass, **values)
        return cls((0.0,), (force,), mass, **values)

    @property
    def by_force(self) -> bool:
        """True."""
        return True

    @property
    def driven_mass(self) -> float:
        """The mass moved by the force [kg]."""
        return self.mass

    def force_at(self, time: float) -> float:
        """Of the curve, in N."""
        return float(np.interp(time, self.times, self.forces))

    @property
    def spacers(self) -> tuple[float, float]:
        """``stop``, and the sign of the largest force."""
        return (0.0, 0.0) if self.stop is None else (self.stop, self.way)

    @property
    def way(self) -> float:
        """Sign of the largest force along the axis; 1 if all are zero."""
        return math.copysign(1.0, max(self.forces, key=abs) or 1.0)

    def damper(self, stiffness: float) -> tuple[float, float]:
        """2 ``damping_ratio`` sqrt(stiffness mass) [N s/m], and ``FADING`` sqrt(stiffness / mass) [1/s]."""
        frequency = math.sqrt(stiffness / self.mass)
        return 2.0 * self.damping_ratio * self.mass * frequency, FADING * frequency

    def curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Times [s] and forces along the axis [N]."""
        return np.array(self.times), np.array(self.forces)


class SmoothStroke(Knots):
    """Displacement prescribed in time with a continuous speed, for supports.

    Cubic between the knots (Hermite), constant before and after them. A support moves the sheet itself, so every jump
    in its speed would send a tension wave through the yarns; with a tool, contact softens such jumps.

    Attributes:
        times: increasing [s].
        displacements: one per time [m].
        speeds: one per time [m/s].
    """

    positional = ("times", "displacements", "speeds")
    values_name = "displacements"
    moves_tools = False
    moves_supports = True

    displacements: Annotated[Numbers, Quantity("displacement")]
    speeds: Annotated[Numbers, Quantity("speed")]

    @model_validator(mode="after")
    def _has_speeds(self) -> Self:
        if len(self.speeds) != len(self.times):
            raise ValueError(f"it has {len(self.times)} times and {len(self.speeds)} speeds; give one speed per time")
        return self

    @classmethod
    def ramped(cls, distance: float, speed: float, ramp_time: float, start_time: float = 0.0) -> SmoothStroke:
        """The motion of ``Stroke.smooth``, which explains the arguments, with a continuous speed."""
        knots = Stroke.smooth(distance, speed, ramp_time, start_time)
        end = knots.duration - start_time
        ramp_time = min(ramp_time, abs(distance) / speed)
        # knots on the straight part too: a stroke mapped from this one need not be straight there
        straight = np.linspace(ramp_time, end - ramp_time, RAMP_KNOT_COUNT + 2)[1:-1]
        times = np.unique(np.concatenate([np.array(knots.times) - start_time, straight]))
        times = times[np.append(True, np.diff(times) > 1e-9 * end)]
        if ramp_time > 0.0:
            share = np.clip(np.minimum(times, end - times) / ramp_time, 0.0, 1.0)
            speeds = speed * share**2 * (3.0 - 2.0 * share)
        else:
            speeds = np.full(len(times), speed)
        travel = np.interp(start_time + times, knots.times, np.abs(knots.displacements))
        sign = math.copysign(1.0, distance)
        return cls(*(tuple(v.tolist()) for v in (start_time + times, sign * travel, sign * speeds)))

    def pieces(self) -> tuple[np.ndarray, np.ndarray]:
        """Cubic pieces (Hermite); the speed is continuous."""
        times, pieces, rise = _pieces(self.times, self.displacements)
        h, v0, v1 = np.diff(times), self.speeds[:-1], self.speeds[1:]
        pieces[:-1, 1] = v0
        pieces[:-1, 2] = (3.0 * rise - np.multiply(2.0, v0) - v1) / h
        pieces[:-1, 3] = (np.add(v0, v1) - 2.0 * rise) / h**2
        return times, pieces

    def mapped(
        self, value: Callable[[np.ndarray], np.ndarray], slope: Callable[[np.ndarray], np.ndarray]
    ) -> SmoothStroke:
        """The stroke f(s) of a support that moves in step with this one.

        Args:
            value: f, from displacements [m] to displacements [m].
            slope: derivative of f.
        """
        travel = np.array(self.displacements)
        return SmoothStroke(self.times, tuple(value(travel)), tuple(slope(travel) * np.array(self.speeds)))

    def and_back(self, rest: float = 0.0) -> SmoothStroke:
        """This stroke, a ``rest`` [s] at its end, and the same stroke in reverse."""
        rest = finite("rest of the stroke", rest)
        if rest < 0.0:
            raise InputError(f"SmoothStroke.and_back got a rest of {rest} s; it must not be negative.")
        later = tuple(2.0 * self.duration + rest - time for time in self.times[::-1])
        skip = 0 if rest > 0.0 else 1
        return SmoothStroke(
            self.times + later[skip:],
            self.displacements + self.displacements[::-1][skip:],
            self.speeds + tuple(-speed for speed in self.speeds[::-1])[skip:],
        )


def _pieces(times: Numbers, displacements: Numbers) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times of the knots (n,) [s], pieces (n, 4) with c0 only, and slopes between the knots (n - 1,) [m/s]."""
    start, value = np.array(times), np.array(displacements)
    pieces = np.zeros((len(start), 4))
    pieces[:, 0] = value
    return start, pieces, np.diff(value) / np.diff(start)
