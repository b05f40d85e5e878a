"""Runs that are killed at random moments and resumed until they end, in forked processes of one interpreter.

``python -m tests.support.kills FOLDER COUNT SEED [KILLS]`` prints a line of JSON for every run: how it was killed, and
what is different from a run that was never interrupted. After COUNT runs in stages follow those of a set-up without
any, which take a third of the time, until there were so many KILLS.
"""

from __future__ import annotations

import builtins
import contextlib
import hashlib
import io
import json
import os
import random
import shutil
import signal
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from tests.support.every_kind import IN_LANES, in_stages, two_worlds
from weavesim.app.run_into_folder import run_into_folder
from weavesim.engine.setup import Setup
from weavesim.output import ResultFolder
from weavesim.output.writers.film import FilmWriter
from weavesim.run.checkpoint import checkpoints as checkpoints_module
from weavesim.run.checkpoint.checkpoints import Checkpoints, has_job, read_job
from weavesim.run.checkpoint.container import read_container
from weavesim.run.checkpoint.job import Job
from weavesim.run.simulation import Simulation

WRITERS = ("film", "paraview", "summary", "tables")
RUN_ID = "20260101T000000Z-00000000"
# What differs between two runs of one set-up, and what tells that one was resumed.
VOLATILE = {
    "threads", "wall_time_s", "stepping_time_s", "output_time_s", "element_steps_per_second", "notes", "warnings",
}  # fmt: skip
# A run that takes longer hangs, on whatever machine [s].
LONGEST_LIFE = 600.0


def tiny_setup(threads: int = 1, short: bool = False) -> Setup:
    """Three sheets in two worlds, with every kind of state: a few hundred steps in four stages, or fifty in none."""
    setup = two_worlds(IN_LANES) if short else in_stages(IN_LANES)
    if short:
        setup = setup.model_copy(update={"duration": 1.0e-4, "frame_count": 2, "accept_unusual": True})
    solver = setup.solver.model_copy(update={"threads": threads})
    return setup.model_copy(update={"solver": solver, "name": "tiny"})


class Death(NamedTuple):
    """How a process dies.

    Attributes:
        operation: before or within which operation on files, counted from 0; None for none.
        after: wall time [s]; None for never.
        share: of what that operation was to write, which is written.
    """

    operation: int | None = None
    after: float | None = None
    share: float = 0.0


class _Operations:
    """Counts what a process does to files, and kills it at one of these."""

    def __init__(self, death: Death) -> None:
        self._death, self.count = death, 0

    def one(self, within: Callable[[float], object] | None = None) -> None:
        """Another operation; ``within`` does a share of it."""
        self.count += 1
        if self.count - 1 == self._death.operation:
            if within is not None:
                within(self._death.share)
            os.kill(os.getpid(), signal.SIGKILL)

    def install(self) -> None:
        """Watch this process from now on."""
        plain_open, fsync = io.open, os.fsync

        def opened(file: Any, mode: str = "r", *arguments: Any, **given: Any) -> Any:
            if not set(mode) & set("wax+"):
                return plain_open(file, mode, *arguments, **given)
            self.one()
            return _Torn(plain_open(file, mode, *arguments, **given), self)

        def synced(descriptor: int) -> None:
            self.one()
            fsync(descriptor)

        def audited(event: str, arguments: tuple) -> None:
            if event in ("os.rename", "os.remove", "os.mkdir", "os.rmdir", "shutil.copyfile"):
                self.one()

        builtins.open = io.open = opened  # type: ignore[assignment]
        os.fsync = synced
        sys.addaudithook(audited)


class _Torn:
    """A file of which a write may be the last thing that its process does."""

    def __init__(self, file: Any, operations: _Operations) -> None:
        self._file, self._operations = file, operations

    def write(self, data: Any) -> int:
        def within(share: float) -> None:
            self._file.write(data[: int(share * len(data))])
            self._file.flush()

        self._operations.one(within)
        return self._file.write(data)

    def writelines(self, parts: Any) -> None:
        for part in parts:
            self.write(part)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)

    def __enter__(self) -> _Torn:
        return self

    def __exit__(self, *error: object) -> None:
        self._file.close()


NEVER = Death()


def forked(work: Callable[[], object], death: Death = NEVER) -> tuple[bool, str, float]:
    """Do ``work`` in a process of its own: whether it came to its end, what it returned or raised, and how long [s]."""
    started = time.monotonic()
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        quiet = os.open(os.devnull, os.O_WRONLY)
        os.dup2(quiet, 1)
        os.dup2(quiet, 2)
        try:
            text = json.dumps({"result": work()})
        except BaseException as error:
            text = json.dumps({"error": f"{type(error).__name__}: {error}"})
        os.write(writing, text.encode())
        os._exit(0)
    os.close(writing)
    end = started + (LONGEST_LIFE if death.after is None else death.after)
    while os.waitpid(child, os.WNOHANG)[0] == 0:
        if time.monotonic() >= end:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
            break
        time.sleep(0.001)
    with os.fdopen(reading, "rb") as file:
        text = file.read().decode()
    seconds = time.monotonic() - started
    if not text:
        return False, "killed", seconds
    answer = json.loads(text)
    return "result" in answer, answer.get("error", json.dumps(answer.get("result"))), seconds


