"""``weavesim study``: many runs of a job, into a folder with a table and a page."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import InputError, RunError
from .ending import ExitCode
from .jobs.arguments import FilesFrom, Settings, asked_of_a_job
from .session import announce_compilation, interruptible
from .terminal import say

if TYPE_CHECKING:
    from ..study.analysis.results import StudyResults
    from ..study.execution.executor import Executor
    from ..study.job_subject import JobSubject
    from ..study.read import Study
    from ..study.table import RunTable

DEFAULT_OUT = "study"
BEST_FOLDER = "best"
# Results that are left out of the best run's folder, unless its job says what to write.
LEFT_OUT = ("film", "paraview")


def study_command(
    file: Annotated[Path, typer.Argument(help="a study file; or a job file, with --vary", metavar="FILE")],
    vary: Annotated[
        list[str] | None,
        typer.Option(help="a parameter of the job, such as tools.ring.force=100:2000:8; may be repeated",
                     metavar="KEY=VALUES"),
    ] = None,
    measure: Annotated[
        list[str] | None, typer.Option(help="a number of each run, such as max_shear_p99; may be repeated")
    ] = None,
    least: Annotated[list[str] | None, typer.Option(help="a measure that is best where it is least")] = None,
    most: Annotated[list[str] | None, typer.Option(help="a measure that is best where it is most")] = None,
    method: Annotated[
        str | None, typer.Option(help="factorial, latin-hypercube, sobol or optimise [default: factorial]")
    ] = None,
    samples: Annotated[int | None, typer.Option(help="of latin-hypercube and sobol")] = None,
    budget: Annotated[int | None, typer.Option(help="points that optimise may try")] = None,
    noise: Annotated[
        int | None, typer.Option(help="repeat some points so often with another unevenness, for error bars")
    ] = None,
    seed: Annotated[int | None, typer.Option(help="of designs and optimisers")] = None,
    set_: Settings = None,
    files_from: FilesFrom = None,
    out: Annotated[Path | None, typer.Option(help="folder for the results [default: study, beside FILE]")] = None,
    jobs: Annotated[
        int | None, typer.Option(min=1, help="processes on this machine [default: one for each core; for a GPU one]")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(help="address of a Dask scheduler whose workers compute, such as tcp://host:8786")
    ] = None,
    fields: Annotated[
        bool, typer.Option("--fields", help="keep fields at common material points: fields.h5")
    ] = False,
    best: Annotated[
        bool, typer.Option("--best/--no-best", help="form the best point once more, with its report")
    ] = True,
) -> None:  # fmt: skip
    """Run a job with many values, and say what matters, what is noise, and what is best."""
    from ..study.page.page import FILE_NAME, check_page

    given = {"method": method, "samples": samples, "budget": budget, "noise": noise, "seed": seed}
    study = _study(file, vary or (), measure or (), least or (), most or (), given)
    if jobs is not None and scheduler is not None:
        raise InputError("--jobs: has no effect with --scheduler, whose workers say how many runs they take")
    check_page()
    folder = out or file.parent / DEFAULT_OUT
    with interruptible() as interrupted, asked_of_a_job():
        try:
            results = run_study(
                study, folder, settings=set_ or (), files_from=files_from or (), jobs=jobs, scheduler=scheduler,
                fields=fields, with_best=best,
            )  # fmt: skip
        except KeyboardInterrupt:
            say(f"Interrupted; what is done is kept in {folder}. The same command goes on.")
            raise
        number = interrupted.signal
    for line in closing_lines(results, folder):
        say(line)
    say(f"Open {folder / FILE_NAME} in a browser.")
    if number is not None:
        raise typer.Exit(128 + number)
    if not any(answer.status == "finished" for answer in results.answers):
        raise typer.Exit(int(ExitCode.RUN_ERROR))


def _study(
    file: Path, vary: Sequence[str], measure: Sequence[str], least: Sequence[str], most: Sequence[str],
    given: dict[str, Any],
) -> Study:  # fmt: skip
    from ..documents import read_document
    from ..study.read import read_study, study_of_options
    from ..study.schema import NoiseTable

    told = {name: value for name, value in given.items() if value is not None}
    if vary:
        if "noise" in told:
            told["noise"] = NoiseTable(repeats=told["noise"])
        return study_of_options(file, vary, measure, least, most, **told)
    extra = [f"--{name}" for name in told] + [f"--{n}" for n, v in
             (("measure", measure), ("least", least), ("most", most)) if v]  # fmt: skip
    values = read_document(file, "study").values
    if "vary" not in values and ("ply" in values or "scene" in values):
        raise InputError(f"{file}: it is a job, not a study; say what to vary: --vary KEY=LOW:HIGH:COUNT")
    if extra:
        raise InputError(f"{', '.join(extra)}: have no effect with a study file; write it there, or give --vary")
    return read_study(file)


def run_study(
    study: Study,
    folder: Path,
    *,
    settings: Sequence[str] = (),
    files_from: Sequence[Path] = (),
    jobs: int | None = None,
    scheduler: str | None = None,
    fields: bool = False,
    with_best: bool = True,
) -> StudyResults:
    """Run a study into a folder.

    Args:
        study: as read.
        folder: for its results.
        settings: of the job for all runs, in the form of --set.
        files_from: folders outside the job's own that it may read files from.
        jobs: runs at a time on this machine; None for one on each core.
        scheduler: address of a Dask scheduler; None for this machine.
        fields: keep fields at material points.
        with_best: form the best point once more, with its report.

    Raises:
        InputError: bad input, before anything runs.
        RunError: a cluster is gone for good.
    """
    from ..engine.compilation import side_by_side
    from ..output.claim.lock import FolderLock
    from ..output.files import check_writable
    from ..study.conduct import Conductor
    from ..study.page.page import FILE_NAME, write_page
    from ..study.record import write_all_fields, write_study
    from ..study.subject import digest
    from ..study.table import FILE_NAME as TABLE_NAME
    from ..study.table import RunTable
    from .study_progress import StudyProgress

    check_writable(folder)
    lock = FolderLock(folder)
    lock.acquire()
    with ExitStack() as stack:
        stack.callback(lock.release)
        if not (folder / TABLE_NAME).exists():
            stack.callback(_forget_empty, folder / TABLE_NAME)
        table = stack.enter_context(RunTable(folder / TABLE_NAME))
        subject, executor = _prepared(study, (*study.table.set, *settings), files_from, jobs, scheduler, fields)
        stack.callback(executor.close)
        study = study.with_si_units(subject.unit_of)
        progress = StudyProgress(study.table.name)
        stack.callback(progress.close)
        conductor = Conductor(
            study, subject, table, executor, progress, fields=fields, rehearses=scheduler is None
        )  # fmt: skip
        with side_by_side(partial(announce_compilation, study.table.name)):
            conductor.accept()
            if fields:
                table.want_fields_at(digest([(points.name, points.flat.tolist()) for points in subject.points]))
            _clear_other(folder, table, digest(study.table.model_dump(mode="json"), list(settings)))
            results = conductor.run()
        progress.close()
        write_study(folder, results)
        if fields:
            write_all_fields(folder, results, table, subject.points)
        # all is there before the best point is formed once more, which may fail, or be interrupted
        write_page(folder / FILE_NAME, results)
        if with_best and results.best is not None and (link := _form_best(study, results, subject, folder)):
            write_page(folder / FILE_NAME, results, best=link)
    return results


def _forget_empty(path: Path) -> None:
    """Remove a new table in which no run is: the study was refused."""
    from ..study.table import RunTable

    with RunTable(path) as table:
        empty = not table.run_count()
    if empty:
        for each in path.parent.glob(f"{path.name}*"):
            each.unlink()


def _clear_other(folder: Path, table: RunTable, key: str) -> None:
    """Remove the results of another study in this folder, ``key`` telling them apart; its runs are kept."""
    from ..output.claim.remains import remove_results
    from ..study.material_points import FILE_NAME as FIELDS_NAME
    from ..study.page.page import FILE_NAME
    from ..study.record import SUMMARY_NAME
    from ..study.record import TABLE_NAME as RUNS_NAME

    before = table.about("study")
    if before is None and table.run_count():  # made by a version that did not say what its study was
        before = key
    if before == key:
        table.remark("study", key)
        return
    names = [name for name in (FILE_NAME, SUMMARY_NAME, RUNS_NAME, FIELDS_NAME) if (folder / name).exists()]
    for name in names:
        (folder / name).unlink()
    if (folder / BEST_FOLDER).is_dir():
        names.append(f"{BEST_FOLDER}/")
        for path in (folder / BEST_FOLDER, *filter(Path.is_dir, sorted((folder / BEST_FOLDER).iterdir()))):
            remove_results(path)  # of a scene with cases, each in its own folder
    if names:
        say(
            f"note: {', '.join(names)} in {folder} were of another study, or of this one as it was, and are replaced; "
            "runs are kept"
        )
    table.remark("study", key)


def _prepared(
    study: Study,
    settings: Sequence[str],
    files_from: Sequence[Path],
    jobs: int | None,
    scheduler: str | None,
    fields: bool,
) -> tuple[JobSubject, Executor]:
    from ..device import available_threads
    from ..study.execution.cluster import ClusterExecutor
    from ..study.execution.executor import HereExecutor
    from ..study.execution.processes import ProcessExecutor
    from ..study.execution.together import TogetherExecutor
    from ..study.job_subject import JobSubject
    from ..study.schema import NoiseTable

    subject = JobSubject(
        study.job, tuple(settings), tuple(files_from), study.table.noise or NoiseTable(), study.table.limits
    )
    file = subject.file([])
    if fields:
        subject = subject.with_common_points(study.table.field_points)
    if scheduler is not None:
        # its workers have as many threads as their own machine allows
        return subject, ClusterExecutor(scheduler, study.table.retries)
    cores = available_threads()
    if file.job.solver.device != "cpu" and jobs is None:
        return subject, TogetherExecutor()
    width = jobs or cores
    subject = subject.with_threads(max(1, cores // width))
    return subject, HereExecutor() if width == 1 else ProcessExecutor(width, study.table.retries)


def _form_best(study: Study, results: StudyResults, subject: JobSubject, folder: Path) -> str:
    """Form the best point with its report; returns the link to it."""
    from ..study.measures import flattened
    from .ending import case_folders
    from .jobs.form import run_job

    point = results.best
    assert point is not None
    values = point.answers[0].trial.values
    own = [text for factor, value in zip(study.factors, values, strict=True) for text in factor.settings(value)]
    file = subject.file(own)
    if file.job.output.write is None and file.job.output.without is None:
        without = f"output.without={list(LEFT_OUT)}".replace("'", '"')
        file = subject.file([*own, without, "output.solver_fields=false"])
    say("The best point once more, with its report:", error=True)
    try:
        summary = run_job(file, folder / BEST_FOLDER, overwrite=True)
    except (InputError, RunError) as error:
        say(f"warning: its report could not be made: {error}", error=True)
        return ""
    found = flattened(summary)
    for measure in results.measures:
        key = results.key(measure)
        if key in found and found[key] != point.answers[0].numbers.get(key):
            say(f"warning: {key} is {found[key]!r} now and was {point.answers[0].numbers.get(key)!r} in the study",
                error=True)  # fmt: skip
    reports = [path / "report.html" for path in case_folders(summary, folder / BEST_FOLDER)]
    return next((path.relative_to(folder).as_posix() for path in reports if path.is_file()), "")


def closing_lines(results: StudyResults, folder: Path) -> list[str]:
    """What a user is told at the end."""
    from ..output.report.page import shown

    finished = sum(answer.status == "finished" for answer in results.answers)
    lines = [
        f"{results.run_count} runs of {len(results.points)} points, {finished} of {len(results.answers)} finished; "
        f"{results.reused} were known before. Results are in {folder}."
    ]
    for measure in results.measures:
        _, values = results.measured(measure)
        noise = results.noise(measure)
        if values:
            text = f"{results.label(measure)}: {shown(min(values))} to {shown(max(values))}"
            lines.append(text + (f", noise ± {shown(noise.deviation)}" if noise else ""))
        for effect in results.effects(measure):
            if effect.kind == "sobol" and effect.total is not None:
                lines.append(
                    f"  {effect.factor}: first {effect.value:.2f} ({effect.low:.2f} to {effect.high:.2f}), total "
                    f"{effect.total:.2f} ({effect.total_low:.2f} to {effect.total_high:.2f})"
                )
    lines += [f"note: {remark}" for remark in results.remarks()]
    if results.best is not None:
        pairs = zip(results.controlled, results.best.values, strict=True)
        lines.append(f"best: {', '.join(f'{factor.name} {factor.shown(value)}' for factor, value in pairs)}")
    return lines
