"""Tools that follow a path and turn: curves of place and angle in time, and the pose that they give."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple, Self

import numpy as np
from pydantic import SerializeAsAny, field_validator, model_validator

from ...checks import Parameters
from ...fabric.curve import limited_slopes
from ...quantities import FiniteVector, Numbers, UnitVector, Vector
from ...ranges import Quantity, argument
from ..strokes import Fixed, Motion, Stroke

# Start of every cubic piece (n,) [s], and c0 to c3 of its polynomial in the time since then (n, 4).
Pieces = tuple[np.ndarray, np.ndarray]
# Rounding of the product of two rotations.
NOT_TURNED = 1.0e-9


class Pose(NamedTuple):
    """Where a tool stands: a point X of it, as drawn, is at rotation X + shift.

    Attributes:
        rotation: matrix, row by row.
        shift: [m].
    """

    rotation: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    shift: Vector = (0.0, 0.0, 0.0)

    @classmethod
    def of(cls, rotation: np.ndarray, shift: np.ndarray) -> Self:
        """From a matrix (3, 3) and a vector (3,) [m]."""
        x, y, z = np.asarray(shift, dtype=float).tolist()
        return cls(tuple(np.asarray(rotation, dtype=float).ravel().tolist()), (x, y, z))

    @property
    def matrix(self) -> np.ndarray:
        """``rotation`` as (3, 3)."""
        return np.array(self.rotation).reshape(3, 3)

    @property
    def numbers(self) -> tuple[float, ...]:
        """The matrix, row by row, and the shift [m]: (12,)."""
        return (*self.rotation, *self.shift)

    @classmethod
    def from_numbers(cls, numbers: np.ndarray | tuple[float, ...]) -> Self:
        """Of ``numbers``."""
        return cls.of(np.array(numbers[:9]), np.array(numbers[9:12]))

    def moved(self, points: np.ndarray) -> np.ndarray:
        """Where points (n, 3) of the tool as drawn are [m]."""
        return points @ self.matrix.T + np.array(self.shift)

    def back(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) in the frame of the tool as drawn [m]."""
        return (points - np.array(self.shift)) @ self.matrix

    def turned(self, vectors: np.ndarray) -> np.ndarray:
        """Directions (n, 3) of the tool as drawn, in space."""
        return vectors @ self.matrix.T


# Where a tool is: its displacement along its axis [m], or the pose of one that is carried.
Place = float | Pose


class Curve(Parameters):
    """Base class of curves in time, cubic and shape-preserving between their knots, constant before and after them.

    Attributes:
        at_rest: whether the curve starts and ends without a jump of its speed; else with the slope of its ends.
    """

    at_rest: bool = True


def _checked(times: Numbers, count: int, what: str, least: int) -> None:
    """Raise ValueError unless there are as many increasing times as values."""
    if len(times) != count or count < least:
        raise ValueError(
            f"it has {len(times)} times and {count} {what}; give the same number of both, at least {least}"
        )
    late = np.flatnonzero(np.diff(times) <= 0.0)
    if len(late):
        k = int(late[0])
        raise ValueError(f"times goes from {times[k]} s to {times[k + 1]} s; times must increase")


def _pieces(times: np.ndarray, values: np.ndarray, at_rest: bool) -> Pieces:
    """Cubic pieces through values (n,) that never leave the band between neighbours; the last one is constant.

    Slopes at inner knots are those of a parabola through the neighbours, limited (Fritsch and Carlson 1980).
    """
    pieces = np.zeros((len(times), 4))
    pieces[:, 0] = values
    if len(times) > 1:
        h = np.diff(times)
        rise = np.diff(values) / h
        ends = (0.0, 0.0) if at_rest else (rise[0], rise[-1])
        inner = (h[1:] * rise[:-1] + h[:-1] * rise[1:]) / (h[:-1] + h[1:])
        slope = limited_slopes(np.concatenate([ends[:1], inner, ends[1:]]), rise)
        pieces[:-1, 1] = slope[:-1]
        pieces[:-1, 2] = (3.0 * rise - 2.0 * slope[:-1] - slope[1:]) / h
        pieces[:-1, 3] = (slope[:-1] + slope[1:] - 2.0 * rise) / h**2
    return times, pieces


def _at(curve: Pieces, time: float, derivative: int = 0) -> float:
    """Value of a curve of pieces at a time [s], or its slope just after it."""
    start, pieces = curve
    k = max(int(np.searchsorted(start, time, side="right")) - 1, 0)
    x = time - start[k]
    if x < 0.0:  # before the first knot
        return float(pieces[0, 0]) if derivative == 0 else 0.0
    return float(np.polynomial.Polynomial(pieces[k]).deriv(derivative)(x))


