"""Runs whose steps are done on another device, many in one launch."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterator, Sequence

import numpy as np

from ...device import resolve_device
from ...engine.setup import Setup
from ...engine.worlds.alike import differences
from ...engine.worlds.world_stepper import WorldStepper
from ...errors import InputError, RunError
from ..diagnosis import find_failure
from ..frame import Outcome
from ..interruption import Interruption
from ..simulation import Simulation

# Worlds that are stepped at once.
LARGEST_WORLD_COUNT = 1024

Course = Generator[tuple[float, Interruption], bool, Outcome]


class Worlds:
    """Runs that are alike, stepped together on one device while everything else of them is done by the host.

    Args:
        device: of the steps.
        simulations: prepared, on the host, with one lane.

    Raises:
        InputError: the runs differ in what they must share.
    """

    def __init__(self, device: str, simulations: Sequence[Simulation]) -> None:
        self._simulations = tuple(simulations)
        first = simulations[0]
        for other in simulations[1:]:
            if found := differences(first.model, other.model):
                raise InputError(
                    f"{first.name} and {other.name} cannot share launches: {'; '.join(found)}; run them in batches of "
                    "their own"
                )
        self._stepper = WorldStepper(resolve_device(device), [each.stepper for each in simulations])
        for simulation in simulations:
            simulation.computed_on(device)

    def run(self, courses: Sequence[Course], ended: Callable[[int], None], interrupted: Interruption) -> None:
        """Run all to their ends.

        Args:
            courses: of the simulations.
            ended: called with the number of each that has ended.
            interrupted: notes the signals that stop all.
        """
        self._stepper.load()
        self._stepper.start()
        targets = np.array([next(course)[0] for course in courses])
        while (active := np.flatnonzero(np.isfinite(targets))).size:
            started = time.perf_counter()
            self._stepper.advance_to(targets, interrupted.is_set)
            spent = (time.perf_counter() - started) / len(active)
            for index in active.tolist():
                simulation = self._simulations[index]
                simulation.stepping_time += spent
                simulation.failed = find_failure(simulation.model, simulation.state, simulation.frame)
                target = _go_on(courses[index], not interrupted.is_set())
                targets[index] = -np.inf if target is None else target
                if target is None:
                    ended(index)


def _go_on(course: Course, running: bool) -> float | None:
    """The next target of a run [s]; None if it has ended."""
    try:
        return course.send(running)[0]
    except (StopIteration, RunError):  # ``Simulation.failure`` says why
        return None


def host_setup(setup: Setup) -> Setup:
    """For everything of a run but its steps."""
    solver = setup.solver.model_copy(update={"device": "cpu", "lane_count": 1, "threads": 1})
    return setup.model_copy(update={"solver": solver})


def alike(simulations: Sequence[Simulation]) -> Iterator[list[int]]:
    """Numbers of the runs that can share launches, in groups of at most ``LARGEST_WORLD_COUNT``."""
    groups: list[list[int]] = []
    for index, simulation in enumerate(simulations):
        for group in groups:
            if len(group) < LARGEST_WORLD_COUNT and not differences(simulations[group[0]].model, simulation.model):
                group.append(index)
                break
        else:
            groups.append([index])
    yield from groups
