"""Tools in the series for ParaView."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...process.motions.paths import Place
from ...tools.shapes import Triangles
from ...tools.tool import Tool
from .files import Grid

# A tool is written again in every frame in which it has moved; finer ones are drawn with as many triangles at most.
MOST_TRIANGLES = 20_000
# Cells along the longest side of a tool into which its vertices are gathered, first.
_FINEST = 400


class ToolFiles:
    """Files of one tool: a new one whenever it has moved.

    Args:
        folder: for the files.
        run_id: of the run.
        file_name: of the tool in the names of files.
        tool: to write.

    Attributes:
        file: name of the last one.
    """

    def __init__(self, folder: Path, run_id: str, file_name: str, tool: Tool) -> None:
        self._folder, self._run_id, self._name = folder, run_id, file_name
        self._vertices, faces = drawn(tool.display_triangles())
        self._tool = tool
        self._grid = Grid(faces)
        self._place: Place | None = None
        self.file = ""

    def write(self, place: Place, stem: str) -> str:
        """Write the tool where it is, if it was not there before; returns the name of its file."""
        if place != self._place:
            self._place, self.file = place, f"{stem}_tool_{self._name}.vtu"
            points = self._tool.moved(self._vertices, place).astype(np.float32)
            self._grid.write(self._folder / self.file, points, run_id=self._run_id)
        return self.file


def drawn(triangles: Triangles) -> Triangles:
    """Triangles to draw: coarser, if they are very many, by gathering their vertices in the cells of a grid."""
    vertices, faces = np.asarray(triangles[0], dtype=float), np.asarray(triangles[1])
    cells = _FINEST
    while len(faces) > MOST_TRIANGLES and cells > 1:
        vertices, faces = gathered(vertices, faces, float(np.ptp(vertices, axis=0).max()) / cells)
        cells //= 2
    return vertices, faces


def gathered(vertices: np.ndarray, faces: np.ndarray, size: float) -> Triangles:
    """Vertices of each cell of a grid as one, at their mean, and the triangles that are left.

    Args:
        vertices: (n, 3) [m].
        faces: (m, 3).
        size: of the cells [m].
    """
    cell = np.floor((vertices - vertices.min(axis=0)) / size).astype(int)
    _, own, count = np.unique(cell, axis=0, return_inverse=True, return_counts=True)
    own = own.ravel()
    means = np.stack([np.bincount(own, vertices[:, axis]) for axis in range(3)], axis=1) / count[:, None]
    corners = own[faces]
    a, b, c = corners.T
    left = corners[(a != b) & (b != c) & (c != a)]
    # of several with the same corners one is enough
    _, first = np.unique(np.sort(left, axis=1), axis=0, return_index=True)
    return means, left[np.sort(first)]
