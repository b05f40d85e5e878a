"""The folder of a run: a list of writers, each of which writes its results there."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..names import file_name
from ..run.checkpoint.container import sync_folder
from ..run.frame import Frame, Outcome, RunInfo, SheetInfo
from .claim.lock import FolderLock, check_unlocked
from .claim.record import SETUP_NAME, RunRecord, frame_hash, hashed_fields
from .claim.remains import check_free, check_names, remove_results
from .curves import Curves, LastCurve
from .files import check_writable, noting, plain, write_text
from .history import History
from .loading import LONGEST_WAIT, Loading, check_installed, check_packages
from .results import Results, Wanted, run_summary, sheet_results
from .writer import Failures, Writer, chosen_writers

# Of the log that the command line writes.
LOG_NAME = "run.log"
# Frames that a writer gets late while its libraries are loaded; then they are waited for.
LARGEST_WAITING_COUNT = 64


class ResultFolder:
    """Observer of a run that writes everything to one folder, which it locks.

    Record, set-up, film, series, history and a first summary are written during the run; ``write`` adds the summary,
    tables, pictures and report. What cannot be written, for example on a full disk, is abandoned with a warning, and
    the others and the run continue.

    Attributes:
        path: the folder, absolute; created if necessary. Its contents are not touched before the run starts.
        history: scalars of all frames, and the last frame.
        warnings: what could not be written or computed.
        solver_fields: as given.

    Args:
        path: the folder.
        points, measured_angles, measured_outline, curves, last_curve, draw_in: what the scene wants to show, see
            ``Wanted``.
        writers: names of the writers to use; None uses all known ones.
        overwrite: remove the results of an earlier run from the folder; files that are no results stay.
        options: given by the user, by name, for the record of the run.
        resumes: the run goes on from its checkpoints in the folder; its earlier results are replaced, its log stays.
        solver_fields: whether frames for ParaView have the fields of the solver too.

    Raises:
        InputError: the folder cannot be written to, has results already, is in use by another run; a writer is
            unknown; or there are measured angles but no points.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        points: np.ndarray | None = None,
        measured_angles: tuple[np.ndarray, np.ndarray] | None = None,
        measured_outline: np.ndarray | None = None,
        curves: Curves | None = None,
        last_curve: LastCurve | None = None,
        draw_in: bool = True,
        writers: Sequence[str] | None = None,
        overwrite: bool = False,
        options: Mapping[str, Any] | None = None,
        resumes: bool = False,
        solver_fields: bool = False,
    ) -> None:
        if not str(path).strip():
            raise InputError("output folder: its name is empty; '.' is the current folder")
        self.path = Path(path).absolute()  # wherever the process goes meanwhile
        self.history = History()
        self.warnings = Failures()
        self._wanted = Wanted(points, measured_angles, measured_outline, curves, last_curve, draw_in)
        self._kinds = chosen_writers(writers)
        self._overwrite, self._options = overwrite or resumes, dict(options or {})
        self._resumes, self._cleared = resumes, False
        self.solver_fields = solver_fields
        self._writers: list[Writer] = []
        self._waiting: dict[Writer, list[Callable[[Writer], None]]] = {}
        self._outcome: Outcome | None = None
        self._record: RunRecord | None = None
        check_writable(self.path)
        check_names(self.path)
        self._lock = FolderLock(self.path)
        if not self._overwrite:
            check_unlocked(self.path)
            check_free(self.path)
        check_packages(self._kinds)
        self._loading = Loading([kind.load for kind in self._kinds])

    # ------------------------------------------------------------------------------------------------ before a run

    def claim(self) -> None:
        """Lock the folder for one run; ``start`` does it too.

        Raises:
            InputError: another run writes to it, or it has results that must not be overwritten.
        """
        self._lock.acquire()
        if not self._overwrite and not self._cleared:
            check_free(self.path)

    def clear(self) -> None:
        """Remove old results from a folder that is claimed; ``start`` does it too."""
        self.claim()
        kept = (LOG_NAME,) if self._resumes else ()
        remove_results(self.path, kept=kept, resumes=self._resumes or self._cleared)
        self._cleared = True

    def load_beside(self, what: str, package: str, load: Callable[[], object]) -> None:
        """Have ``load``, which imports a package for something else, called beside the first steps, as writers' own.

        Raises:
            InputError: the package is not installed.
        """
        check_installed(what, [package])
        self._loading.add(load)

    @property
    def writer_names(self) -> tuple[str, ...]:
        """Of the writers that it uses."""
        return tuple(kind.name for kind in self._kinds)

    def release(self) -> None:
        """Give the folder back; ``write`` does it at the end of a run."""
        self._lock.release()

    def check(self, sheets: Sequence[SheetInfo]) -> None:
        """Check that what the scene wants to show can be had from these sheets; ``start`` does it too.

        Raises:
            InputError: a point outside a sheet.
        """
        self._wanted.check(sheets)

    # ------------------------------------------------------------------------------------------------ during a run

    def start(self, info: RunInfo) -> None:
        file_name("name of the run", info.name)
        self._wanted.check(info.sheets)
        self.clear()
        self._info = info
        self._outcome = None
        self.warnings.clear()
        self.history.start(info)
        self._record = RunRecord(self.path, info, self._options)
        self._try("run.json", self._record.write)
        if (setup := info.setup) is not None:
            self._try(SETUP_NAME, lambda: write_text(self.path / SETUP_NAME, setup.to_json() + "\n"))
        for curves in self._wanted.all_curves:
            curves.start(info)
        self._waiting = {}
        self._writers = [kind(self.path, self.warnings, self.history, self.solver_fields) for kind in self._kinds]
        self._inform(lambda writer: writer.start(info))

    def frame(self, frame: Frame) -> None:
        self.history.frame(frame)
        for curves in self._wanted.all_curves:
            if not curves.failed:
                curves.failed = not self._try(f"{curves.name}.csv", partial(curves.frame, frame), "computed")
        self._inform(lambda writer: writer.frame(frame))
        self._loading.begin()  # not before: it would hold up what is done up to the first step

    def finish(self, outcome: Outcome) -> None:
        self._outcome = outcome
        self._wait()
        self._inform(lambda writer: writer.finish(outcome))

    def add(self, path: Path) -> None:
        """Record a file that something else writes to the folder, such as a log."""
        if self._record is not None:
            self._try("run.json", partial(self._record.add, path))

    def _inform(self, message: Callable[[Writer], None]) -> None:
        """Pass ``message`` to every writer, to one whose libraries are still loaded later; one that cannot write is
        abandoned.
        """
        for writer in list(self._writers):
            waiting = self._waiting.setdefault(writer, [])
            waiting.append(message)
            if writer.needs_load and not self._loading.has(type(writer).load):
                if len(waiting) <= LARGEST_WAITING_COUNT:
                    continue
                self._wait()
            while waiting and writer in self._writers:
                self._tell(writer, waiting.pop(0))

    def _tell(self, writer: Writer, message: Callable[[Writer], None]) -> None:
        with noting(self.add):
            told = writer.attempt(writer.title, partial(message, writer))
        if not told:
            self._abandon(writer)

    def _abandon(self, writer: Writer) -> None:
        self._writers.remove(writer)
        with suppress(Exception):
            writer.discard()

    def _wait(self) -> None:
        """Wait for the libraries of all writers; one whose libraries hang is abandoned, since it would hang too."""
        self._loading.wait()
        for writer in [one for one in self._writers if type(one).load == self._loading.hangs]:
            text = f"{writer.title} could not be written and is given up: its libraries are not there after"
            self.warnings.note(writer.title, f"{text} {LONGEST_WAIT:g} s")
            self._abandon(writer)

    def _try(self, what: str, action: Callable[[], object], verb: str = "written") -> bool:
        """Run ``action``; a failure is noted once and costs nothing else."""
        if what in self.warnings.names:
            return False
        try:
            with noting(self.add):
                action()
        except Exception as error:
            self.warnings.add(what, error, verb)
            return False
        return True

    # ------------------------------------------------------------------------------------------------- after a run

    def measure(self, what: str, compute: Callable[[], Mapping[str, Any]]) -> Mapping[str, Any]:
        """Numbers for ``write``; if they cannot be computed, that is noted, and there are none."""
        try:
            return compute()
        except Exception as error:
            self.warnings.add(what, error, "computed")
            return {}

    def write(self, summary: Mapping[str, Any], *, setup: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """Write the results of the run so far: the summary first, and again when all others have been written.

        Args:
            summary: numbers of the run; they take precedence over those computed here with the same name.
            setup: additional information about the run for the report, by name; by default the options.

        Returns:
            The whole summary, as written; its ``missing`` names what could not be.

        Raises:
            InputError: no run was started.
        """
        frame = self.history.last_frame
        if frame is None or self._record is None:
            raise InputError("results: there is no frame to write; run the simulation with this folder as observer")
        self._wait()  # a copy of the process must not be made within an import
        sheets = sheet_results(self._info, self._wanted, frame)
        given = {"run_id": self._info.run_id, **summary}
        failed = partial(self.warnings.add, verb="computed")
        numbers = run_summary(sheets, self._outcome, self.history.frame_count, given, failed)
        shown = self._options if setup is None else setup
        results = Results(
            self._info, self._wanted, self.history, sheets, numbers, shown, self.warnings, self.warnings.names
        )
        with noting(self.add), ExitStack() as meanwhile:
            for writer in self._writers:
                writer.save(writer.title, partial(writer.precede, results))
            begun = [
                writer
                for writer in self._writers
                if writer.attempt(writer.title, partial(writer.begin, results, meanwhile))
            ]
            if self._outcome is not None:
                self._record.hash_so_far()
            for writer in begun:
                writer.attempt(writer.title, partial(writer.write, results))
            if self._outcome is not None:
                self._verify()
            for writer in self._writers:
                writer.attempt(writer.title, partial(writer.conclude, results))
        if self._outcome is not None:
            stopped_by = {"stopped_by": numbers["stopped_by"]} if "stopped_by" in numbers else {}
            ending = partial(
                self._record.finish,
                outcome=self._outcome.value,
                **stopped_by,
                missing=results.whole_summary["missing"],
                final_state=frame_hash(frame),
                final_fields=hashed_fields(frame),
            )
            self._try("run.json", ending)
            self.release()
        return plain(results.whole_summary)

    def sync(self) -> None:
        """Have all results on the disk when this returns: nothing but them is needed any more."""
        for name in ["run.json", *(self._record.names if self._record else ())]:
            with suppress(OSError), open(self.path / name, "rb") as file:
                os.fsync(file.fileno())
        with suppress(OSError):
            sync_folder(self.path)

    def _verify(self) -> None:
        """Note the files that are not there although nobody has said so."""
        assert self._record is not None
        for name in self._record.missing():
            if not {name, Path(name).name} & set(self.warnings.names):
                self.warnings.note(name, f"{name} is missing or empty")
