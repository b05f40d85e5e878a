"""From a set-up to a folder of results: the same order of events for every run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from .progress import ProgressBar, RunLog

if TYPE_CHECKING:
    from ..engine.setup import Setup
    from ..output import ResultFolder
    from ..run.simulation import Simulation


def run_into_folder(
    setup: Setup,
    folder: ResultFolder,
    *,
    options: Mapping[str, Any],
    measure: Callable[[Simulation], Mapping[str, Any]] | None = None,
) -> dict[str, Any]:
    """Run a set-up and leave its results in ``folder``, however the run ends.

    Args:
        setup: what is run.
        folder: of the results.
        options: what was asked for, by name, for the report.
        measure: the scene's own entries of the summary, taken after the run.

    Returns:
        The summary as written.

    Raises:
        InputError: bad input, before anything is written.
        RunError: the run had to stop; the results up to the last good frame are written first.
    """
    from ..run.simulation import Simulation

    log = RunLog(folder.path)
    try:
        simulation = Simulation(setup)
        try:
            simulation.run([log, ProgressBar(), folder])
        finally:
            summary: dict[str, Any] = {}
            if simulation.history:
                own = measure(simulation) if measure else {}
                summary = folder.write({**simulation.summary(), **own}, setup=options)
    finally:
        log.close()
    return summary
