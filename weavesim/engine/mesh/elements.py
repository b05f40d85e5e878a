"""Constants of the elements of a sheet, with padding; elements that are not there are as padding."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...sheet.geometry import ElementGeometry
from ..layout import BLOCK

# Gradients of a unit square.
_UNIT_SQUARE = np.array([-0.5, -0.5, 0.5, -0.5])


class ElementTables(NamedTuple):
    """Tables of the elements.

    Attributes:
        nodes: corner nodes of the whole mesh, (4, padded elements); those of padding are its own.
        corners: the same, but elements that are not there have the corners of padding.
        values: rows of the element struct by its field names, (rows, padded elements).
    """

    nodes: np.ndarray
    corners: np.ndarray
    values: dict[str, np.ndarray]


def rows_padded(values: np.ndarray, length: int) -> np.ndarray:
    """``values`` with zeros up to ``length`` on the last axis."""
    values = np.asarray(values, dtype=np.float64)
    result = np.zeros((*values.shape[:-1], length))
    result[..., : values.shape[-1]] = values
    return result


def inverse(values: np.ndarray, of: np.ndarray | float = 1.0) -> np.ndarray:
    """``of`` over ``values``; 0 where those are 0."""
    values = np.asarray(values, dtype=np.float64)
    return np.divide(of, values, out=np.zeros(values.shape), where=values != 0.0)


def element_tables(
    quads: np.ndarray, geometry: ElementGeometry, density: np.ndarray, kept: np.ndarray, spare_node: int, length: int
) -> ElementTables:
    """Tables of ``length`` elements.

    Args:
        quads: corner nodes of the mesh, (element_count, 4).
        geometry: of its elements.
        density: areal density of each, (element_count,) [kg/m^2].
        kept: which elements are there, (element_count,) bool.
        spare_node: the first of four nodes, a unit square that never moves, which padding uses.
        length: elements with padding.
    """
    count = len(quads)
    nodes = np.empty((4, length), dtype=np.int32)
    nodes[:, :count] = quads.T
    spare = (spare_node + np.arange(4, dtype=np.int32))[:, None]
    nodes[:, count:] = spare
    empty = np.append(~kept, np.ones(length - count, dtype=bool))
    corners = np.where(empty, spare, nodes)
    gradient = rows_padded(geometry.gradient, length)
    gradient[:, empty] = _UNIT_SQUARE[:, None]
    values = {
        "shape_gradient": gradient,
        "hourglass_offset": rows_padded(geometry.hourglass_offset * kept, length),
        "area": rows_padded(geometry.area * kept, length),
        "yarn_inertia": rows_padded(kept * (0.25 * density / geometry.largest_gradient), length),
    }
    for name, strain in (
        ("initial_curvature", geometry.curvature),
        ("initial_transverse_shear", geometry.transverse_shear),
        ("initial_hourglass", geometry.hourglass),
    ):
        # a flat blank never reads them
        values[name] = np.zeros((len(strain), BLOCK)) if geometry.flat else rows_padded(strain * kept, length)
    return ElementTables(nodes, corners, values)
