"""Observers that show the progress of a run: a progress bar on the terminal, a log in the result folder."""

from __future__ import annotations

import contextlib
import logging
import logging.handlers
import math
import platform
import sys
import textwrap
import time
from collections.abc import Callable
from pathlib import Path
from typing import IO, TYPE_CHECKING, cast

import numpy as np

from .. import __version__
from ..errors import InputError
from ..input_files import shown
from ..measures.fabric_table import summary_of
from ..notebook import NotebookBar, in_notebook
from ..output.folder import LOG_NAME
from ..output.history import tool_copies
from ..output.run_page.values import in_words
from ..process.friction import in_words as friction_in_words
from ..run.frame import Frame, Outcome, RunInfo
from .terminal import SteadyStream

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress, TaskID

# Without a terminal, lines are spread evenly over a run.
LINE_COUNT = 10
# Between two updates in a notebook [s].
NOTEBOOK_INTERVAL = 0.5


def kinetic_ratio(energies: dict[str, float]) -> float | None:
    """Kinetic over internal energy; None while the sheet stores no energy."""
    internal = energies["internal"]
    return energies["kinetic"] / internal if internal > 0.0 else None


def clock_text(seconds: float) -> str:
    """``seconds`` as minutes and seconds, or hours, minutes and seconds."""
    minutes, second = divmod(round(seconds), 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours}:{minute:02d}:{second:02d}" if hours else f"{minute}:{second:02d}"


class ProgressBar:
    """Shows stroke, time left and energies during a run: on a terminal or in a notebook as a bar, else in a few lines.

    Shows the warnings of the run too. Writes to standard error, which keeps standard output free for results.

    Args:
        console: where to show it.
        stays: show warnings until ``close`` is called, not only until ``finish``: results are written after it.
    """

    def __init__(self, console: Console | None = None, *, stays: bool = False) -> None:
        from rich.console import Console

        self._stays = stays

        # rich would end the program at a broken pipe
        self._console = console or Console(file=cast("IO[str]", SteadyStream(sys.stderr)), highlight=False)
        self._progress: Progress | None = None
        self._notebook: NotebookBar | None = None
        self._next_show = 0.0
        self._task: TaskID | None = None
        self._handler: logging.Handler | None = None
        self._name = "weavesim"
        self._duration = 0.0
        self._start = 0.0
        self._begin = 0.0
        self._line_index = -1

    def listen(self) -> None:
        """Show warnings from now on; ``start`` does it too."""
        if self._handler is None:
            self._handler = _Warnings(self._print)
            logging.getLogger("weavesim").addHandler(self._handler)

    def goes_on(self, time: float) -> None:
        """The run is resumed at ``time`` [s]: what it shows again of before takes no time."""
        self._begin = time

    def start(self, info: RunInfo) -> None:
        self.listen()
        self._name = info.name.replace("_", " ")
        self._duration = info.duration
        self._start = time.perf_counter()
        if in_notebook():
            self._notebook = NotebookBar(self._name)
        for warning in info.warnings:
            self._print(f"warning: {warning}")
        if info.parts:
            self._print(info.parts[-1])
        elif info.expected:
            self._print(str(info.expected))
        if self._notebook is not None:
            self._notebook.update(0.0, f"preparing {info.element_count} elements")
        elif self._console.is_terminal:
            from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

            self._progress = Progress(
                TextColumn("{task.description}"),
                BarColumn(),
                TaskProgressColumn(),
                TextColumn("{task.fields[state]}"),
                console=self._console,
                # The run needs the cores: redraw rarely.
                refresh_per_second=2,
            )
            self._task = self._progress.add_task(self._name, total=self._duration, state="preparing")
            self._progress.start()
        else:
            self._print(f"{info.element_count} elements, {info.node_count} nodes")

    def frame(self, frame: Frame) -> None:
        if frame.index == 0 or frame.time <= self._begin:
            # The first steps wait for kernels to compile, which must not count in the estimate of the time left.
            self._start = time.perf_counter()
        if self._progress is not None and self._task is not None:
            self._progress.update(self._task, completed=min(frame.time, self._duration), state=self._state(frame))
            return
        if self._notebook is not None:
            now = time.perf_counter()
            if now >= self._next_show or frame.time >= self._duration:
                self._next_show = now + NOTEBOOK_INTERVAL
                self._notebook.update(min(1.0, frame.time / self._duration), self._state(frame))
            return
        if frame.time < self._begin:
            return
        share = min(1.0, frame.time / self._duration)  # the last step may end beyond it
        line_index = int(LINE_COUNT * share + 1e-6)
        if line_index > self._line_index:
            self._line_index = line_index
            self._print(f"{share:4.0%}  {self._state(frame)}")

    def finish(self, outcome: Outcome) -> None:
        text = f"{outcome.value} after {clock_text(time.perf_counter() - self._start)}"
        if self._progress is not None and self._task is not None:
            self._progress.stop()
            self._progress = None
        self._print(text)
        if not self._stays:
            self.close()

    def close(self) -> None:
        """Show no more warnings."""
        if self._handler is not None:
            logging.getLogger("weavesim").removeHandler(self._handler)
            self._handler = None

    def _print(self, text: str) -> None:
        if self._notebook is not None:
            self._notebook.line(text)
            return
        self._console.print(f"{self._name}: {text}", markup=False, soft_wrap=True)

    def _state(self, frame: Frame) -> str:
        parts = [f"stage {shown(frame.stage)}"] if frame.stage else []
        parts.append(f"stroke {frame.stroke * 1e3:.1f} mm")
        if self._begin < frame.time < self._duration:
            rate = (time.perf_counter() - self._start) / (frame.time - self._begin)
            parts.append(f"{clock_text(rate * (self._duration - frame.time))} left")
        ratio = kinetic_ratio(frame.energies)
        if ratio is not None:
            parts.append(f"kinetic/internal {ratio:.2%}")
        return ", ".join(parts)