def run_or_resume(folder: Path, threads: int, death: Death, short: bool = False) -> dict[str, Any]:
    """Begin a run in a folder, or go on with it if it has begun: what ``weavesim resume`` does, without its start."""
    checkpoints_module.LARGEST_SHARE = 1.0e9
    ended: dict[str, Any] = {}
    remove = Checkpoints.remove

    def digested(self: Checkpoints) -> None:
        last = read_container(self._files()[0])
        ended["state"] = _digest(b"".join(array.tobytes() for name, array in last.arrays.items() if "state/" in name))
        remove(self)

    Checkpoints.remove = digested  # type: ignore[method-assign]
    setup = tiny_setup(threads, short)
    resumes = has_job(folder)
    operations = _Operations(death)
    operations.install()
    if resumes:
        kept = read_job(folder)[0]
        job = Job(setup, kept.run_id, kept.options, kept.origin, kept.writers)
    else:
        job = Job(setup, RUN_ID, {}, {}, WRITERS)
    results = ResultFolder(folder, writers=job.writers, overwrite=True, resumes=resumes)
    summary = run_into_folder(
        setup, results, options={}, job=job, checkpoint_interval=0.01, resumes=resumes
    )  # fmt: skip
    return {**ended, "missing": summary["missing"], "operations": operations.count}


def outcome(folder: Path, ended: dict[str, Any]) -> dict[str, str]:
    """Digests of everything that a run leaves."""
    found = {"state": ended["state"], "missing": str(ended["missing"])}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name not in ("summary.json", "run.json", "run.log", "setup.json"):
            found[path.relative_to(folder).as_posix()] = _digest(path.read_bytes())
    numbers = json.loads((folder / "summary.json").read_text())
    found |= {f"summary: {name}": json.dumps(value) for name, value in numbers.items() if name not in VOLATILE}
    return found


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def deaths(rng: random.Random, operation_count: int, seconds: float) -> Iterator[Death]:
    """One to three deaths, half of them at an operation on files, half at any moment."""
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        if rng.random() < 0.5:
            yield Death(operation=rng.randrange(operation_count), share=rng.random())
        else:
            yield Death(after=rng.uniform(0.0, seconds))


class Whole(NamedTuple):
    """A run that was never interrupted: what it left, its operations on files, and how long it took [s]."""

    outcome: dict[str, str]
    operations: int
    seconds: float


def uninterrupted(folder: Path, short: bool) -> Whole:
    """Run to the end, with whatever else that needs.

    Raises:
        RuntimeError: it did not come to its end.
    """
    shutil.rmtree(folder, ignore_errors=True)
    done, said, seconds = forked(partial(run_or_resume, folder, 1, NEVER, short))
    if not done:
        raise RuntimeError(said)
    ended = json.loads(said)
    return Whole(outcome(folder, ended), ended["operations"], seconds)


def kill_and_resume(folder: Path, rng: random.Random, whole: Whole, short: bool) -> dict:
    """One run: how often it was killed, how, and how its end differs from the whole one."""
    shutil.rmtree(folder, ignore_errors=True)
    planned, tried = list(deaths(rng, whole.operations, whole.seconds)), []
    for death in planned:
        threads = rng.choice((1, 2))
        done, said, _ = forked(partial(run_or_resume, folder, threads, death, short), death)
        tried.append({"threads": threads, **death._asdict(), "ended": said if done or said != "killed" else "killed",
                      "resumable": has_job(folder)})  # fmt: skip
        if done or said != "killed":
            break
    else:
        done, said, _ = forked(partial(run_or_resume, folder, 1, NEVER, short))
    if not done:
        return {"deaths": tried, "error": said}
    ended = outcome(folder, json.loads(said))
    names = sorted({*ended, *whole.outcome})
    return {"deaths": tried, "different": [name for name in names if ended.get(name) != whole.outcome.get(name)]}


def warmed_up() -> None:
    """Load all that a run needs, but start no thread, before the first fork."""
    FilmWriter.load()
    for threads in (1, 2):
        Simulation(tiny_setup(threads)).prepare()
        Simulation(tiny_setup(threads, short=True)).prepare()


def main(folder: str, count: str, seed: str, kills: str = "0") -> int:
    base, rng = Path(folder), random.Random(int(seed))
    base.mkdir(parents=True, exist_ok=True)
    with contextlib.redirect_stdout(sys.stderr):
        warmed_up()
    failed = killed = 0
    for short, number in ((False, int(count)), (True, int(kills))):
        if not number:
            continue
        whole = uninterrupted(base / "reference", short)
        about = {"reference": len(whole.outcome), "operations": whole.operations, "seconds": whole.seconds}
        print(json.dumps(about), flush=True)
        # on a machine that is less busy than it was, runs end before they are killed
        for _ in range(10 * number if short else number):
            if short and killed >= number:
                break
            found = kill_and_resume(base / "killed", rng, whole, short)
            killed += sum(death["ended"] == "killed" for death in found["deaths"])
            failed += bool(found.get("error") or found.get("different"))
            print(json.dumps(found), flush=True)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
