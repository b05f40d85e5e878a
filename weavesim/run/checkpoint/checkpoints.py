"""The folder with the checkpoints of a run: written while it runs, found when it is resumed, gone when it is done."""

from __future__ import annotations

import logging
import re
import time
from collections.abc import Iterator
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ...engine.setup import hash_of_run
from ...errors import InputError
from ..frame import Frame
from .container import PARTIAL, Content, DamageError, read_container, sync_folder, write_container
from .job import Job
from .journal import FrameJournal
from .machine import differences, machine
from .memory import memory_of, recall
from .pace import INTERVAL, LARGEST_SHARE

if TYPE_CHECKING:
    from ..simulation import Simulation

logger = logging.getLogger(__name__)

FOLDER_NAME = "checkpoint"
JOB_NAME, FRAMES_NAME = "job.bin", "frames.bin"
_NUMBERED = re.compile(r"\d{6}\.bin")
# Of the last checkpoints: one more than the last, should the disk damage that.
KEPT_COUNT = 2
# Frames wait in memory for the next checkpoint, which alone leads to them, up to this size [bytes].
LARGEST_WAITING = 2**26
# Those that have no room on the disk are kept up to this size, and tried again.
LARGEST_BACKLOG = 2**28
# A run that ends so soon after its last checkpoint, as a share of the interval, writes none at its end.
SHORT_SHARE = 0.1


class Found(NamedTuple):
    """A checkpoint that a run can go on from.

    Attributes:
        path: its file.
        content: of the file.
    """

    path: Path
    content: Content


