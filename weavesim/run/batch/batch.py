"""Runs of many variants at once."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

from ...device import exclusive, resolve_device, resolve_thread_counts
from ...engine.setup import Setup
from ...errors import InputError, RunError
from ..frame import Observer
from ..interruption import Interruption, interrupted_by, interruption
from ..simulation import Simulation
from .batch_run import BatchRun

# A thread that replays steps asks for Python every block, which takes half a millisecond for a coarse sheet; others,
# that take frames, must let it have its turn soon [s].
SWITCH_INTERVAL = 2.0e-4

ObserversOf = Callable[[int], Sequence[Observer]]
Finished = Callable[[int, Simulation], None]


def run_batch(
    setups: Sequence[Setup],
    *,
    threads: int | None = None,
    device: str | None = None,
    observers: ObserversOf | None = None,
    finished: Finished | None = None,
) -> list[BatchRun]:
    """Run many variants, several at a time; each gets the result that it gets alone.

    On a CPU every variant is a run on one thread of its own, so that no thread waits for another within a step: bits
    are those of single runs. A variant that cannot run, or had to stop, is no error of the batch: its ``failure`` says
    why.

    Args:
        setups: of the variants.
        threads: of a CPU; by default all cores. Fewer variants than threads get several each.
        device: replaces that of the set-ups: "cpu", "cuda:0", ...
        observers: (index) -> observers of a variant.
        finished: (index, simulation), called after each run, one at a time, from any thread.

    Returns:
        In the order of ``setups``. After a signal (Ctrl-C) those that had not started have no outcome.

    Raises:
        InputError: no such device, or a bad number of threads.
    """
    setups = tuple(setups)
    if device is not None:
        setups = tuple(_with_solver(setup, device=device) for setup in setups)
    for name in {setup.solver.device for setup in setups}:
        resolve_device(name)
    thread_count = resolve_thread_counts(threads)[-1]
    runner = _Runner(setups, max(1, thread_count // max(len(setups), 1)), observers, finished)
    with interruption() as interrupted, interrupted.held(), _soon(), ThreadPoolExecutor(thread_count) as pool:
        runs = [pool.submit(runner.run, index, interrupted) for index in range(len(setups))]
        return [run.result() for run in runs]


class _Runner:
    """Runs one variant at a time in each of several threads."""

    def __init__(
        self, setups: Sequence[Setup], thread_count: int, observers: ObserversOf | None, finished: Finished | None
    ) -> None:
        self._setups, self._thread_count = setups, thread_count
        self._observers, self._finished = observers, finished

    def run(self, index: int, interrupted: Interruption) -> BatchRun:
        setup = self._setups[index]
        with exclusive(announced=False), interrupted_by(interrupted):
            if interrupted.is_set():
                return BatchRun(setup)
            simulation = Simulation(_with_solver(setup, threads=self._thread_count))
            try:
                simulation.run(self._observers(index) if self._observers else ())
            except InputError as error:
                return BatchRun(setup, failure=str(error))
            except RunError:
                pass  # ``simulation.failure`` says why
            if self._finished:
                self._finished(index, simulation)
            return BatchRun.of(setup, simulation)


def _with_solver(setup: Setup, **settings: object) -> Setup:
    return setup.model_copy(update={"solver": setup.solver.model_copy(update=settings)})


@contextmanager
def _soon() -> Iterator[None]:
    """Inside this context, a thread that wants to run Python gets its turn soon."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_INTERVAL)
    try:
        yield
    finally:
        sys.setswitchinterval(before)
