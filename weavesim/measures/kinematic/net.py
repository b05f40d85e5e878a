"""A net of inextensible yarns on a surface that is given by its signed distance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...errors import InputError

# (points (k, 3) [m]) -> distance (k,) [m] and outward unit normal (k, 3).
Surface = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
# (points (k, 3) [m]) -> (k,) bool.
Beyond = Callable[[np.ndarray], np.ndarray]

# Over the side of a cell: how near to the surface a node is, unless the surface itself is less exact.
_TOLERANCE = 1.0e-9
_MOST_ITERATIONS = 40
# The circle on which a node lies is looked at from its guess to both sides, in steps up to an end [rad].
_STEP, _LARGEST_TURN = np.radians(7.5), np.radians(120.0)
# Where yarns cross below 20 degrees a net has closed and ends: a diagonal of the cell over its side.
_LEAST_DIAGONAL = 0.35
# More crossings take more memory and time than a net is worth.
MOST_CROSSINGS = 1_000_000
# Why a crossing is not there: it has no neighbours nearer to the seed, its yarns have closed, or there is no surface.
THERE, BEHIND, CLOSED, NO_SURFACE = range(4)


@dataclass(frozen=True, eq=False)
class Net:
    """A net that lies on a surface.

    Attributes:
        side: of its cells [m].
        first: numbers along warp and weft of the node ``position[0, 0]``, counted from the seed.
        position: of its nodes, (rows along the warp, rows along the weft, 3) [m]; NaN where the net does not reach.
        state: of its nodes: ``THERE``, or why it is not, (rows along the warp, rows along the weft).
    """

    side: float
    first: tuple[int, int]
    position: np.ndarray
    state: np.ndarray

    @property
    def shear_angle(self) -> np.ndarray:
        """Of each cell, signed: positive where the yarns cross below a right angle, (rows - 1, rows - 1) [rad]."""
        p = self.position
        warp = p[1:, :-1] + p[1:, 1:] - p[:-1, :-1] - p[:-1, 1:]
        weft = p[:-1, 1:] + p[1:, 1:] - p[:-1, :-1] - p[1:, :-1]
        with np.errstate(invalid="ignore"):
            sine = (warp * weft).sum(axis=2) / (np.linalg.norm(warp, axis=2) * np.linalg.norm(weft, axis=2))
        return np.arcsin(np.clip(sine, -1.0, 1.0))

    def angle_at(self, yarn_lengths: np.ndarray) -> np.ndarray:
        """Shear angle at lengths along warp and weft from the seed, (k, 2) [m]: that of the cell there; else NaN."""
        place = np.floor(yarn_lengths / self.side).astype(int) - np.array(self.first)
        angle = self.shear_angle
        inside = np.all((place >= 0) & (place < angle.shape), axis=1)
        out = np.full(len(place), np.nan)
        out[inside] = angle[tuple(place[inside].T)]
        return out


def check_count(side: float, count: float) -> None:
    """Check that a net of ``count`` crossings can be laid.

    Raises:
        InputError: there are too many; another ``side`` [m] is proposed.
    """
    if not count <= MOST_CROSSINGS:
        least = side * (count / MOST_CROSSINGS) ** 0.5
        advice = f"give at least {least:.2g} m" if np.isfinite(least) else "give a length of some millimetres"
        raise InputError(
            f"kinematic drape: side = {side:.4g} m makes {count:.3g} crossings, more than {MOST_CROSSINGS:,}; {advice}"
        )


def lay_net(
    surface: Surface,
    seed: np.ndarray,
    warp: np.ndarray,
    side: float,
    reach: tuple[tuple[int, int], tuple[int, int]],
    *,
    height: float = 0.0,
    beyond: Beyond | None = None,
    error: float = 0.0,
) -> Net:
    """Lay a net onto a surface.

    From the seed two yarns run along geodesics, at right angles to each other. Every other crossing lies where the
    yarns of its two neighbours nearer to the seed end, on the surface: two spheres and the surface meet there. The two
    spheres meet in a circle, on which the surface is looked for from the place where a flat cell would have its corner.

    Args:
        surface: its signed distance, without jumps.
        seed: where the two yarns cross (3,) [m]; the nearest point of the surface is taken.
        warp: direction of the first yarn (3,).
        side: distance of crossings [m].
        reach: first and last number of the crossings along warp and along weft, first <= 0 <= last.
        height: of the net above the surface [m].
        beyond: where the surface has ended, although it still has a distance.
        error: of the distance [m].

    Raises:
        InputError: the seed is too far from the surface, the warp stands on it, or there are too many crossings.
    """
    (u0, u1), (v0, v1) = reach
    check_count(side, (u1 - u0 + 1) * (v1 - v0 + 1))
    ground = _Ground(surface, beyond, height, max(_TOLERANCE * side, 2.0 * error))
    position = np.full((u1 - u0 + 1, v1 - v0 + 1, 3), np.nan)
    state = np.full(position.shape[:2], BEHIND)
    start = _onto(ground, np.asarray(seed, dtype=float))
    normal = surface(start[None])[1][0]
    along = np.asarray(warp, dtype=float) - (np.dot(warp, normal)) * normal
    if np.linalg.norm(along) < 0.1 * np.linalg.norm(warp):
        raise InputError("kinematic drape: the warp stands on the surface at the seed; give another seed")
    along /= np.linalg.norm(along)
    across = np.cross(normal, along)
    position[-u0, -v0], state[-u0, -v0] = start, THERE
    yarns = np.stack([-along, along, -across, across])
    step = np.array([[-1, 0], [1, 0], [0, -1], [0, 1]])
    _geodesics(ground, position, state, np.array([-u0, -v0]), yarns, step, side)
    _fill(ground, position, state, (-u0, -v0), side)
    return Net(side, (u0, v0), position, state)


@dataclass(frozen=True)
class _Ground:
    """What a net lies on: its surface, the height of the net above it, and how near to that a node has to be [m]."""

    surface: Surface
    beyond: Beyond | None
    height: float
    tolerance: float

    def misses(self, points: np.ndarray) -> np.ndarray:
        """How far points (k, 3) are above the net's place, (k,) [m]."""
        return self.surface(points)[0] - self.height

    def met(self, circle: _Circles) -> np.ndarray:
        """The point of each circle on the surface that is nearest to its guess, (k, 3); NaN if there is none."""
        from scipy.optimize.elementwise import find_root

        lower, upper = self._brackets(circle)
        row = np.flatnonzero(np.isfinite(lower))
        points = np.full((len(circle.centre), 3), np.nan)
        if not len(row):
            return points
        found = find_root(
            lambda turn, rows: self.misses(circle.at(turn, rows)), (lower[row], upper[row]), args=(row,),
            tolerances={"xatol": 1.0e-14, "xrtol": 0.0, "fatol": 1.0e-16}, maxiter=200,
        )  # fmt: skip
        place = circle.at(found.x, row)
        there = np.abs(found.f_x) <= self.tolerance
        if self.beyond is not None:
            there &= ~self.beyond(place)
        points[row[there]] = place[there]
        return points

    def _brackets(self, circle: _Circles) -> tuple[np.ndarray, np.ndarray]:
        """Turns between which each circle passes the surface, the nearest to its guess, (k,) [rad]; NaN without."""
        count = len(circle.centre)
        lower, upper = np.full(count, np.nan), np.full(count, np.nan)
        rows = np.arange(count)
        # of the two ends so far: the turn to one side, and to the other
        ends = np.repeat(self.misses(circle.at(np.zeros(count), rows))[:, None], 2, axis=1)
        for step in range(int(_LARGEST_TURN / _STEP)):
            turn = np.full(len(rows), (step + 1) * _STEP)
            new = np.column_stack([self.misses(circle.at(sign * turn, rows)) for sign in (-1.0, 1.0)])
            passed = np.sign(new) != np.sign(ends)
            # where both sides pass, the one that is steeper does so sooner
            second = passed[:, 1] & (~passed[:, 0] | (np.abs(new - ends)[:, 1] >= np.abs(new - ends)[:, 0]))
            for sign, chosen in ((1.0, second), (-1.0, passed[:, 0] & ~second)):
                low, high = sorted((sign * step * _STEP, sign * (step + 1) * _STEP))
                lower[rows[chosen]], upper[rows[chosen]] = low, high
            left = ~passed.any(axis=1) & np.isfinite(new).all(axis=1)
            rows, ends = rows[left], new[left]
            if not len(rows):
                break
        return lower, upper


