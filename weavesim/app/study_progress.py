"""Progress of a study as a whole: runs that are done, and the time left."""

from __future__ import annotations

import sys
import time
from typing import IO, TYPE_CHECKING, cast

from ..input_files import shown
from .progress import clock_text
from .terminal import SteadyStream

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, TaskID

# Without a terminal: one line for so many parts of the study.
LINE_COUNT = 20


class StudyProgress:
    """Shows how many runs of how many are done, and the time left; without a terminal, occasional plain lines.

    Writes to standard error.

    Args:
        name: of the study.
        console: where to show it.
    """

    def __init__(self, name: str, console: Console | None = None) -> None:
        from rich.console import Console

        self._console = console or Console(file=cast("IO[str]", SteadyStream(sys.stderr)), highlight=False)
        self._name = name
        self._total = self._done = self._bad = self._known = 0
        self._width = 1
        self._computed, self._seconds, self._started = 0, 0.0, 0.0
        self._line = 0
        self._progress: Progress | None = None
        self._task: TaskID | None = None

    def planned(self, total: int, width: int) -> None:
        """See ``study.conduct.Progress``."""
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

        self._total, self._width, self._started = total, width, time.perf_counter()
        self.said(f"{total} runs, {width} at a time")
        if self._console.is_terminal:
            self._progress = Progress(
                TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[state]}"),
                console=self._console, refresh_per_second=2,
            )  # fmt: skip
            self._task = self._progress.add_task(self._name, total=total, state="")
            self._progress.start()

    def known(self, count: int) -> None:
        """See ``study.conduct.Progress``."""
        self._done += count
        self._known += count
        self._show()

    def ended(self, status: str, seconds: float) -> None:
        """See ``study.conduct.Progress``."""
        self._done += 1
        self._bad += status != "finished"
        if seconds:
            self._computed += 1
            self._seconds += seconds
        self._show()

    def said(self, text: str) -> None:
        """See ``study.conduct.Progress``."""
        self._console.print(f"{self._name}: {shown(text)}", markup=False, soft_wrap=True)

    def time_left(self) -> float | None:
        """Of the whole study [s]; None before the first run has ended."""
        if not self._computed:
            return None
        # runs at a time as they were so far: the last ones of a batch may have waited for each other
        at_a_time = max(min(self._seconds / max(time.perf_counter() - self._started, 1e-9), self._width), 0.5)
        return max(self._total - self._done, 0) * self._seconds / self._computed / at_a_time

    def _show(self) -> None:
        left = self.time_left()
        parts = [f"{self._known} known"] if self._known else []
        parts += [f"{self._bad} did not finish"] if self._bad else []
        parts += [f"{clock_text(left)} left"] if left is not None and self._done < self._total else []
        state = ", ".join(parts)
        if self._progress is not None and self._task is not None:
            self._progress.update(self._task, completed=self._done, state=state)
            return
        line = LINE_COUNT * self._done // max(self._total, 1)
        if line > self._line:
            self._line = line
            self.said(f"{self._done} of {self._total} runs" + (f", {state}" if state else ""))

    def close(self) -> None:
        """End the bar."""
        if self._progress is not None:
            self._progress.stop()
            self._progress = None
