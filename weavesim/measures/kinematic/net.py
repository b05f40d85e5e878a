"""A net of inextensible yarns on a surface that is given by its signed distance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...errors import InputError

# (points (k, 3) [m]) -> distance (k,) [m] and outward unit normal (k, 3).
Surface = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]

_MOST_ITERATIONS = 40
# Of the side of a cell: when a node is in its place, and how far one step may go.
_TOLERANCE, _LARGEST_STEP = 1.0e-7, 0.5
# Where yarns cross below 20 degrees a net has closed and ends: a diagonal of the cell over its side.
_LEAST_DIAGONAL = 0.35


@dataclass(frozen=True, eq=False)
class Net:
    """A net that lies on a surface.

    Attributes:
        side: of its cells [m].
        first: numbers along warp and weft of the node ``position[0, 0]``, counted from the seed.
        position: of its nodes, (rows along the warp, rows along the weft, 3) [m]; NaN where the net does not reach.
    """

    side: float
    first: tuple[int, int]
    position: np.ndarray

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


def lay_net(
    surface: Surface,
    seed: np.ndarray,
    warp: np.ndarray,
    side: float,
    reach: tuple[tuple[int, int], tuple[int, int]],
    *,
    height: float = 0.0,
) -> Net:
    """Lay a net onto a surface.

    From the seed two yarns run along geodesics, at right angles to each other. Every other crossing lies where the
    yarns of its two neighbours nearer to the seed end, on the surface: two spheres and the surface meet there.

    Args:
        surface: its signed distance.
        seed: where the two yarns cross (3,) [m]; the nearest point of the surface is taken.
        warp: direction of the first yarn (3,).
        side: distance of crossings [m].
        reach: first and last number of the crossings along warp and along weft, first <= 0 <= last.
        height: of the net above the surface [m].

    Raises:
        InputError: the seed is too far from the surface, or the warp stands on it.
    """
    (u0, u1), (v0, v1) = reach
    position = np.full((u1 - u0 + 1, v1 - v0 + 1, 3), np.nan)
    start = _onto(surface, np.asarray(seed, dtype=float), height, side)
    normal = surface(start[None])[1][0]
    along = np.asarray(warp, dtype=float) - (np.dot(warp, normal)) * normal
    if np.linalg.norm(along) < 0.1 * np.linalg.norm(warp):
        raise InputError("kinematic drape: the warp stands on the surface at the seed; give another seed")
    along /= np.linalg.norm(along)
    position[-u0, -v0] = start
    for direction, axis, ends in ((along, 0, (u0, u1)), (np.cross(normal, along), 1, (v0, v1))):
        for sign, count in ((-1, -ends[0]), (1, ends[1])):
            yarn = _geodesic(surface, start, sign * direction, side, count, height)
            for k, point in enumerate(yarn, start=1):
                place = [-u0, -v0]
                place[axis] += sign * k
                position[tuple(place)] = point
    _fill(surface, position, (-u0, -v0), side, height)
    return Net(side, (u0, v0), position)


def _onto(surface: Surface, point: np.ndarray, height: float, side: float) -> np.ndarray:
    """The point at ``height`` above the surface that is nearest."""
    for _ in range(_MOST_ITERATIONS):
        distance, normal = surface(point[None])
        point = point - (distance[0] - height) * normal[0]
        if abs(distance[0] - height) < _TOLERANCE * side:
            return point
    raise InputError(f"kinematic drape: no point of the surface is found near the seed {point.tolist()}")


def _geodesic(
    surface: Surface, start: np.ndarray, direction: np.ndarray, side: float, count: int, height: float
) -> list[np.ndarray]:
    """Points along a geodesic at distances ``side``; fewer than ``count`` where it leaves the surface."""
    points: list[np.ndarray] = []
    here = start
    for _ in range(count):
        normal = surface(here[None])[1][0]
        beside = np.cross(normal, direction)
        found = _meet(
            surface,
            here[None],
            here + side * direction[None],
            side,
            height,
            beside=beside[None] / np.linalg.norm(beside),
        )[0]
        if not np.isfinite(found).all():
            break
        direction, here = (found - here) / side, found
        points.append(found)
    return points


def _fill(surface: Surface, position: np.ndarray, origin: tuple[int, int], side: float, height: float) -> None:
    """Place all nodes off the two yarns, those equally far from the seed together."""
    rows, columns = position.shape[:2]
    i, j = np.meshgrid(np.arange(rows) - origin[0], np.arange(columns) - origin[1], indexing="ij")
    far, off = np.abs(i) + np.abs(j), (i != 0) & (j != 0)
    for ring in range(2, int(far.max()) + 1):
        a, b = np.nonzero(off & (far == ring))
        nearer_a, nearer_b = a - np.sign(a - origin[0]), b - np.sign(b - origin[1])
        one, two, corner = position[nearer_a, b], position[a, nearer_b], position[nearer_a, nearer_b]
        known = np.isfinite(one).all(axis=1) & np.isfinite(two).all(axis=1) & np.isfinite(corner).all(axis=1)
        if not known.any():
            continue
        one, two, corner = one[known], two[known], corner[known]
        found = _meet(surface, one, one + two - corner, side, height, other=two)
        across = np.linalg.norm(one - two, axis=1)
        closed = np.fmin(np.linalg.norm(found - corner, axis=1), across) < _LEAST_DIAGONAL * side
        found[closed] = np.nan
        position[a[known], b[known]] = found


def _meet(
    surface: Surface,
    one: np.ndarray,
    guess: np.ndarray,
    side: float,
    height: float,
    *,
    other: np.ndarray | None = None,
    beside: np.ndarray | None = None,
) -> np.ndarray:
    """Points at ``side`` from ``one``, and from ``other`` or in the plane across ``beside``, on the surface; else NaN.

    Newton's method for all points at once, (k, 3).
    """
    x = guess.copy()
    open_rows, result = np.arange(len(x)), np.full_like(x, np.nan)
    for _ in range(_MOST_ITERATIONS):
        here, start = x[open_rows], one[open_rows]
        distance, normal = surface(here)
        first = here - start
        miss = np.empty((len(here), 3))
        slope = np.empty((len(here), 3, 3))
        miss[:, 0], slope[:, 0] = 0.5 * ((first**2).sum(axis=1) - side**2) / side, first / side
        if other is not None:
            second = here - other[open_rows]
            miss[:, 1], slope[:, 1] = 0.5 * ((second**2).sum(axis=1) - side**2) / side, second / side
        elif beside is not None:
            miss[:, 1], slope[:, 1] = (first * beside[open_rows]).sum(axis=1), beside[open_rows]
        miss[:, 2], slope[:, 2] = distance - height, normal
        done = np.abs(miss).max(axis=1) < _TOLERANCE * side
        result[open_rows[done]] = here[done]
        regular = ~done & (np.abs(np.linalg.det(slope)) > 1.0e-6) & np.isfinite(miss).all(axis=1)
        open_rows = open_rows[regular]
        if not len(open_rows):
            break
        step = np.linalg.solve(slope[regular], miss[regular][:, :, None])[:, :, 0]
        size = np.linalg.norm(step, axis=1, keepdims=True)
        x[open_rows] = here[regular] - step * np.minimum(1.0, _LARGEST_STEP * side / np.maximum(size, 1.0e-300))
    return result
