"""The surface of a sheet between its nodes, and the places of its elements at which it meets tools."""

from __future__ import annotations

import numpy as np

from .topology import at_corners


def sample_places(side_count: int) -> np.ndarray:
    """Middles of ``side_count`` by ``side_count`` equal parts of an element, from -1 to 1 in both directions.

    Returns:
        (side_count^2, 2); none for zero.
    """
    middles = (2.0 * np.arange(side_count) + 1.0) / max(side_count, 1) - 1.0
    return np.stack(np.meshgrid(middles, middles, indexing="ij"), axis=-1).reshape(-1, 2)


# Samples along a side of an element: at least, and at most, which is enough for a tool of 0.3 elements' radius.
FEWEST_PER_SIDE, MOST_PER_SIDE = 2, 5


def samples_per_side(size: float, radius: float) -> int:
    """How many samples a side of an element needs, so that tools reach no deeper between them than 0.13 of ``radius``.

    No point of n by n parts of a square is further from a middle than size/(sqrt(2) n), which is to be half the radius.

    Args:
        size: of the element [m].
        radius: at which the sheet's middle goes round the sharpest tool [m].
    """
    wanted = np.ceil(np.sqrt(2.0) * size / radius - 1e-9)
    return int(np.clip(wanted, FEWEST_PER_SIDE, MOST_PER_SIDE))


def corner_shares(places: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shares of the corners at places (n, 2) of an element, and their derivatives along both directions, (n, 4)."""
    u, v = np.asarray(places, dtype=np.float64).T
    less_u, more_u, less_v, more_v = 1.0 - u, 1.0 + u, 1.0 - v, 1.0 + v
    share = np.stack([less_u * less_v, more_u * less_v, more_u * more_v, less_u * more_v], axis=1)
    by_u = np.stack([-less_v, less_v, more_v, -more_v], axis=1)
    by_v = np.stack([-less_u, -more_u, more_u, less_u], axis=1)
    return 0.25 * share, 0.25 * by_u, 0.25 * by_v


def at_places(shares: np.ndarray, values: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Vectors of the nodes (node_count, 3) at places of all elements, (k, element_count, 3).

    Args:
        shares: of the corners at the places, (k, 4).
        values: of the nodes.
        quads: (element_count, 4).
    """
    return _shared(shares, at_corners(values, quads.T)).transpose(0, 2, 1)


def _shared(shares: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Sums over the corners, (k, 3, element_count), of shares (k, 4) of what ``at_corners`` returns."""
    total: np.ndarray = shares[:, 0, None, None] * values[:, 0]
    for corner in range(1, 4):
        total += shares[:, corner, None, None] * values[:, corner]
    return total


# Of an interpolated director, as in kernels/stepping/surface_point.py.
SHORTEST_DIRECTOR = 0.1
# The surface moves a little more than the patch does, as it is bent: of the squares, up to directors that differ by 60
# degrees within an element, and for elements that shear or stretch.
SWAY_MARGIN = 1.25
TURNING_MARGIN = 1.25


def sample_motion(corners: np.ndarray, places: np.ndarray) -> tuple[float, float]:
    """Bounds of how corners and directors move the samples of their elements, for the stable step.

    With lumped masses m/4 at the corners, and all samples of an element sharing a stiffness m, the springs reach at
    most the first number by motions of the corners, and the second over the squared radius of the directors' inertia by
    turns of the directors: sums over corners I of 4 |share_I|^2 and 4 |ds/dd_I|^2, with s of ``surface_points``.

    Args:
        corners: of the elements, (n, 4, 3) [m].
        places: of the samples, (sample_count, 2).

    Returns:
        [1], [m^2].
    """
    share, by_u, by_v = corner_shares(places)
    rest = 0.5 * (1.0 - np.square(places))
    along_u, along_v = (np.einsum("sc,nci->nsi", weight, corners) for weight in (by_u, by_v))
    turn = (rest[:, :1] * by_u)[..., None] * along_u[:, :, None] + (rest[:, 1:] * by_v)[..., None] * along_v[:, :, None]
    turning = 4.0 * np.square(turn).sum(axis=(2, 3)).mean(axis=1).max()
    # the mean of the samples of all corners' shares: a quarter each, which no motion exceeds
    sway = 4.0 * share.mean(axis=0).max()
    return SWAY_MARGIN * float(sway), TURNING_MARGIN * float(turning)


class Surfaces:
    """The surface of all elements at the same places: ``surface_points`` of each, to the bit.

    Args:
        places: from -1 to 1 in both directions, (k, 2).
    """

    def __init__(self, places: np.ndarray) -> None:
        self._share, by_u, by_v = corner_shares(places)
        # derivatives are the same at many places, such as all along a line
        unique = [np.unique(each, axis=0, return_inverse=True) for each in (by_u, by_v)]
        # NumPy 2.0 gives the inverse a further dimension
        self._lines = [(lines, of_place.ravel()) for lines, of_place in unique]
        self._rest = 0.5 * (1.0 - np.square(places))

    def __call__(self, x: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Points (k, n, 3) [m] of positions [m] and directors at the corners, (3, 4, n), see ``at_corners``."""
        along_u, along_v = (_dot(_shared(lines, x), _shared(lines, d))[of_place] for lines, of_place in self._lines)
        sagitta = self._rest[:, :1] * along_u
        sagitta += self._rest[:, 1:] * along_v
        director = _shared(self._share, d)
        length = np.maximum(np.sqrt(_dot(director, director)), SHORTEST_DIRECTOR)
        director *= (sagitta / length)[:, None]
        director += _shared(self._share, x)
        return director.transpose(0, 2, 1)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Of vectors (k, 3, n), (k, n)."""
    product = a * b
    return product[:, 0] + product[:, 1] + product[:, 2]


def surface_points(corners: np.ndarray, directors: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points of elements on the surface that their directors describe, and their offsets from the bilinear patch.

    A flat facet over a curved tool is its chord; the surface lies off it by the sagitta, to fourth order in the size of
    the element (docs/theory.md, section 6).

    Args:
        corners: of the elements, (n, 4, 3) [m].
        directors: at the corners, (n, 4, 3).
        places: one of each element, from -1 to 1 in both directions, (n, 2).

    Returns:
        Points (n, 3) and offsets (n, 3) [m].
    """
    share, by_u, by_v = corner_shares(places)

    def at(weight: np.ndarray, values: np.ndarray) -> np.ndarray:
        return np.einsum("nc,nci->ni", weight, values)

    rest = 0.5 * (1.0 - np.square(places))
    sagitta = rest[:, 0] * (at(by_u, corners) * at(by_u, directors)).sum(axis=1)
    sagitta += rest[:, 1] * (at(by_v, corners) * at(by_v, directors)).sum(axis=1)
    director = at(share, directors)
    length = np.maximum(np.linalg.norm(director, axis=1), SHORTEST_DIRECTOR)
    offset = (sagitta / length)[:, None] * director
    return at(share, corners) + offset, offset