_NOTHING: Pieces = (np.zeros(1), np.zeros((1, 4)))


class Rotation(Curve):
    """A tool that turns about an axis.

    Attributes:
        axis: direction of the axis; angles count counter-clockwise when it points at the viewer.
        point: of the axis, where the tool stands at first; the tool's path and displacement carry the axis along [m].
        times: increasing [s].
        angles: one per time [degrees]; any number of turns.
    """

    positional = ("axis", "point", "times", "angles")

    axis: UnitVector
    point: Annotated[FiniteVector, Quantity("position")]
    times: Annotated[Numbers, Quantity("time")]
    angles: Annotated[Numbers, Quantity("turn of a tool")]

    @model_validator(mode="after")
    def _is_a_curve(self) -> Self:
        _checked(self.times, len(self.angles), "angles", 1)
        return self

    @classmethod
    def smooth(
        cls, axis: Vector, point: Vector, angle: float, speed: float, ramp_time: float, start_time: float = 0.0
    ) -> Rotation:
        """A constant speed with a smooth start and stop; see ``Stroke.smooth``.

        Args:
            axis, point: as the attributes.
            angle: of the whole turn [degrees]; negative values turn clockwise.
            speed: between the ramps [rad/s], positive.
            ramp_time, start_time: of the start and of the stop, and pause before it [s].
        """
        speed = argument("speed of the rotation", speed, "turning speed")
        radius = 1.0e-3  # any: a stroke of a point at this distance
        knots = Stroke.smooth(math.radians(angle) * radius, speed * radius, ramp_time, start_time)
        angles = tuple(math.degrees(way / radius) for way in knots.displacements)
        return cls(axis, point, knots.times, angles, at_rest=ramp_time > 0.0)

    def curve(self) -> Pieces:
        """Of the angle [rad]."""
        return _pieces(np.array(self.times), np.radians(self.angles), self.at_rest)


