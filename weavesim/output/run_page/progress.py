"""A run in progress: ``progress.json``, how far it is, and how often its page is written."""

from __future__ import annotations

import time
from collections import deque
from pathlib import Path
from typing import Any

import numpy as np

from ...run.frame import Frame, Outcome, RunInfo
from ..files import write_summary
from ..history import tool_copies

PROGRESS_NAME = "progress.json"
# Between two writes [s].
INTERVAL = 0.5
# Frames that the time left is estimated from: the first wait for kernels, and those of a resumed run come at once.
_WINDOW = 10


class ProgressRecord:
    """Writes the file at most twice a second, and at the end.

    It holds the run's id, ``state`` ("running", or how the run ended), ``stage`` where a run has stages, the share that
    is done, frame, time, stroke, the force of each tool along its axis on the whole part, kinetic over internal energy,
    and the time left (null at first).

    Args:
        folder: of the run.
        info: about the run.
    """

    def __init__(self, folder: Path, info: RunInfo) -> None:
        self._path, self._info = folder / PROGRESS_NAME, info
        self._copies = tool_copies(info)
        self._seen: deque[tuple[float, float]] = deque(maxlen=_WINDOW)
        self._begun, self._written = time.monotonic(), -np.inf
        self._last: dict[str, Any] = {"share": 0.0, "time_s": 0.0}

    def start(self) -> None:
        """Say that the run has begun."""
        self._write("running")

    def frame(self, frame: Frame) -> None:
        """Say how far it is."""
        now = time.monotonic()
        self._seen.append((now, frame.time))
        internal = frame.energies.get("internal", 0.0)
        self._last = {
            "share": min(frame.time / self._info.duration, 1.0) if self._info.duration > 0.0 else 0.0,
            "frame": frame.index,
            "time_s": frame.time,
            "stroke_mm": 1.0e3 * frame.stroke,
            "tool_force_n": self._forces(frame),
            "kinetic_over_internal": frame.energies.get("kinetic", 0.0) / internal if internal > 0.0 else None,
            "left_s": self._left(),
        }
        if frame.stage:
            self._last["stage"] = frame.stage
        if now >= self._written + INTERVAL:
            self._write("running")

    @property
    def left(self) -> float | None:
        """Wall time left [s], as the last frame has it; None while it is unknown."""
        return self._last.get("left_s")

    def finish(self, outcome: Outcome) -> None:
        """Say how the run ended."""
        self._last["left_s"] = 0.0
        self._write(outcome.value)

    def _forces(self, frame: Frame) -> dict[str, float]:
        """Of each tool along its axis, on the whole part [N]."""
        parts = zip(self._info.tool_names, self._info.tools, frame.tool_reaction, self._copies, strict=True)
        return {
            name.replace("_", " "): copies * abs(float(np.dot(force, tool.axis))) for name, tool, force, copies in parts
        }

    def _left(self) -> float | None:
        """Wall time left at the pace of the last frames [s]."""
        (first, from_time), (last, to_time) = self._seen[0], self._seen[-1]
        if to_time <= from_time:
            return None
        return (last - first) / (to_time - from_time) * max(self._info.duration - to_time, 0.0)

    def _write(self, state: str) -> None:
        self._written = time.monotonic()
        about = {"run_id": self._info.run_id, "name": self._info.name, "state": state}
        content = {**about, **self._last, "duration_s": self._info.duration, "elapsed_s": self._written - self._begun}
        write_summary(self._path, content)


# Ten pages in any run of some length; then so rarely that they take a fiftieth of it.
FIRST_PAGE = 2.0
EARLY_PAGES, EARLY_INTERVAL, EARLY_SHARE = 10, 2.0, 0.05
PAGE_INTERVAL, LARGEST_SHARE = 10.0, 0.02
# A run that ends sooner [s] has its last page by then; for its first one, more is prepared and imported.
LEAST_LEFT, LEAST_LEFT_AT_FIRST = 5.0, 15.0


class PagePace:
    """Says when to write: two seconds after the first frame, then every two seconds but for a twentieth of the time at
    most, and after ten pages every ten seconds but for a fiftieth of it at most; in the last five seconds of a run not
    at all. The first one is not written in its last fifteen seconds either."""

    def __init__(self) -> None:
        self._next: float | None = None
        self._started, self._count = 0.0, 0

    def due(self, left: float | None = None) -> bool:
        """Called for every frame: whether to write now. ``begin`` and ``done`` have to follow.

        Args:
            left: wall time left [s]; None if it is unknown.
        """
        now = time.monotonic()
        if self._next is None:
            self._next = now + FIRST_PAGE
        least = LEAST_LEFT if self._count else LEAST_LEFT_AT_FIRST
        return now >= self._next and (left is None or left >= least)

    def begin(self) -> None:
        """The page is about to be written; what was prepared for all pages does not count."""
        self._started = time.monotonic()

    def done(self) -> None:
        """The page has been written."""
        now = time.monotonic()
        self._count += 1
        interval, share = (EARLY_INTERVAL, EARLY_SHARE) if self._count < EARLY_PAGES else (PAGE_INTERVAL, LARGEST_SHARE)
        self._next = now + max(interval, (now - self._started) / share)
