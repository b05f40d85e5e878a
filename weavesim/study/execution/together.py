"""Many runs in one process and, on a GPU, in the same launches: ``run_batch`` as what computes a study.

A study uses it by itself for a GPU. On a CPU processes are as fast, and one that dies costs one run.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from itertools import islice

from ...errors import InputError, RunError
from ...output.files import plain
from ...run.batch.batch import run_batch
from ...run.batch.batch_run import BatchRun
from ...run.frame import Outcome
from ...run.interruption import Interrupted, interruption
from ...run.simulation import Simulation
from ..job_subject import JobTask
from ..subject import Task, compute, quiet
from ..table import Found
from .executor import Result

# Runs in one batch: a GPU is full long before, and what is done is kept after each batch.
LARGEST_BATCH = 256


class TogetherExecutor:
    """So many runs of jobs at a time, in this process; those of other subjects, and of cases, one after the other.

    Args:
        width: how many.
    """

    def __init__(self, width: int = LARGEST_BATCH) -> None:
        self.width = width

    def run(self, tasks: Iterable[tuple[str, Task]]) -> Iterator[Result]:
        """See ``Executor``."""
        coming = iter(tasks)
        while batch := list(islice(coming, self.width)):
            together = [(key, task) for key, task in batch if isinstance(task, JobTask) and len(task.setups) == 1]
            yield from self._together(together)
            for key, task in batch:
                if not any(key == other for other, _ in together):
                    found = compute(task)
                    yield Result(key, found, worker=found.worker)

    def _together(self, tasks: list[tuple[str, JobTask]]) -> Iterator[Result]:
        if not tasks:
            return
        started = time.perf_counter()
        setups = [task.setups[0][1] for _, task in tasks]
        found: dict[int, Found] = {}
        with ExitStack() as stack:
            path = stack.enter_context(tempfile.TemporaryDirectory(prefix="weavesim-"))
            stack.enter_context(quiet())
            interrupted = stack.enter_context(interruption())
            observed = [task.observed(setups[k], f"{path}/{k}") for k, (_, task) in enumerate(tasks)]

            def finished(index: int, simulation: Simulation) -> None:
                if simulation.outcome is not Outcome.FINISHED:
                    return
                try:
                    found[index] = tasks[index][1].found(simulation, *observed[index])
                except (InputError, RunError) as error:
                    found[index] = Found("failed", error=str(error))

            runs = run_batch(setups, observers=lambda index: [observed[index][0]], finished=finished)
            if interrupted.signal is not None:
                raise Interrupted(interrupted.signal)
        share = (time.perf_counter() - started) / len(tasks)
        for index, ((key, _), run) in enumerate(zip(tasks, runs, strict=True)):
            one = found.get(index) or _failed(run)
            whole = Found(one.status, one.verdict, plain(one.numbers), one.error, one.fields, share, "batch")
            yield Result(key, whole, worker="batch")

    def close(self) -> None:
        """It has no processes."""


def _failed(run: BatchRun) -> Found:
    status = "refused" if run.frame is None else "failed"
    return Found(status, error=run.failure or "it ended before its time")
