"""Checkerboard patterns of the shear angle, the sign of an hourglass mode."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from ..sheet.blank import Blank


# ----------------------------------------------------------------------------------------------- quality of a sheet


class Checkerboard(NamedTuple):
    """Zig-zag part of the shear angle [degrees], and the node where it is largest (-1 if no block exists)."""

    rms: float
    maximum: float
    node: int


def checkerboard(blank: Blank, shear_angle: np.ndarray) -> Checkerboard:
    """Alternating part of the shear angle in every block of four elements around an interior node.

    It is (g1 - g2 + g3 - g4)/4 with the elements in cyclic order around the node.
    """
    flat = blank.quads.ravel()
    element = np.repeat(np.arange(blank.element_count), 4)
    inner = np.bincount(flat, minlength=blank.node_count) == 4
    edges = np.sort(np.concatenate([blank.quads[:, [i, (i + 1) % 4]] for i in range(4)]), axis=1)
    edges, count = np.unique(edges, axis=0, return_counts=True)
    inner[edges[count == 1]] = False
    if not inner.any():
        return Checkerboard(0.0, 0.0, -1)
    chosen = inner[flat]
    offset = blank.material_coordinates[blank.quads].mean(axis=1)[element] - blank.material_coordinates[flat]
    polar = np.arctan2(offset[:, 1], offset[:, 0])
    order = np.lexsort((polar[chosen], flat[chosen]))
    blocks = shear_angle[element[chosen][order]].reshape(-1, 4)
    part = np.abs(np.rad2deg(blocks @ np.array([1.0, -1.0, 1.0, -1.0]) / 4.0))
    return Checkerboard(
        float(np.sqrt(np.mean(part**2))), float(part.max()), int(np.flatnonzero(inner)[np.argmax(part)])
    )