class Checkpoints:
    """Checkpoints of one run.

    A checkpoint appears whole or not at all, and the one before it stays. One that cannot be written is told, and tried
    again at the next time: the run goes on.

    Args:
        folder: of the results of the run; the checkpoints get a folder in it.
        interval: wall time between two of them [s].
        job: of the run; by default its set-up alone.

    Attributes:
        found: what ``find`` found.
    """

    def __init__(self, folder: str | Path, interval: float = INTERVAL, job: Job | None = None) -> None:
        self.folder = Path(folder).absolute() / FOLDER_NAME
        self.interval, self.job = interval, job
        self.found: Found | None = None
        self._journal = FrameJournal(self.folder / FRAMES_NAME)
        self._backlog: list[Frame] = []
        self._waiting = self._number = 0
        self._setup_hash = ""
        self._tried_at = 0
        self._next = time.monotonic() + interval
        self._last_time = time.monotonic()
        self._last = "there is none yet"
        self._said = self._given_up = False

    # ------------------------------------------------------------------------------------------------ while it runs

    def begin(self, job: Job) -> None:
        """Keep a job whose run begins; a failure is only told, since the run needs no checkpoints."""
        self.job = job
        self._given_up = False
        self._given_up = not self._try(lambda: self._prepare(job), "none will be written")
        self._last_time = time.monotonic()
        self._next = self._last_time + self.interval

    def _prepare(self, job: Job) -> None:
        if not self._keeps(job):
            remove_checkpoints(self.folder.parent)
            self.folder.mkdir(exist_ok=True)
            job.write(self.folder / JOB_NAME)
            sync_folder(self.folder.parent)
        self._backlog.clear()
        self._journal.begin()

    def _keeps(self, job: Job) -> bool:
        """Whether the job is there already: it then stays, so that no moment is without it."""
        try:
            return read_container(self.folder / JOB_NAME).values.get("run_id") == job.run_id
        except (OSError, DamageError):
            return False

    def add(self, frame: Frame) -> None:
        """Keep a frame that the run has taken."""
        if not self._given_up:
            self._backlog.append(frame)
            self._waiting += 10 * sum(sheet.position.nbytes for sheet in frame.sheets)
            if self._waiting > LARGEST_WAITING:
                self._try(self._catch_up, "it is tried again")

    def _catch_up(self) -> None:
        self._waiting = 0
        while self._backlog:
            try:
                self._journal.append(self._backlog[0])
            except OSError:
                size = sum(sheet.position.nbytes for frame in self._backlog for sheet in frame.sheets)
                if 10 * size > LARGEST_BACKLOG or not self.folder.is_dir():
                    self._given_up = True
                    self._backlog.clear()
                raise
            del self._backlog[0]

    def due(self, step_count: int) -> bool:
        """Whether it is time for the next one, after so many steps of the run."""
        return not self._given_up and step_count > self._tried_at and time.monotonic() >= self._next

    def save(self, simulation: Simulation) -> bool:
        """Write a checkpoint of a run between two steps; returns whether it is on the disk."""
        if self._given_up:
            return False
        started, self._tried_at = time.monotonic(), simulation.state.step_count
        done = self._try(lambda: self._write(simulation), "it is tried again")
        now = time.monotonic()
        self._last_time = now if done else self._last_time
        wait = (now - started) / LARGEST_SHARE
        if wait > self.interval:
            logger.info("a checkpoint took %.3g s: the next is written after %.3g s, not after the %.3g s of the "
                        "interval, so that they take %.0f%% of the run at most",
                        now - started, wait, self.interval, 100.0 * LARGEST_SHARE)  # fmt: skip
        self._next = now + max(self.interval, wait)
        return done

    @property
    def much_is_new(self) -> bool:
        """Whether so much has been computed since the last one that the end of a run, too, is worth one."""
        return time.monotonic() >= self._last_time + SHORT_SHARE * self.interval

    def _write(self, simulation: Simulation) -> None:
        self._catch_up()
        self._journal.sync()
        values, arrays = memory_of(simulation)
        model = simulation.model
        about = {
            "run_id": simulation.info.run_id, "identity": self._identity(simulation),
            "machine": machine(model.device.name),
            "frame_count": self._journal.count, "frames_size": self._journal.size,
            "written": datetime.now(UTC).isoformat(timespec="seconds"), "parts": list(simulation.info.parts),
        }  # fmt: skip
        write_container(self.folder / f"{self._number:06d}.bin", {**about, **values}, arrays)
        self._last = f"it is of {values['time']:.6g} s"
        self._number += 1
        logger.info("checkpoint at step %d, %.6g s", values["step_count"], values["time"])
        for path in self._files()[KEPT_COUNT:]:
            with suppress(OSError):
                path.unlink()

    def _identity(self, simulation: Simulation) -> dict[str, object]:
        """What a checkpoint must share with a run to continue it, in any stage."""
        identity = simulation.model.identity
        if simulation.setup is simulation.model.setup:  # else that of a stage
            return identity
        # once: a set-up with meshes takes a second
        self._setup_hash = self._setup_hash or hash_of_run(simulation.setup)
        return {**identity, "setup": self._setup_hash}

    def _try(self, action: Any, then: str) -> bool:
        try:
            action()
        except Exception as error:
            reason = error.strerror or error if isinstance(error, OSError) else f"{type(error).__name__}: {error}"
            then = "no more will be written" if self._given_up else then
            text = "a checkpoint could not be written (%s): %s; the last one stays, %s"
            logger.log(logging.INFO if self._said and not self._given_up else logging.WARNING, text, reason, then,
                       self._last)  # fmt: skip
            self._said = True
            return False
        return True

    @property
    def are_there(self) -> bool:
        """Whether there are any that the run could go on from; a short one has none, and is computed again instead."""
        return bool(self._files())

    def remove(self) -> None:
        """Remove them all: the run is finished, and its results are on the disk."""
        remove_checkpoints(self.folder.parent)

    # ------------------------------------------------------------------------------------------------ when it goes on

    def _files(self) -> list[Path]:
        """Of all checkpoints, the last first."""
        if not self.folder.is_dir():
            return []
        return sorted((path for path in self.folder.iterdir() if _NUMBERED.fullmatch(path.name)), reverse=True)

    def find(self) -> Found | None:
        """Look for the last checkpoint that is whole; None if the run has written none, and has to begin anew.

        Those that are damaged are told.

        Raises:
            InputError: there are some, but all are damaged.
        """
        damaged = []
        for path in self._files():
            try:
                content = read_container(path)
                frame_count, size = content.values["frame_count"], content.values["frames_size"]
                for _ in self._journal.frames(frame_count, size):
                    pass
            except (OSError, DamageError, KeyError) as error:
                damaged.append(f"{path.name}: {error}")
                continue
            self._number = int(path.stem) + 1
            for text in damaged:
                logger.warning("a checkpoint is damaged (%s): the one before it is taken", text)
            self.found = Found(path, content)
            return self.found
        if damaged:
            raise InputError(
                f"{self.folder}: no checkpoint can be read ({'; '.join(damaged)}); run it again (--overwrite)"
            )
        return None

    def recall(self, simulation: Simulation) -> list[str]:
        """Have a prepared run be where the checkpoint that was found was written; returns what is different here.

        Raises:
            InputError: the checkpoint is of another version, or of another run.
        """
        assert self.found is not None
        path, content = self.found
        values, model = content.values, simulation.model
        here = machine(model.device.name)
        before = values.get("machine", {})
        if before.get("weavesim") != here["weavesim"]:
            raise InputError(
                f"checkpoint {path}: it is of weavesim {before.get('weavesim')}, and this is {here['weavesim']}; "
                "resume it with that version, or run it again (--overwrite)"
            )
        for name, wanted in self._identity(simulation).items():
            if values["identity"].get(name) != wanted:
                found = "another one" if name == "setup" else f"{values['identity'].get(name)}, not {wanted}"
                raise InputError(
                    f"checkpoint {path}: its {name.replace('_', ' ')} is {found}; resume it on a device of the same "
                    "kind, with the set-up and the precision that it began with"
                )
        try:
            recall(simulation, content)
        except (DamageError, KeyError, TypeError, ValueError) as error:
            raise InputError(f"checkpoint {path}: {error}; run it again (--overwrite)") from None
        self._last = f"it is of {values['time']:.6g} s"
        return list(differences(before, here))

    def frames(self) -> Iterator[Frame]:
        """All frames up to the checkpoint that was found, in order.

        Raises:
            InputError: they have been damaged since.
        """
        assert self.found is not None
        values = self.found.content.values
        try:
            yield from self._journal.frames(values["frame_count"], values["frames_size"])
        except (OSError, DamageError) as error:
            raise InputError(f"{self._journal.path}: {error}; run it again (--overwrite)") from None


