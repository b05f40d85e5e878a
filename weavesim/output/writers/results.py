"""The final state, for programs."""

from __future__ import annotations

from ...run.frame import Frame, Outcome, RunInfo
from ..stored.file import FILE_NAME, write_results
from ..writer import Writer


class ResultsWriter(Writer):
    """``results.h5``: the final state with every field, for ``weavesim export`` and other programs."""

    name = "results"
    title = FILE_NAME
    packages = ("h5py",)

    @classmethod
    def load(cls) -> None:
        """Import HDF5."""
        import h5py  # noqa: F401

    def start(self, info: RunInfo) -> None:
        """Remember what the run is."""
        self._info = info
        self._last: Frame | None = None

    def frame(self, frame: Frame) -> None:
        """Remember the last frame."""
        self._last = frame

    def finish(self, outcome: Outcome) -> None:
        """Write it."""
        if self._last is not None:
            write_results(self.folder / FILE_NAME, self._info, self._last, outcome.value)
