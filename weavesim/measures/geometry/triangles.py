"""Whether triangles meet: signs of volumes, with a bound of their rounding."""

from __future__ import annotations

import numpy as np

# Share of the product of three edges below which a volume is rounding, and counts as zero.
ROUNDING = 1.0e-13
# Share of their size by which triangles that touch may seem to be apart.
SEPARATION = 1.0e-12


def volume_sign(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Sign of the volume of tetrahedra, (k,): 0 where it is rounding."""
    u, v, w = b - a, c - a, d - a
    value = np.einsum("ki,ki->k", np.cross(u, v), w)
    size = np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1) * np.linalg.norm(w, axis=1)
    return np.where(np.abs(value) <= ROUNDING * size, 0.0, np.sign(value))


def pierces(p: np.ndarray, q: np.ndarray, triangle: np.ndarray, touching: bool) -> np.ndarray:
    """Whether segments p-q (k, 3) go through triangles (k, 3, 3) that are not in one plane with them.

    Args:
        touching: whether it is enough to touch.
    """
    a, b, c = triangle[:, 0], triangle[:, 1], triangle[:, 2]
    below, above = volume_sign(a, b, c, p), volume_sign(a, b, c, q)
    result = below * above < 0.0
    if touching:
        result |= (below * above == 0.0) & (below != above)
    (candidate,) = np.nonzero(result)
    p, q, a, b, c = (array[candidate] for array in (p, q, a, b, c))
    sides = np.stack([volume_sign(p, q, a, b), volume_sign(p, q, b, c), volume_sign(p, q, c, a)])
    through = (sides > 0.0).all(axis=0) | (sides < 0.0).all(axis=0)
    if touching:
        through = (sides >= 0.0).all(axis=0) | (sides <= 0.0).all(axis=0)
    result[candidate] = through
    return result


def meet(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Whether pairs of triangles (k, 3, 3) meet or touch, (k,)."""
    result = np.zeros(len(first), dtype=bool)
    if not len(first):
        return result
    a, b, c = second[:, 0], second[:, 1], second[:, 2]
    side = np.stack([volume_sign(a, b, c, first[:, corner]) for corner in range(3)])
    crossing = ~((side > 0.0).all(axis=0) | (side < 0.0).all(axis=0))
    flat = (side == 0.0).all(axis=0)
    (candidate,) = np.nonzero(crossing & ~flat)
    for these, those in ((first, second), (second, first)):
        for corner in range(3):
            p, q = these[candidate, corner], these[candidate, (corner + 1) % 3]
            result[candidate] |= pierces(p, q, those[candidate], touching=True)
    # of triangles in one plane but for rounding, volumes tell nothing of where in it they are
    (candidate,) = np.nonzero(flat | result)
    if len(candidate):
        result[candidate] = _overlap(first[candidate], second[candidate])
    return result


def _overlap(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Whether no edge of either of pairs of triangles (k, 3, 3) separates them, seen along the normal of the second.

    Those in one plane then overlap or touch; others that are separated do not meet.
    """
    normal = np.cross(second[:, 1] - second[:, 0], second[:, 2] - second[:, 0])
    apart = np.zeros(len(first), dtype=bool)
    for triangle in (first, second):
        for corner in range(3):
            start, edge = triangle[:, corner], triangle[:, (corner + 1) % 3] - triangle[:, corner]
            across = np.cross(normal, edge)
            own, other = (np.einsum("kni,ki->kn", points - start[:, None], across) for points in (first, second))
            margin = SEPARATION * np.maximum(np.abs(own).max(axis=1), np.abs(other).max(axis=1))
            apart |= own.min(axis=1) > other.max(axis=1) + margin
            apart |= other.min(axis=1) > own.max(axis=1) + margin
    return ~apart
