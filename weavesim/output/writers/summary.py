"""All numbers of a run, as JSON."""

from __future__ import annotations

from typing import Any

from ...run.frame import Frame, RunInfo
from ..files import write_summary
from ..pace import Pace
from ..results import Results
from ..writer import Writer


class SummaryWriter(Writer):
    """``summary.json``: all numbers of the run, and what could not be written; during the run, how far it is."""

    name = "summary"
    title = "summary.json"
    rank = 9

    def start(self, info: RunInfo) -> None:
        """Write that the run is going on."""
        self._about: dict[str, Any] = {"run_id": info.run_id, "name": info.name, "outcome": "running"}
        self._about["duration_s"] = info.duration
        self._pace = Pace()
        self.save(self.title, lambda: self._write(self._about))

    def frame(self, frame: Frame) -> None:
        """Write how far it is, from time to time."""
        if self._pace.due():
            so_far = {**self._about, "frame_count": frame.index + 1, "time_s": frame.time}
            self.save(self.title, lambda: self._write(so_far))
            self._pace.done()

    def precede(self, results: Results) -> None:
        """Write all numbers, before the other results."""
        self._write(results.whole_summary)

    def conclude(self, results: Results) -> None:
        """Write them again, with what the others could not write."""
        self._write(results.whole_summary)

    def _write(self, numbers: dict[str, Any]) -> None:
        write_summary(self.folder / "summary.json", numbers)
