"""Waves of a surface: how far it deviates from its smoothed self, with amplitude and wavelength."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...sheet.topology import at_corners, node_normals

if TYPE_CHECKING:
    from ...sheet.blank import Blank

# Longer waves are the shape of the part, unless a user says otherwise [m].
LONGEST_WAVELENGTH = 0.1
# The same in frames, where the sheet hangs freely between tools: a wrinkle is shorter than most of that shape [m].
WAVELENGTH_OF_FRAMES = 0.05
# Shortening of a yarn from which a wave is a wrinkle, unless a user says otherwise.
WRINKLE_COMPRESSION = 1.0e-4
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


class WaveFilter:
    """Finds waves up to a wavelength, on any formed states of one flat sheet; its equations are factorised once.

    The smoothed surface x_s minimises |x - x_s|^2 + l^4 |Laplace x_s|^2 over the flat sheet, 2 pi l = ``longest``: it
    keeps all that varies linearly and, of a sine of wavelength w, the share 1/(1 + (longest/w)^4). The Laplacian is
    asked for at inner nodes only, so that no condition at the border bends the surface. Local means of the squares of
    the deviation and of its gradient give the wave number; the share that the filter has left is then put back into
    the amplitude.

    Args:
        blank: the flat sheet.
        longest: wavelength of which half the amplitude passes [m].
    """

    def __init__(self, blank: Blank, longest: float) -> None:
        from scipy.sparse import diags

        stiffness, self._mass = _laplacian(blank)
        self._quads, self._reach = blank.quads, longest / (2.0 * np.pi)
        inner = np.ones(blank.node_count)
        inner[_border(blank.quads)] = 0.0
        penalty = stiffness @ diags(inner / self._mass) @ stiffness
        self._smoothing = _solver(diags(self._mass) + self._reach**4 * penalty)
        self._local = _solver(diags(self._mass) + self._reach**2 * stiffness)
        corner = blank.node_position[blank.quads]
        sides = np.stack([corner[:, 0] - corner[:, 2], corner[:, 1] - corner[:, 3]], axis=1)
        self._metric = np.linalg.inv(np.einsum("eai,ebi->eab", sides, sides))
        yarns = np.stack([blank.warp_direction, blank.weft_direction])
        # derivatives along the yarns, of the changes along the diagonals, (2, 2, element_count)
        self._along = np.einsum("eab,ebi,yei->yae", self._metric, sides, yarns)
        self._around = np.bincount(blank.quads.ravel(), minlength=blank.node_count)

    @staticmethod
    def load() -> None:
        """Import what solves its equations, which takes as long as several frames; otherwise the first one does it."""
        import scipy.sparse.linalg  # noqa: F401

    def of_surface(self, position: np.ndarray) -> np.ndarray:
        """Deviation of the nodes from their smoothed surface, along its normal, (node_count,) [m]."""
        smooth = self._smoothing(self._mass[:, None] * position)
        return np.einsum("ni,ni->n", position - smooth, node_normals(smooth, self._quads))

    def of_height(self, height: np.ndarray) -> np.ndarray:
        """Deviation of a height from the smoothed one, (node_count,) [m]."""
        return height - self._smoothing(self._mass * height)

    def measured(self, deviation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Amplitude and wavelength around each element, (element_count,) [m], of a deviation (node_count,) [m]."""
        change, metric = self._changes(deviation), self._metric
        # square of the gradient over the flat sheet, at the element centres
        slope = metric[:, 0, 0] * change[0] ** 2 + metric[:, 1, 1] * change[1] ** 2
        slope += 2.0 * metric[:, 0, 1] * change[0] * change[1]
        power, slope = self._means(deviation, slope)
        number = np.sqrt(slope / np.maximum(power, 1.0e-300))
        return self._amplitude(power, number), 2.0 * np.pi / np.maximum(number, 1.0e-300)

    def along_yarns(self, deviation: np.ndarray, counted: np.ndarray) -> np.ndarray:
        """Amplitude of what a deviation (node_count,) varies along chosen yarns, (element_count,) [m].

        Its square is the share in that of ``measured`` which the slopes along those yarns have in all slopes: a wave
        with its crests across them counts whole, a bend along its crest not at all.

        Args:
            deviation: (node_count,) [m].
            counted: warp and weft of each element, (2, element_count) bool.
        """
        change = self._changes(deviation)
        slopes = np.square(np.einsum("yae,ae->ye", self._along, change))
        power, slope, own = self._means(deviation, slopes.sum(axis=0), (slopes * counted).sum(axis=0))
        number = np.sqrt(slope / np.maximum(power, 1.0e-300))
        return self._amplitude(power, number) * np.sqrt(own / np.maximum(slope, 1.0e-300))

    def _changes(self, deviation: np.ndarray) -> np.ndarray:
        """Along both diagonals of the elements, (2, element_count)."""
        corner = deviation.take(self._quads.T)
        return corner[:2] - corner[2:]

    def _means(self, deviation: np.ndarray, *squares: np.ndarray) -> np.ndarray:
        """Local means of the square of a deviation, and of squares of slopes (element_count,), of each element."""
        corners = self._quads.ravel()
        nodal = [np.bincount(corners, np.repeat(each, 4), len(deviation)) / self._around for each in squares]
        means = self._local(self._mass[:, None] * np.stack([deviation**2, *nodal], axis=1))
        a, b, c, d = at_corners(np.maximum(means, 0.0), self._quads.T).swapaxes(0, 1)
        return (a + b + c + d) / 4.0

    def _amplitude(self, power: np.ndarray, number: np.ndarray) -> np.ndarray:
        fourth = np.square(np.square(number * self._reach))
        return np.sqrt(2.0 * power) / np.maximum(fourth / (1.0 + fourth), LEAST_PASSED)


def waves(blank: Blank, position: np.ndarray, longest: float, height: np.ndarray | None = None) -> Waves:
    """Waves of a formed sheet up to a wavelength, by ``WaveFilter``.

    Args:
        blank: the flat sheet.
        position: formed nodes, (node_count, 3) [m].
        longest: wavelength of which half the amplitude passes [m].
        height: of the nodes above the nearest tool, (node_count,) [m]; given that, its waves are measured, which do
            not contain the shape of the tools.
    """
    found = WaveFilter(blank, longest)
    deviation = found.of_surface(position) if height is None else found.of_height(height)
    return Waves(deviation, *found.measured(deviation))


def _solver(matrix: Any) -> Callable[[np.ndarray], np.ndarray]:
    """Solves with a symmetric, positive matrix."""
    from scipy.sparse.linalg import splu

    # no pivots, ordered as symmetric: half the entries of the default, and a third of the time
    symmetric = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    solve: Callable[[np.ndarray], np.ndarray] = splu(matrix.tocsc(), **symmetric).solve
    return solve


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
