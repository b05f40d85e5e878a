"""Folds along the rim of a draped sheet."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..sheet.symmetry import WHOLE, Symmetry
from .border import whole_outline

if TYPE_CHECKING:
    from ..sheet.blank import Blank


class RimFolds(NamedTuple):
    """Folds along the rim of a drape: number and height [m]."""

    fold_count: int
    amplitude: float


def rim_folds(
    blank: Blank,
    position: np.ndarray,
    symmetry: Symmetry = WHOLE,
    threshold: float | None = None,
    smooth_radius: np.ndarray | None = None,
) -> RimFolds:
    """Folds of the free border around the z axis, from its distance to that axis.

    The distance is a function of the length along the flat outline, so it stays single-valued when a fold overhangs. A
    fold is a maximum at least ``threshold`` [m] (default 2 % of the mean distance) above the valleys on both sides. The
    amplitude is half the peak-to-peak distance.

    Args:
        smooth_radius: distance of each node from the axis without any fold, (node_count,) [m]; the difference is
            attributed to folds. Without it the Fourier harmonics 0 to 4 along the outline, which contain the shape
            of a smooth drape of a square, are subtracted for the amplitude.
    """
    flat = whole_outline(blank, blank.material_coordinates, symmetry)
    radius = np.hypot(*whole_outline(blank, position, symmetry)[:, :2].T)
    mean = float(radius.mean())
    if smooth_radius is not None:
        column = np.column_stack([np.zeros(blank.node_count), np.zeros(blank.node_count), smooth_radius])
        radius = radius - whole_outline(blank, column, symmetry)[:, 2]
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(flat, axis=0, append=flat[:1]), axis=1))])
    sample_count = max(512, 4 * len(flat))
    even = np.interp(np.arange(sample_count) * length[-1] / sample_count, length, np.concatenate([radius, radius[:1]]))
    wrinkle = even
    if smooth_radius is None:
        spectrum = np.fft.rfft(even)
        spectrum[:5] = 0.0
        wrinkle = np.fft.irfft(spectrum, sample_count)
    height = 0.02 * mean if threshold is None else threshold
    return RimFolds(_count_maxima(even, height), 0.5 * float(np.ptp(wrinkle)))


def _count_maxima(values: np.ndarray, height: float) -> int:
    """Number of maxima of a periodic signal that are ``height`` above the valleys on both sides."""
    values = np.roll(values, -int(np.argmin(values)))
    count, rising, extreme = 0, True, values[0]
    for value in [*values, values[0]]:
        extreme = max(extreme, value) if rising else min(extreme, value)
        if rising and value <= extreme - height:
            count, rising, extreme = count + 1, False, value
        elif not rising and value >= extreme + height:
            rising, extreme = True, value
    return count