class PathMotion(Motion, Curve):
    """A tool that is carried along a path and turned, beside a motion along its axis.

    The path and the turn are prescribed: no force holds them up. They are rigid motions of the tool, its axis keeps its
    direction in space.

    Attributes:
        times: of the path, increasing [s].
        points: one per time: way of the tool from where it is drawn [m].
        rotation: turn of the tool; None for none.
        along: motion along the tool's axis, in addition: a stroke or a force.
        placed: rotation and shift, in twelve numbers, of the tool before all of that, as a stage finds it.
    """

    positional = ("times", "points", "rotation", "along")

    times: Annotated[Numbers, Quantity("time")] = ()
    points: Annotated[tuple[FiniteVector, ...], Quantity("displacement")] = ()
    rotation: Rotation | None = None
    along: SerializeAsAny[Motion] = Fixed()
    placed: Annotated[Numbers, Quantity("position")] = Pose().numbers

    @classmethod
    def of(cls, motion: Motion) -> PathMotion:
        """A motion as one that is carried: with no path and no turn if it has none."""
        return motion if isinstance(motion, PathMotion) else cls(along=motion)

    @field_validator("along")
    @classmethod
    def _is_along_an_axis(cls, value: Motion) -> Motion:
        if isinstance(value, PathMotion) or not value.moves_tools:
            raise ValueError(
                f"{type(value).__name__} is no motion along an axis: take a Stroke, a ForceDriven or Fixed"
            )
        return value

    @field_validator("placed")
    @classmethod
    def _is_a_pose(cls, value: Numbers) -> Numbers:
        turn = np.array(value[:9]).reshape(3, 3) if len(value) == 12 else np.zeros((3, 3))
        if np.abs(turn @ turn.T - np.eye(3)).max() > NOT_TURNED or np.linalg.det(turn) < 0.0:
            raise ValueError("a rotation matrix, row by row, and three components of a shift are needed")
        return value

    @model_validator(mode="after")
    def _is_a_path(self) -> Self:
        _checked(self.times, len(self.points), "points", 0)
        return self

    # ------------------------------------------------------------------------------------------------- along the axis

    @property
    def is_carried(self) -> bool:
        """True."""
        return True

    @property
    def along_axis(self) -> Motion:
        """``along``."""
        return self.along

    @property
    def by_force(self) -> bool:
        """Of ``along``."""
        return self.along.by_force

    @property
    def driven_mass(self) -> float:
        """Of ``along`` [kg]."""
        return self.along.driven_mass

    @property
    def limiting_force(self) -> float:
        """Of ``along`` [N]."""
        return self.along.limiting_force

    @property
    def spacers(self) -> tuple[float, float]:
        """Of ``along``."""
        return self.along.spacers

    def damper(self, stiffness: float) -> tuple[float, float]:
        """Damping where it lands [N s/m] and rate at which that fades [1/s]: those of ``along``."""
        return self.along.damper(stiffness)

    def force_at(self, time: float) -> float:
        """Force that drives it along its axis [N]: that of ``along``."""
        return self.along.force_at(time)

    def curve(self) -> tuple[np.ndarray, np.ndarray]:
        """Times [s] and values [m] or [N] of ``along``, (n,) each."""
        return self.along.curve()

    @property
    def duration(self) -> float:
        """Time after which nothing changes [s]."""
        return max(self.along.duration, self.carrying_time)

    @property
    def travel_time(self) -> float:
        """Time after which path and rotation are over, and a stroke along the axis [s]."""
        return max(self.along.travel_time, self.carrying_time)

    @property
    def carrying_time(self) -> float:
        """Time after which path and rotation are over [s]."""
        of_turn = self.rotation.times[-1] if self.rotation else 0.0
        return max(of_turn, self.times[-1] if self.times else 0.0)

    # -------------------------------------------------------------------------------------------------------- its pose

    @property
    def axis(self) -> Vector:
        """Of the rotation; z where there is none."""
        return self.rotation.axis if self.rotation else (0.0, 0.0, 1.0)

    @property
    def point(self) -> Vector:
        """Of the axis, at zero displacement [m]; where the tool's origin is placed if it does not turn."""
        if self.rotation:
            return self.rotation.point
        x, y, z = self.placed[9:12]
        return (x, y, z)

    def curves(self) -> tuple[Pieces, Pieces, Pieces, Pieces]:
        """x, y and z of the path [m], and the angle [rad]."""
        times, points = np.array(self.times), np.array(self.points)
        x, y, z = (_pieces(times, points[:, c], self.at_rest) if len(times) else _NOTHING for c in range(3))
        return x, y, z, self.rotation.curve() if self.rotation else _NOTHING

    def state_at(self, time: float) -> tuple[np.ndarray, float]:
        """Way along the path (3,) [m], and angle [rad]."""
        *path, turn = self.curves()
        return np.array([_at(each, time) for each in path]), _at(turn, time)

    def rates_at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Velocity along the path [m/s] and spin [rad/s], just after ``time``, (3,) each."""
        *path, turn = self.curves()
        return np.array([_at(each, time, 1) for each in path]), _at(turn, time, 1) * np.array(self.axis)

    def pose_at(self, time: float, along: np.ndarray) -> Pose:
        """Where the tool is, given its displacement ``along`` its axis as a vector (3,) [m]."""
        way, angle = self.state_at(time)
        turn, point = turn_matrix(self.axis, angle), np.array(self.point)
        placed = Pose.from_numbers(self.placed)
        return Pose.of(turn @ placed.matrix, turn @ (np.array(placed.shift) - point) + point + way + along)

    def largest_rates(self, begin: float, end: float) -> tuple[float, float]:
        """Largest speed along the path [m/s] and of the turn [rad/s] between two times."""
        times = np.unique(np.concatenate([np.linspace(begin, end, 257), *(curve[0] for curve in self.curves())]))
        rates = [self.rates_at(time) for time in times[(times >= begin) & (times <= end)]]
        return max(float(np.linalg.norm(v)) for v, _ in rates), max(float(np.linalg.norm(w)) for _, w in rates)


def turn_matrix(axis: Vector, angle: float) -> np.ndarray:
    """Matrix (3, 3) of a rotation by ``angle`` [rad] about ``axis`` (Rodrigues)."""
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn: np.ndarray = np.eye(3) + math.sin(angle) * skew + (1.0 - math.cos(angle)) * (skew @ skew)
    return turn


def place_of(motion: Motion, axis: Vector, displacement: float, time: float) -> Place:
    """Where a tool is that is displaced by ``displacement`` [m] at ``time`` [s]."""
    if isinstance(motion, PathMotion):
        return motion.pose_at(time, displacement * np.array(axis))
    return displacement


def moved_points(points: np.ndarray, axis: Vector, place: Place) -> np.ndarray:
    """Points (n, 3) of a tool as drawn, where the tool is at ``place`` [m]."""
    return place.moved(points) if isinstance(place, Pose) else points + place * np.array(axis)
