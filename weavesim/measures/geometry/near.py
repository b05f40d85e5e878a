"""Pairs of bodies that may meet, by spheres around them in a grid."""

from __future__ import annotations

from itertools import product

import numpy as np

from ..proximity import join

# Bodies larger than the median by more than this are compared with all others.
LARGEST_RATIO = 4.0


def near_pairs(
    centre: np.ndarray, corners: np.ndarray, group: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs a < b of bodies whose bounding spheres meet, each once.

    Args:
        centre: (k, 3) [m].
        corners: all points of every body, (k, n, 3) [m].
        group: of every body, (k,): only pairs of different groups are wanted; None for all pairs.
    """

    def meeting(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        if group is not None:
            apart = group[a] != group[b]
            a, b = a[apart], b[apart]
        return _meeting(centre, radius, a, b)

    radius = np.sqrt(np.square(corners - centre[:, None]).sum(axis=2).max(axis=1)) * (1.0 + 1.0e-12)
    usual = LARGEST_RATIO * float(np.median(radius))
    large, small = np.flatnonzero(radius > usual), np.flatnonzero(radius <= usual)
    found = [meeting(np.full(len(centre), body), np.arange(len(centre))) for body in large]
    if len(large):
        found = [np.unique(np.sort(np.concatenate(found), axis=1), axis=0)]

    size = max(2.0 * float(radius[small].max(initial=0.0)), 1.0e-300)
    cell = np.floor((centre[small] - centre.min(axis=0)) / size).astype(np.int64) + 1
    stride = cell.max(axis=0, initial=0) + 3
    key = (cell[:, 0] * stride[1] + cell[:, 1]) * stride[2] + cell[:, 2]
    order = np.argsort(key, kind="stable")
    ranked, own = key[order], small[order]
    for shift in product((-1, 0, 1), repeat=3):
        step = (shift[0] * stride[1] + shift[1]) * stride[2] + shift[2]
        if step < 0:  # the other way round it is found too
            continue
        first, last = (np.searchsorted(ranked, ranked + step, side=side) for side in ("left", "right"))
        if step == 0:
            first = np.arange(1, len(ranked) + 1)
        body, other = join(own, first, last)
        found.append(meeting(body, own[other]))
    pairs = np.concatenate(found)
    return pairs.min(axis=1), pairs.max(axis=1)


def _meeting(centre: np.ndarray, radius: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Those of the pairs (a, b) of different bodies whose spheres meet, (k, 2)."""
    apart = centre[a] - centre[b]
    meet = (np.einsum("ki,ki->k", apart, apart) <= (radius[a] + radius[b]) ** 2) & (a != b)
    return np.column_stack([a[meet], b[meet]])
