"""The series for ParaView."""

from __future__ import annotations

from ...run.frame import Frame, Outcome, RunInfo
from ..paraview.series import ParaViewSeries
from ..writer import Writer


class ParaViewWriter(Writer):
    """``paraview/``: every frame with its tools, and the final state in double precision; see
    ``weavesim.output.ParaViewSeries``.
    """

    name = "paraview"
    title = "ParaView series"

    def start(self, info: RunInfo) -> None:
        """Begin the series."""
        self._series = ParaViewSeries(self.folder / "paraview", diagnostics=self.solver_fields)
        self._series.start(info)

    def frame(self, frame: Frame) -> None:
        """Add a frame if one is due."""
        self._series.frame(frame)

    def finish(self, outcome: Outcome) -> None:
        """Write the final state."""
        self._series.finish(outcome)