def read_job(folder: str | Path) -> tuple[Job, Content]:
    """The job whose run left checkpoints in a folder of results, and the content of its file.

    Raises:
        InputError: there is none, or it is damaged.
    """
    path = job_path(folder)
    try:
        return Job.read(path)
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(f"folder {folder}: there is nothing to resume in it; a run that has finished keeps no "
                         "checkpoint, and one that was killed at its very start has none yet") from None  # fmt: skip
    except (OSError, DamageError) as error:
        raise InputError(f"{path}: {error}; run it again (--overwrite)") from None


def job_path(folder: str | Path) -> Path:
    """File of the job in a folder of results whose run can be resumed."""
    return Path(folder).absolute() / FOLDER_NAME / JOB_NAME


def has_job(folder: Path) -> bool:
    """Whether a folder of results has a run that can be resumed."""
    return job_path(folder).is_file()


def remove_checkpoints(folder: Path) -> None:
    """Remove the checkpoints from a folder of results, the job first, and nothing else.

    Raises:
        OSError: a file that cannot be removed.
    """
    own = folder / FOLDER_NAME
    if own.is_symlink() or not own.is_dir():
        return
    (own / JOB_NAME).unlink(missing_ok=True)
    for path in own.iterdir():
        if path.name == FRAMES_NAME or _NUMBERED.fullmatch(path.name) or path.name.endswith(PARTIAL):
            path.unlink(missing_ok=True)
    with suppress(OSError):  # something else is in it
        own.rmdir()
