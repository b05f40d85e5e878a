"""From a scene's parameters to a folder of results: the same order of events for every scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from .progress import ProgressBar, RunLog

if TYPE_CHECKING:
    from ..output import ResultFolder
    from ..run.simulation import Simulation


def run_into_folder(
    make: Callable[[], Simulation],
    folder: ResultFolder,
    *,
    setup: Mapping[str, Any],
    measure: Callable[[Simulation], Mapping[str, Any]] | None = None,
) -> dict[str, Any]:
    """Make a simulation, run it, and leave its results in ``folder``, however the run ends.

    Args:
        make: builds the simulation; what it raises is raised before anything is written.
        folder: of the results.
        setup: what was asked for, by name, for the report.
        measure: the scene's own entries of the summary, taken after the run.

    Returns:
        The summary as written.

    Raises:
        InputError: bad input, before the run.
        RunError: the run had to stop; the results up to the last good frame are written first.
    """
    log = RunLog(folder.path)
    try:
        simulation = make()
        try:
            simulation.run([log, ProgressBar(), folder])
        finally:
            summary: dict[str, Any] = {}
            if simulation.history:
                own = measure(simulation) if measure else {}
                summary = folder.write({**simulation.summary(), **own}, setup=setup)
    finally:
        log.close()
    return summary
