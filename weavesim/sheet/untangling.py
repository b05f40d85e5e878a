"""Move nodes of a plane mesh of quadrilaterals so that poor elements become better ones."""

from __future__ import annotations

import numpy as np

# Rings of elements around poor ones whose nodes are moved too.
RING_COUNT = 2
ROUND_COUNT = 6
# Areas at corners below this share of the mean area are treated as that, however negative they are.
FLOOR = 0.02
# Of the smallest sine, without which no further round is tried.
LEAST_GAIN = 1.0e-3


def corner_sines(node: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Smallest sine of the corner angles of each element (its scaled Jacobian), negative where not convex, (m,)."""
    corner = node[quads]
    out, back = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
    size = np.linalg.norm(out, axis=2) * np.linalg.norm(back, axis=2)
    return ((out[..., 0] * back[..., 1] - out[..., 1] * back[..., 0]) / np.maximum(size, 1e-300)).min(axis=1)


def untangled(node: np.ndarray, quads: np.ndarray, free: np.ndarray, wished: float) -> np.ndarray:
    """Nodes (n, 2) with the ``free`` ones moved around elements below a ``wished`` quality.

    The sum over all corners of (a^2 + b^2) / h(a x b) is made small, with the edges a and b of a corner and
    h(x) = (x + sqrt(x^2 + 4 d^2)) / 2, which lets elements turn over again (Escobar and others 2003, Computer Methods
    in Applied Mechanics and Engineering 192, 2775-2787).

    Args:
        node: (n, 2).
        quads: (m, 4).
        free: which nodes may be moved, (n,) bool.
        wished: smallest sine at the corners.
    """
    for _ in range(ROUND_COUNT):
        quality = corner_sines(node, quads)
        if quality.min() >= wished:
            break
        near = quality < wished
        for _ in range(RING_COUNT):
            touched = np.zeros(len(node), dtype=bool)
            touched[quads[near].ravel()] = True
            near = touched[quads].any(axis=1)
        result = _improved(node, quads[near], np.flatnonzero(touched & free))
        if not corner_sines(result, quads).min() > quality.min() + LEAST_GAIN:
            break
        node = result
    return node


def _improved(node: np.ndarray, quads: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Nodes with the ``moved`` ones where the energy of the elements is least."""
    from scipy.optimize import minimize

    scale = float(np.mean(_areas(node, quads)))
    smallest = float(_areas(node, quads).min()) / scale
    softness = max(FLOOR, FLOOR - smallest)

    def energy(values: np.ndarray) -> tuple[float, np.ndarray]:
        place = node.copy()
        place[moved] = values.reshape(-1, 2)
        total, slope = _energy(place, quads, scale, softness)
        return total, slope[moved].ravel()

    found = minimize(energy, node[moved].ravel(), jac=True, method="L-BFGS-B", options={"maxiter": 200})
    result = node.copy()
    result[moved] = found.x.reshape(-1, 2)
    return result


def _areas(node: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Cross products of the edges at all corners, (m, 4)."""
    corner = node[quads]
    a, b = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _energy(node: np.ndarray, quads: np.ndarray, scale: float, softness: float) -> tuple[float, np.ndarray]:
    """The sum over all corners, and its slope with each node (n, 2)."""
    corner = node[quads]
    a, b = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
    area = (a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]) / scale
    root = np.sqrt(area**2 + 4.0 * softness**2)
    height = 0.5 * (area + root)
    square = (a**2 + b**2).sum(axis=-1) / scale
    value = square / height
    # of height with area: (1 + area / root) / 2 = height / root
    by_area = -value / root / scale
    by_a = 2.0 * a / (scale * height[..., None]) + by_area[..., None] * np.stack([b[..., 1], -b[..., 0]], axis=-1)
    by_b = 2.0 * b / (scale * height[..., None]) + by_area[..., None] * np.stack([-a[..., 1], a[..., 0]], axis=-1)
    slope = np.zeros_like(node)
    np.add.at(slope, np.roll(quads, -1, axis=1), by_a)
    np.add.at(slope, np.roll(quads, 1, axis=1), by_b)
    np.add.at(slope, quads, -by_a - by_b)
    return float(value.sum()), slope
