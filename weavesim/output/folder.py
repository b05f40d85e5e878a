"""The folder of a run: a list of writers, each of which writes its results there."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..run.frame import Frame, Outcome, RunInfo
from .curves import Curves
from .files import check_writable, plain
from .history import History
from .results import Results, Wanted, run_summary, sheet_results
from .writer import Writer, chosen_writers


class ResultFolder:
    """Observer of a run that writes everything to one folder.

    Film and series are written during the run; ``write`` adds tables, pictures, report and summary. A file that
    cannot be written, for example on a full disk, is abandoned with a warning, and the run continues.

    Attributes:
        path: the folder; created if necessary. Its contents are not touched before the run starts.
        history: scalars of all frames, and the last frame.
        warnings: what could not be written, for the report.

    Args:
        path: the folder.
        points, measured_angles, measured_outline, curves, draw_in: what the scene wants to show, see ``Wanted``.
        writers: names of the writers to use; None uses all known ones.

    Raises:
        InputError: the folder cannot be written to, a writer is unknown, or there are measured angles but no points.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        points: np.ndarray | None = None,
        measured_angles: tuple[np.ndarray, np.ndarray] | None = None,
        measured_outline: np.ndarray | None = None,
        curves: Curves | None = None,
        draw_in: bool = True,
        writers: Sequence[str] | None = None,
    ) -> None:
        self.path = Path(path)
        self.history = History()
        self.warnings: list[str] = []
        self._wanted = Wanted(points, measured_angles, measured_outline, curves, draw_in)
        self._kinds = chosen_writers(writers)
        self._writers: list[Writer] = []
        self._outcome: Outcome | None = None
        check_writable(self.path)
        for kind in self._kinds:
            kind.load()

    # ------------------------------------------------------------------------------------------------ during a run

    def start(self, info: RunInfo) -> None:
        self._wanted.check(info)
        self._info = info
        self._outcome = None
        self.warnings.clear()
        self.history.start(info)
        if self._wanted.curves:
            self._wanted.curves.start(info)
        self._writers = [kind(self.path, self.warnings) for kind in self._kinds]
        self._inform(lambda writer: writer.start(info))

    def frame(self, frame: Frame) -> None:
        self.history.frame(frame)
        if self._wanted.curves:
            self._wanted.curves.frame(frame)
        self._inform(lambda writer: writer.frame(frame))

    def finish(self, outcome: Outcome) -> None:
        self._outcome = outcome
        self._inform(lambda writer: writer.finish(outcome))

    def _inform(self, message: Callable[[Writer], None]) -> None:
        """Pass ``message`` to every writer; one that cannot write is abandoned."""
        for writer in list(self._writers):
            if not writer.attempt(writer.title, partial(message, writer)):
                self._writers.remove(writer)
                with suppress(OSError):
                    writer.discard()

    # ------------------------------------------------------------------------------------------------- after a run

    def write(self, summary: Mapping[str, Any], *, setup: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Write the results of the run so far.

        Args:
            summary: numbers of the run; they take precedence over those computed here with the same name.
            setup: additional information about the run for the report, by name.

        Returns:
            The whole summary, as written.

        Raises:
            InputError: no run was started.
        """
        frame = self.history.last_frame
        if frame is None:
            raise InputError("results: there is no frame to write; run the simulation with this folder as observer")
        sheets = sheet_results(self._info, self._wanted, frame)
        numbers = run_summary(sheets, self._outcome, self.history.frame_count, summary)
        results = Results(self._info, self._wanted, self.history, sheets, numbers, setup or {}, self.warnings)
        for writer in self._writers:
            writer.attempt(writer.title, partial(writer.write, results))
        return plain(results.whole_summary)
