"""Run a set-up into a folder of results: the same sequence for every run."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from .progress import ProgressBar, RunLog

if TYPE_CHECKING:
    from ..engine.setup import Setup
    from ..output import ResultFolder
    from ..run.simulation import Simulation

    Measure = Callable[[Simulation], Mapping[str, Any]]

logger = logging.getLogger(__name__)


def run_into_folder(
    setup: Setup,
    folder: ResultFolder,
    *,
    options: Mapping[str, Any],
    measure: Measure | None = None,
    before: Callable[[], object] | None = None,
) -> dict[str, Any]:
    """Run a set-up and write its results to ``folder``, however the run ends.

    Args:
        setup: of the run.
        folder: for the results.
        options: given by the user, by name, for the report.
        measure: returns the scene's own summary entries after the run.
        before: called when nothing is left to be refused, just before the run.

    Returns:
        The summary as written.

    Raises:
        InputError: bad input, before anything is written.
        RunError: the run had to stop; results up to the last good frame are written first.
    """
    from ..run.estimate import check_room
    from ..run.interruption import interruption
    from ..run.simulation import Simulation
    from ..run.start import sheet_infos

    log, bar = RunLog(folder.path, stays=True), ProgressBar(stays=True)
    summary: dict[str, Any] = {}
    bar.listen()
    try:
        folder.check(tuple(sheet_infos(setup)))
        folder.claim()
        simulation = Simulation(setup)
        info = simulation.prepare().info
        if info.expected is not None:
            check_room(info.expected, setup, folder.path)
        _rehearse(simulation, measure)
        if before is not None:
            before()
        with interruption() as interrupted, interrupted.held():
            try:
                # the folder removes old results, before the log begins and after warnings are shown
                simulation.run([bar, folder, log])
            finally:
                if simulation.history:
                    folder.add(log.path)
                    summary = folder.write(_numbers(simulation, folder, log, measure), setup=options)
    finally:
        bar.close()
        log.close()
        folder.release()
    return summary


def _numbers(simulation: Simulation, folder: ResultFolder, log: RunLog, measure: Measure | None) -> dict[str, Any]:
    """All numbers of the run that can be computed."""
    numbers = dict(folder.measure("the assessment of the run", simulation.summary))
    if simulation.interrupted_by:
        numbers["interrupted_by"] = simulation.interrupted_by
    if measure is not None:
        numbers |= folder.measure("the findings of the scene", partial(measure, simulation))
    if log.failed:
        folder.warnings.note(log.path.name, f"{log.path.name} could not be written to its end")
    return numbers


def _rehearse(simulation: Simulation, measure: Measure | None) -> None:
    """Compute the numbers at the start, which tells input that they cannot be computed for.

    Raises:
        InputError: such input.
    """
    try:
        simulation.summary()
        if measure is not None:
            measure(simulation)
    except InputError:
        raise
    except Exception as error:
        # before the first frame a number may have no value
        logger.debug("a number cannot be computed at the start: %s: %s", type(error).__name__, error)
