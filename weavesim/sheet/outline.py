"""Closed polygons: what lies inside them, and how far a point is from them."""

from __future__ import annotations

import numpy as np

from ..errors import InputError

# A vertex where the outline turns by more than this becomes a node; others are treated as parts of a curve [rad].
CORNER_TURN = np.deg2rad(15.0)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Of vectors in a plane, (..., 2)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def checked_outline(outline: np.ndarray) -> np.ndarray:
    """The corners counter-clockwise, (k, 2).

    Raises:
        InputError: no polygon, or one that crosses itself.
    """
    try:
        outline = np.asarray(outline, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError("the outline is no array of numbers; (k, 2) coordinates are needed") from None
    if outline.ndim != 2 or outline.shape[1:] != (2,) or len(outline) < 3 or not np.isfinite(outline).all():
        raise InputError(f"outline of shape {outline.shape}; (k, 2) finite coordinates, k > 2, are needed")
    side = np.roll(outline, -1, axis=0) - outline
    if np.any(np.linalg.norm(side, axis=1) < 1e-9 * np.ptp(outline, axis=0).max()):
        raise InputError("two corners of the outline coincide; give each once, the last one too")
    # sides i and j cross if the ends of each lie on different sides of the other
    start, end = outline, np.roll(outline, -1, axis=0)
    across = np.sign(cross(side[:, None], start[None] - start[:, None])) * np.sign(
        cross(side[:, None], end[None] - start[:, None])
    )
    if np.any((across < 0.0) & (across.T < 0.0)):
        i, j = np.argwhere((across < 0.0) & (across.T < 0.0))[0]
        raise InputError(f"sides {i} and {j} of the outline cross; order the corners around it")
    return outline if cross(start, end).sum() > 0.0 else outline[::-1]


class Outline:
    """A closed polygon, counter-clockwise, with its arc length."""

    def __init__(self, vertex: np.ndarray) -> None:
        self.vertex = vertex
        self.side = np.roll(vertex, -1, axis=0) - vertex
        self.side_length = np.linalg.norm(self.side, axis=1)
        self.start = np.concatenate([[0.0], np.cumsum(self.side_length)])
        before = np.roll(self.side, 1, axis=0)
        self.turn = np.arctan2(cross(before, self.side), np.einsum("ij,ij->i", before, self.side))
        self.corner = np.flatnonzero(np.abs(self.turn) > CORNER_TURN)

    @property
    def length(self) -> float:
        """Of the whole polygon [m]."""
        return float(self.start[-1])

    def nearest(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Signed distance of points (n, 2), positive inside, and the arc length of the nearest point of the outline."""
        from_start = point[:, None] - self.vertex
        share = np.clip((from_start * self.side).sum(axis=2) / np.square(self.side_length), 0.0, 1.0)
        distance = np.linalg.norm(from_start - share[..., None] * self.side, axis=2)
        side = distance.argmin(axis=1)
        row = np.arange(len(point))
        # crossings of a ray in the x direction
        y, low, high = point[:, 1:], self.vertex[:, 1], np.roll(self.vertex[:, 1], -1)
        with np.errstate(divide="ignore", invalid="ignore"):
            crossing = self.vertex[:, 0] + (y - low) / (high - low) * self.side[:, 0]
        inside = (((low > y) != (high > y)) & (point[:, :1] < crossing)).sum(axis=1) % 2 == 1
        return (
            np.where(inside, 1.0, -1.0) * distance[row, side],
            self.start[side] + share[row, side] * self.side_length[side],
        )

    def point(self, arc: np.ndarray) -> np.ndarray:
        """Points at arc lengths, (n, 2)."""
        arc = np.mod(arc, self.length)
        side = np.clip(np.searchsorted(self.start, arc, side="right") - 1, 0, len(self.vertex) - 1)
        return self.vertex[side] + ((arc - self.start[side]) / self.side_length[side])[:, None] * self.side[side]


class Region:
    """What lies inside the first of several outlines and outside the others, which are clockwise."""

    def __init__(self, borders: list[Outline]) -> None:
        self.borders = borders

    @property
    def has_hollows(self) -> bool:
        """Whether a corner points inwards, or there are holes."""
        return len(self.borders) > 1 or any(border.turn.min() < -CORNER_TURN for border in self.borders)

    def distance(self, point: np.ndarray) -> np.ndarray:
        """Signed distance of points (n, 2) from the outlines, positive inside, (n,)."""
        found = self.borders[0].nearest(point)[0]
        for hole in self.borders[1:]:
            found = np.minimum(found, -hole.nearest(point)[0])
        return found