def frame_line(frame: Frame, info: RunInfo) -> str:
    """A frame in one line: how far, forces on the whole part along the axes of the tools, largest shear angle, energy.

    Every energy of every frame is in ``history.csv``.
    """
    stage = f"{frame.stage}, " if frame.stage else ""
    parts = [f"frame {frame.index}: {stage}time {frame.time:.6g} s, stroke {1e3 * frame.stroke:.2f} mm"]
    if info.tools:
        tools = zip(info.tool_names, info.tools, frame.tool_reaction, tool_copies(info), strict=True)
        forces = (f"{name} {copies * abs(float(force @ tool.axis)):.4g}" for name, tool, force, copies in tools)
        parts.append(f"{', '.join(forces)} N on the whole part")
    if info.supports:
        forces = (f"{support.name} {np.linalg.norm(force):.4g}"
                  for support, force in zip(info.supports, frame.support_force, strict=False))  # fmt: skip
        if text := ", ".join(forces):
            parts.append(f"{text} N")
    angles = [sheet.fields["shear_angle"] for sheet in frame.sheets if "shear_angle" in sheet.fields]
    if angles:
        parts.append(
            f"shear up to {math.degrees(max(float(np.nanmax(np.abs(angle))) for angle in angles)):.1f} degrees"
        )
    ratio = kinetic_ratio(frame.energies)
    if ratio is not None:
        parts.append(f"kinetic/internal {ratio:.2%}")
    return "; ".join(parts)


class _Warnings(logging.Handler):
    """Prints warnings."""

    def __init__(self, show: Callable[[str], None]) -> None:
        super().__init__(logging.WARNING)
        self._show = show

    def emit(self, record: logging.LogRecord) -> None:
        self._show(f"warning: {shown(record.getMessage())}")


class _OneLine(logging.Formatter):
    """Keeps every message on one line: a name with line breaks in it must not look like several messages."""

    def formatMessage(self, record: logging.LogRecord) -> str:
        record.message = shown(record.message)
        return super().formatMessage(record)


