"""Run a set-up into a folder of results: the same sequence for every run."""

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
    """Run a set-up and write its results to ``folder``, however the run ends.

    Args:
        setup: of the run.
        folder: for the results.
        options: given by the user, by name, for the report.
        measure: returns the scene's own summary entries after the run.

    Returns:
        The summary as written.

    Raises:
        InputError: bad input, before anything is written.
        RunError: the run had to stop; results up to the last good frame are written first.
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
