"""Waves of a surface: how far it deviates from its smoothed self, with amplitude and wavelength."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...sheet.topology import doubled_normals

if TYPE_CHECKING:
    from ...sheet.blank import Blank

# Below this share of the longest wavelength's amplitude the filter passes too little to tell the amplitude.
LEAST_PASSED = 0.05


@dataclass(frozen=True, eq=False)
class Waves:
    """Waves of a sheet, shorter than a given wavelength.

    Attributes:
        deviation: of each node from the smoothed surface, along its normal, or of its height, (node_count,) [m].
        amplitude: of the wave around each element, (element_count,) [m].
        wavelength: of the wave around each element, (element_count,) [m].
    """

    deviation: np.ndarray
    amplitude: np.ndarray
    wavelength: np.ndarray


def waves(blank: Blank, position: np.ndarray, longest: float, height: np.ndarray | None = None) -> Waves:
    """Waves of a formed sheet up to a wavelength.

    The smoothed surface x_s minimises |x - x_s|^2 + l^4 |Laplace x_s|^2 over the flat sheet, 2 pi l = ``longest``: it
    keeps all that varies linearly and, of a sine of wavelength w, the share 1/(1 + (longest/w)^4). The Laplacian is
    asked for at inner nodes only, so that no condition at the border bends the surface. Local means of the squares of
    the deviation and of its gradient give the wave number; the share that the filter has left is then put back into
    the amplitude.

    Args:
        blank: the flat sheet.
        position: formed nodes, (node_count, 3) [m].
        longest: wavelength of which half the amplitude passes [m].
        height: of the nodes above the nearest tool, (node_count,) [m]; given that, its waves are measured, which do
            not contain the shape of the tools.
    """
    from scipy.sparse import diags
    from scipy.sparse.linalg import splu

    stiffness, mass = _laplacian(blank)
    reach = longest / (2.0 * np.pi)
    inner = np.ones(blank.node_count)
    inner[_border(blank.quads)] = 0.0
    penalty = stiffness @ diags(inner / mass) @ stiffness
    smoothing = splu((diags(mass) + reach**4 * penalty).tocsc())
    if height is None:
        smooth = smoothing.solve(mass[:, None] * position)
        deviation = np.einsum("ni,ni->n", position - smooth, _normals(smooth, blank.quads))
    else:
        deviation = height - smoothing.solve(mass * height)

    square = deviation**2
    gradient = np.bincount(
        blank.quads.ravel(), np.repeat(_squared_slope(blank, deviation), 4), blank.node_count
    ) / np.bincount(blank.quads.ravel(), minlength=blank.node_count)
    local = splu((diags(mass) + reach**2 * stiffness).tocsc())
    power, slope = local.solve(mass * square), local.solve(mass * gradient)
    power, slope = (np.maximum(values, 0.0)[blank.quads].mean(axis=1) for values in (power, slope))
    number = np.sqrt(slope / np.maximum(power, 1.0e-300))
    passed = (number * reach) ** 4 / (1.0 + (number * reach) ** 4)
    amplitude = np.sqrt(2.0 * power) / np.maximum(passed, LEAST_PASSED)
    return Waves(deviation, amplitude, 2.0 * np.pi / np.maximum(number, 1.0e-300))


def _laplacian(blank: Blank) -> tuple[Any, np.ndarray]:
    """Stiffness matrix of the Laplacian on the flat sheet, and the lumped areas of its nodes [m^2].

    Linear triangles, both ways to split a quadrilateral with half the weight each.
    """
    from scipy.sparse import coo_matrix

    rows, columns, entries = [], [], []
    mass = np.zeros(blank.node_count)
    for triangle in ((0, 1, 2), (0, 2, 3), (0, 1, 3), (1, 2, 3)):
        nodes = blank.quads[:, triangle]
        corner = blank.node_position[nodes]
        side = np.roll(corner, -1, axis=1) - np.roll(corner, -2, axis=1)  # opposite each corner
        doubled = np.linalg.norm(np.cross(side[:, 0], side[:, 1]), axis=1)
        np.add.at(mass, nodes.ravel(), np.repeat(doubled / 12.0, 3))
        weight = np.einsum("eai,ebi->eab", side, side) / (4.0 * doubled)[:, None, None]
        rows.append(np.repeat(nodes, 3, axis=1).ravel())
        columns.append(np.tile(nodes, (1, 3)).ravel())
        entries.append(weight.ravel())
    shape = (blank.node_count, blank.node_count)
    matrix = coo_matrix((np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns))), shape)
    return matrix.tocsc(), mass


def _border(quads: np.ndarray) -> np.ndarray:
    """Nodes of the sides that belong to one element only."""
    sides = np.sort(np.concatenate([quads[:, [i, (i + 1) % 4]] for i in range(4)]), axis=1)
    unique, count = np.unique(sides, axis=0, return_counts=True)
    return np.unique(unique[count == 1])


def _squared_slope(blank: Blank, values: np.ndarray) -> np.ndarray:
    """Square of the gradient of nodal values over the flat sheet, at the element centres, (element_count,)."""
    corner = blank.node_position[blank.quads]
    nodal = values[blank.quads]
    sides = np.stack([corner[:, 0] - corner[:, 2], corner[:, 1] - corner[:, 3]], axis=1)
    change = np.stack([nodal[:, 0] - nodal[:, 2], nodal[:, 1] - nodal[:, 3]], axis=1)
    metric = np.einsum("eai,ebi->eab", sides, sides)
    return np.einsum("ea,ea->e", change, np.linalg.solve(metric, change[:, :, None])[:, :, 0])


def _normals(position: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Unit normals of the nodes of a surface, (node_count, 3)."""
    normal = doubled_normals(position, quads)
    total = np.stack(
        [np.bincount(quads.ravel(), np.repeat(normal[:, axis], 4), len(position)) for axis in range(3)], axis=1
    )
    return total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1.0e-300)
