"""Run a set-up into a folder of results: the same sequence for every run."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..kernel_cache import hashed_once
from ..run.checkpoint.pace import INTERVAL
from .progress import ProgressBar, RunLog
from .session import collected_alone, uncollected

if TYPE_CHECKING:
    from ..engine.setup import Setup
    from ..output import ResultFolder
    from ..run.checkpoint.job import Job
    from ..run.simulation import Simulation

    Measure = Callable[[Simulation], Mapping[str, Any]]

logger = logging.getLogger(__name__)

# A shorter run [s] does not wait until its results are on the disk: it is soon computed again.
SHORT_RUN = 60.0
# Writers that read the fields of the last frame at most; films, series and pages read those of all.
OF_LAST_FRAME = frozenset({"summary", "tables", "pictures", "results"})


@hashed_once()  # also for kernels of the report
def run_into_folder(
    setup: Setup,
    folder: ResultFolder,
    *,
    options: Mapping[str, Any],
    measure: Measure | None = None,
    before: Callable[[], object] | None = None,
    job: Job | None = None,
    checkpoint_interval: float = INTERVAL,
    resumes: bool = False,
    stop_on: Sequence[str] = (),
    shown: Mapping[str, str] | None = None,
    reads_frames: bool = True,
) -> dict[str, Any]:
    """Run a set-up and write its results to ``folder``, however the run ends.

    While it runs it keeps checkpoints in the folder, from which ``weavesim resume`` goes on. They are removed when it
    has finished and everything is written.

    Args:
        setup: of the run.
        folder: for the results.
        options: given by the user, by name, for the record of the run.
        measure: returns the scene's own summary entries after the run.
        before: called when nothing is left to be refused, just before the run.
        job: tells whoever resumes the run where it came from; by default a set-up with its options.
        checkpoint_interval: wall time between two checkpoints [s]; 0 writes none.
        resumes: go on from the last checkpoint of ``job`` in the folder, or from the start where there is none yet.
        stop_on: guards that end the run (``run.watch.stops``); those of ``job`` where it is given.
        shown: the options in words and with their units, for the report; by default as they are.
        reads_frames: whether anything beside the writers of the folder, such as its curves, may read any field of any
            frame.

    Returns:
        The summary as written.

    Raises:
        InputError: bad input, before anything is written.
        RunError: the run had to stop; results up to the last good frame are written first.
    """
    from ..measures.defects.waves import WaveFilter
    from ..output.files import plain
    from ..run.checkpoint.checkpoints import Checkpoints
    from ..run.checkpoint.job import Job
    from ..run.estimate import check_room
    from ..run.frame import Outcome
    from ..run.interruption import interruption
    from ..run.simulation import Simulation
    from ..run.start import sheet_infos

    checkpoints = Checkpoints(folder.path, checkpoint_interval)
    every_field = reads_frames or not OF_LAST_FRAME.issuperset(folder.writer_names)
    log, bar = RunLog(folder.path, stays=True), ProgressBar(stays=True)
    summary: dict[str, Any] = {}
    bar.listen()
    try:
        folder.check(tuple(sheet_infos(setup)))
        folder.claim()
        # a run that is resumed shares its id
        run_id, stop_on = (None, stop_on) if job is None else (job.run_id, job.stop_on)
        simulation = Simulation(setup, run_id=run_id, stop_on=stop_on)
        simulation.stops.pass_over(job.passed if job is not None else ())
        with uncollected():
            info = simulation.prepare().info
        if every_field:
            folder.load_beside("heights of wrinkles", "scipy", WaveFilter.load)
        if info.expected is not None:
            check_room(info.expected, setup, folder.path)
        _rehearse(simulation, measure)
        if resumes:
            log.goes_on(-1.0)
            if checkpoints.find() is not None:
                simulation.resume(checkpoints)
                log.goes_on(simulation.state.time)
                bar.goes_on(simulation.state.time)
        if before is not None:
            before()
        if job is None:
            job = Job(
                setup, info.run_id, plain(options), writers=folder.writer_names, solver_fields=folder.solver_fields,
                stop_on=tuple(stop_on),
            )  # fmt: skip
        checkpoints.job = job
        with collected_alone(), interruption() as interrupted, interrupted.held():
            try:
                # the folder removes old results, before the log begins and after warnings are shown
                simulation.run(
                    [bar, folder, log],
                    checkpoints=checkpoints if checkpoint_interval else None,
                    every_field=every_field,
                )
            finally:
                if simulation.history:
                    folder.add(log.path)
                    summary = folder.write(
                        _numbers(simulation, folder, log, measure), setup=options if shown is None else shown
                    )
                    if simulation.outcome is Outcome.FINISHED and not summary["missing"]:
                        if checkpoints.are_there or simulation.wall_time > SHORT_RUN:
                            folder.sync()
                        checkpoints.remove()
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
    if simulation.stops.by is not None:
        numbers["stopped_by"] = simulation.stops.by.guard
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