class RunLog:
    """Writes ``run.log``: set-up, frames, warnings and the outcome of a run.

    It collects the log messages of the package from the moment it is created, but writes nothing before the run
    starts, so that bad input leaves an older log intact.

    Args:
        folder: an existing folder.
        stays: log until ``close`` is called, not only until ``finish``: results are written after it.
    """

    def __init__(self, folder: Path, *, stays: bool = False) -> None:
        self._stays = stays
        self._since: float | None = None
        self.path = Path(folder) / LOG_NAME
        self._logger = logging.getLogger("weavesim")
        self._level_before = self._logger.level
        self._logger.setLevel(logging.INFO)
        self._file: _PatientFileHandler | None = None
        self._memory: logging.handlers.MemoryHandler | None = logging.handlers.MemoryHandler(
            capacity=10_000, flushLevel=logging.CRITICAL + 1, flushOnClose=False
        )
        self._logger.addHandler(self._memory)

    @property
    def failed(self) -> bool:
        """Whether the log could not be written to its end."""
        return self._file is not None and self._file.failed

    def goes_on(self, time: float) -> None:
        """The run is resumed at ``time`` [s]: its log is continued, and tells only of new frames."""
        self._since = time

    def start(self, info: RunInfo) -> None:
        self._begin_file(f"run {info.run_id}")
        counts = " or ".join(map(str, info.thread_counts))
        lines = [
            f"weavesim {__version__}, Python {platform.python_version()}, {platform.platform()}",
            f"{info.name}: {info.precision} on {info.device} with "
            f"{counts} thread{'s' * (counts != '1')}, "
            f"duration {info.duration:g} s",
        ]
        for sheet in info.sheets:
            blank, fabric = sheet.blank, sheet.fabric
            if len(info.sheets) > 1:
                lines.append(f"sheet {sheet.name}")
            lines += [
                f"blank: {blank.element_count} elements, {blank.node_count} nodes",
                f"mirrored at: {', '.join(sheet.symmetry.planes) or 'no plane'}",
                f"fabric: {fabric.name}, {fabric.areal_density:g} kg/m^2, thickness {fabric.thickness:g} m",
                f"source of its values: {textwrap.shorten(shown(fabric.source), 300) or 'none given'}",
                f"its provenance: {summary_of(fabric)}",
            ]
        for tool in info.tools:
            shape = textwrap.shorten(in_words(tool.shape, without=("rotation",)), 200)
            motion = textwrap.shorten(in_words(tool.motion), 200)
            lines.append(f"tool {tool.name}: {shape}; {motion}; {friction_in_words(tool.friction)}")
        lines += info.notes
        lines += [f"warning: {warning}" for warning in info.warnings]
        for line in lines:
            self._logger.info("%s", line)
        self._info = info
        self._start = time.perf_counter()

    def frame(self, frame: Frame) -> None:
        if self._since is not None and frame.time <= self._since:
            return
        self._logger.info("%s", frame_line(frame, self._info))

    def finish(self, outcome: Outcome) -> None:
        self._logger.info("%s after %.2f s", outcome.value, time.perf_counter() - self._start)
        if not self._stays:
            self.close()

    def close(self) -> None:
        """Stop logging; unless the log stays, ``finish`` calls it, and only a run that never started needs it."""
        for handler in (self._memory, self._file):
            if handler is not None:
                self._logger.removeHandler(handler)
                with contextlib.suppress(OSError):
                    handler.close()
        self._memory = self._file = None
        self._logger.setLevel(self._level_before)

    def _begin_file(self, first: str) -> None:
        try:
            mode = "w" if self._since is None else "a"
            self._file = _PatientFileHandler(self.path, mode=mode, encoding="utf-8")
        except OSError as error:
            raise InputError(f"{self.path} cannot be written: {error.strerror}. Choose another folder.") from error
        self._file.setFormatter(_OneLine("%(asctime)s %(levelname)-7s %(message)s"))
        self._file.handle(self._logger.makeRecord(self._logger.name, logging.INFO, "", 0, first, (), None))
        self._logger.addHandler(self._file)
        if self._memory is not None:
            self._logger.removeHandler(self._memory)
            self._memory.setTarget(self._file)
            self._memory.flush()
            self._memory.close()
            self._memory = None


class _PatientFileHandler(logging.FileHandler):
    """Abandons its file, but not the run, when the disk is full."""

    failed = False

    def emit(self, record: logging.LogRecord) -> None:
        if not self.failed:
            super().emit(record)

    def handleError(self, record: logging.LogRecord) -> None:
        if self.failed:
            return
        self.failed = True
        logger = logging.getLogger("weavesim")
        logger.removeHandler(self)
        logger.warning("%s can no longer be written; the run continues without it.", self.baseFilename)
