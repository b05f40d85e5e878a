"""Runs of many variants at once."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing
from dataclasses import replace
from typing import Any

from ...device import exclusive, resolve_device, resolve_thread_counts
from ...engine.setup import Setup
from ...engine.threads import soon
from ...engine.worlds.alike import obstacles
from ...engine.worlds.mirror import Unalike
from ...errors import InputError, RunError
from ..frame import Observer
from ..interruption import Interruption, interrupted_by, interruption
from ..simulation import Simulation
from ..watch.stops import stop_levels
from ..watch.watch import check_watch_count
from .batch_run import BatchRun
from .worlds import Worlds, alike, host_setup

logger = logging.getLogger(__name__)

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
    watch_count: int | None = None,
    stop_on: Sequence[str] = (),
) -> list[BatchRun]:
    """Run many variants, several at a time; each gets the result that it gets alone.

    On a CPU every variant is a run on one thread of its own, so that no thread waits for another within a step: bits
    are those of single runs. On a GPU variants that are alike (``engine.worlds.alike``) are stepped in one launch,
    each by its own steps, while the host takes their frames; others run one after the other.

    A variant that cannot run, or had to stop, is no error of the batch: its ``failure`` says why.

    Args:
        setups: of the variants.
        threads: of a CPU; by default all cores. Fewer variants than threads get several each.
        device: replaces that of the set-ups: "cpu", "cuda:0", ...
        observers: (index) -> observers of a variant.
        finished: (index, simulation), called after each run, one at a time, from any thread.
        watch_count: states of each that the guards look at. On coarse meshes they take longer than the steps; extremes
            are those of all steps, however few.
        stop_on: guards that end a variant, see ``run.watch.stops``.

    Returns:
        In the order of ``setups``. After a signal (Ctrl-C) those that had not started have no outcome.

    Raises:
        InputError: no such device or guard, or a bad number of threads or states.
    """
    stop_levels(stop_on)
    check_watch_count(watch_count)
    setups = tuple(setups)
    for index, setup in enumerate(setups):
        if not isinstance(setup, Setup):
            raise InputError(f"run_batch: entry {index} is a {type(setup).__name__}; values of Setup are needed")
    setups = tuple(setups if device is None else (_with_solver(setup, device=device) for setup in setups))
    on_cpu = {name: resolve_device(name).is_cpu for name in {setup.solver.device for setup in setups}}
    thread_count = resolve_thread_counts(threads)[-1]
    of_cpu = [index for index, setup in enumerate(setups) if on_cpu[setup.solver.device]]
    own_threads = max(1, thread_count // max(len(of_cpu), 1))
    runner = Runner(setups, own_threads, observers, finished, watch_count, stop_on)
    with interruption() as interrupted, interrupted.held():
        results: dict[int, BatchRun] = {}
        for name in (name for name, is_cpu in on_cpu.items() if not is_cpu):
            own = [index for index, setup in enumerate(setups) if setup.solver.device == name]
            results |= runner.run_together(name, own, interrupted)
        with soon(SWITCH_INTERVAL), ThreadPoolExecutor(thread_count) as pool:
            runs = {index: pool.submit(runner.run, index, interrupted) for index in of_cpu}
            results |= {index: run.result() for index, run in runs.items()}
    return [results[index] for index in range(len(setups))]


class Runner:
    """Runs variants: one at a time in each of several threads, or many together.

    Args:
        setups: of the variants.
        thread_count: CPU threads of each.
        observers, finished, watch_count, stop_on: see ``run_batch``.
    """

    def __init__(
        self,
        setups: Sequence[Setup],
        thread_count: int = 1,
        observers: ObserversOf | None = None,
        finished: Finished | None = None,
        watch_count: int | None = None,
        stop_on: Sequence[str] = (),
    ) -> None:
        self._setups, self._thread_count = setups, thread_count
        self._given: dict[str, Any] = {"watch_count": watch_count, "stop_on": stop_on}
        self._observers, self._finished = observers, finished

    def run(self, index: int, interrupted: Interruption) -> BatchRun:
        """Run one variant, on a CPU on its number of threads."""
        setup = self._setups[index]
        with exclusive(announced=False), interrupted_by(interrupted):
            if interrupted.is_set():
                return BatchRun(setup)
            own = _with_solver(setup, threads=self._thread_count)
            simulation = Simulation(own, **self._given)
            try:
                simulation.run(self._observers_of(index))
            except InputError as error:
                return BatchRun(setup, failure=str(error))
            except RunError as error:
                # of a stage that cannot begin, the simulation itself knows no failure
                return replace(self._result(index, simulation), failure=str(error))
            return self._result(index, simulation)

    def run_together(self, device: str, indices: Sequence[int], interrupted: Interruption) -> dict[int, BatchRun]:
        """Run variants whose steps are done on ``device``, as many as possible in the same launches."""
        apart = [index for index in indices if len(indices) == 1 or obstacles(self._setups[index])]
        results = {index: self.run(index, interrupted) for index in apart}
        with exclusive(announced=False):
            simulations: dict[int, Simulation] = {}
            for index in (index for index in indices if index not in results):
                if interrupted.is_set():
                    results[index] = BatchRun(self._setups[index])
                    continue
                simulation = Simulation(host_setup(self._setups[index]), **self._given)
                try:
                    simulation.prepare()
                    simulations[index] = simulation
                except InputError as error:
                    results[index] = BatchRun(self._setups[index], failure=str(error))
            ready = list(simulations)
            for group in alike(list(simulations.values())):
                own = [ready[place] for place in group]
                logger.info("%d variants are stepped together on %s", len(own), device)
                self._run_group(device, {index: simulations.pop(index) for index in own}, results, interrupted)
        return results

    def _run_group(
        self,
        device: str,
        simulations: dict[int, Simulation],
        results: dict[int, BatchRun],
        interrupted: Interruption,
    ) -> None:
        indices = list(simulations)

        def ended(place: int) -> None:
            index = indices[place]
            results[index] = self._result(index, simulations[index])

        try:
            worlds = Worlds(device, list(simulations.values()))
        except Unalike as error:
            logger.warning("%d variants cannot share launches, and run one by one: %s", len(indices), error)
            results |= {index: self.run(index, interrupted) for index in indices}
            return
        with ExitStack() as stack:
            courses = [
                stack.enter_context(closing(simulation.course(self._observers_of(index))))
                for index, simulation in simulations.items()
            ]
            worlds.run(courses, ended, interrupted)

    def _observers_of(self, index: int) -> Sequence[Observer]:
        return self._observers(index) if self._observers else ()

    def _result(self, index: int, simulation: Simulation) -> BatchRun:
        if self._finished:
            self._finished(index, simulation)
        return BatchRun.of(self._setups[index], simulation)


def _with_solver(setup: Setup, **settings: object) -> Setup:
    return setup.model_copy(update={"solver": setup.solver.model_copy(update=settings)})