@dataclass(frozen=True)
class _Circles:
    """Circles in space: centres and unit axes (k, 3) [m], radii (k,) [m], and two unit vectors (k, 3) in each plane."""

    centre: np.ndarray
    radius: np.ndarray
    first: np.ndarray
    second: np.ndarray

    @classmethod
    def around(cls, centre: np.ndarray, axis: np.ndarray, radius: np.ndarray, guess: np.ndarray) -> _Circles:
        """From their axes; turns are counted from the points nearest to ``guess``."""
        axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
        towards = guess - centre
        towards = towards - np.einsum("ki,ki->k", towards, axis)[:, None] * axis
        first = towards / np.linalg.norm(towards, axis=1, keepdims=True)
        return cls(centre, radius, first, np.cross(axis, first))

    def at(self, turn: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Points (n, 3) [m] of circles at their turns (n,) [rad]."""
        c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
        return self.centre[rows] + self.radius[rows, None] * (c * self.first[rows] + s * self.second[rows])


def _onto(ground: _Ground, point: np.ndarray) -> np.ndarray:
    """The point of the net's surface that is nearest."""
    here = point
    for _ in range(_MOST_ITERATIONS):
        distance, normal = ground.surface(here[None])
        here = here - (distance[0] - ground.height) * normal[0]
        if abs(distance[0] - ground.height) < ground.tolerance:
            return here
    raise InputError(
        f"kinematic drape: no point of the surface is found near the seed, ({', '.join(f'{x:.4g}' for x in point)}) m; "
        "give another seed"
    )


def _geodesics(
    ground: _Ground,
    position: np.ndarray,
    state: np.ndarray,
    origin: np.ndarray,
    direction: np.ndarray,
    step: np.ndarray,
    side: float,
) -> None:
    """Place the nodes of the yarns through the seed, which end where they leave the surface.

    A geodesic turns about the normal nowhere: its next point lies in the plane of its last direction and the normal.

    Args:
        ground: to lie on.
        position, state: of all nodes, to be filled.
        origin: place of the seed among them (2,).
        direction: in which each yarn begins (k, 3).
        step: from node to node along each yarn (k, 2).
        side: distance of nodes [m].
    """
    here = np.tile(position[tuple(origin)], (len(direction), 1))
    place = np.tile(origin, (len(direction), 1))
    while True:
        place = place + step
        inside = np.all((place >= 0) & (place < state.shape), axis=1)
        place, step, here, direction = place[inside], step[inside], here[inside], direction[inside]
        if not len(place):
            return
        beside = np.cross(ground.surface(here)[1], direction)
        guess = here + side * direction
        found = ground.met(_Circles.around(here, beside, np.full(len(here), side), guess))
        on = np.isfinite(found).all(axis=1)
        position[tuple(place.T)], state[tuple(place.T)] = found, np.where(on, THERE, NO_SURFACE)
        direction, here, place, step = (found - here)[on] / side, found[on], place[on], step[on]


def _fill(ground: _Ground, position: np.ndarray, state: np.ndarray, origin: tuple[int, int], side: float) -> None:
    """Place all nodes off the two yarns, those equally far from the seed together."""
    rows, columns = state.shape
    i, j = np.meshgrid(np.arange(rows) - origin[0], np.arange(columns) - origin[1], indexing="ij")
    far, off = np.abs(i) + np.abs(j), (i != 0) & (j != 0)
    for ring in range(2, int(far.max()) + 1):
        a, b = np.nonzero(off & (far == ring))
        nearer_a, nearer_b = a - np.sign(a - origin[0]), b - np.sign(b - origin[1])
        places = (nearer_a, b), (a, nearer_b), (nearer_a, nearer_b)
        known = np.all([state[place] == THERE for place in places], axis=0)
        if not known.any():
            continue
        a, b = a[known], b[known]
        one, two, corner = (position[place][known] for place in places)
        across = np.linalg.norm(one - two, axis=1)
        # equal to the diagonal of a flat cell; zero where the two yarns are one line
        half = np.sqrt(np.maximum(side**2 - 0.25 * across**2, 0.0))
        wide = half > 0.5 * _LEAST_DIAGONAL * side
        narrow = across < _LEAST_DIAGONAL * side
        state[a, b] = CLOSED
        a, b, one, two, corner, half = (x[wide & ~narrow] for x in (a, b, one, two, corner, half))
        if not len(a):
            continue
        found = ground.met(_Circles.around(0.5 * (one + two), one - two, half, one + two - corner))
        closed = np.linalg.norm(found - corner, axis=1) < _LEAST_DIAGONAL * side
        on = np.isfinite(found).all(axis=1)
        position[a, b] = np.where((on & ~closed)[:, None], found, np.nan)
        state[a, b] = np.where(closed, CLOSED, np.where(on, THERE, NO_SURFACE))
