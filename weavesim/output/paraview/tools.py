"""Tools in the series for ParaView."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...process.motions.paths import Place
from ...tools.drawing import coarser
from ...tools.tool import Tool
from .files import Grid

# A tool is written again in every frame in which it has moved; finer ones are drawn with as many triangles at most.
MOST_TRIANGLES = 20_000


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
        self._vertices, faces = coarser(tool.display_triangles(), MOST_TRIANGLES)
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
