"""``weavesim form``: run a job."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...errors import InputError
from ..ending import ExitCode, closing_lines, exit_code
from ..session import announce_compilation, announced, interruptible, uncollected
from ..terminal import say
from .arguments import FilesFrom, JobPath, Overwrite, Settings, asked_of_a_job

if TYPE_CHECKING:
    from ...job.read import JobFile


def form_command(
    job: JobPath,
    set_: Settings = None,
    out: Annotated[Path | None, typer.Option(help="folder for the results [default: out, beside the job file]")] = None,
    files_from: FilesFrom = None,
    overwrite: Overwrite = False,
    strict: Annotated[
        bool, typer.Option("--strict", help="judge the part by limits at the end: exit code 5 beyond one")
    ] = False,
    limits: Annotated[Path | None, typer.Option(help="TOML file of these limits [default: built in]")] = None,
    stop_on: Annotated[
        list[str] | None, typer.Option(help="a guard that ends the run, as stop_on of [output]; may be repeated")
    ] = None,
) -> None:
    """Run a job: form its plies, and write the results to a folder."""
    from ...engine.compilation import side_by_side
    from ...job.read import read_job
    from ...output.stored.judged import read_limits
    from ...output.writer import chosen_writers
    from ...tools.samples.stored import samples_stored
    from ..results.verdict import strict_code

    settings = [*(set_ or ()), *([f"output.stop_on={json.dumps(stop_on)}"] if stop_on else [])]
    with asked_of_a_job():
        file = read_job(job, settings, files_from or ())
    folder = out or job.parent / "out"
    if limits is not None and not strict:
        raise InputError("--limits: has no effect without --strict; leave it out")
    output = file.job.output
    writers = [kind.name for kind in chosen_writers(output.write, output.without or ())]
    if strict and "results" not in writers:
        raise InputError("--strict: needs the results file; let [output] write results")
    wanted = read_limits(limits) if strict else None
    with (
        uncollected(),  # up to the run
        interruptible() as interrupted,
        side_by_side(partial(announce_compilation, file.job.name)),
        samples_stored(),
        announced(),
        asked_of_a_job(),
    ):
        result = run_job(file, folder, overwrite=overwrite, limits=limits)
        number = interrupted.signal
        for line in closing_lines(result, folder, number):
            say(line)
        code = exit_code(result, number)
        if wanted is not None and code in (ExitCode.FINISHED, ExitCode.DO_NOT_USE):
            # what should not be used is judged and told too, but that it should not be used comes first
            judged = strict_code(result, folder, wanted)
            code = code or judged
    if code:
        raise typer.Exit(code)


def run_job(file: JobFile, out: Path, *, overwrite: bool = False, limits: Path | None = None) -> Mapping[str, Any]:
    """Run a job into a folder.

    Args:
        file: the job.
        out: the folder.
        overwrite: replace results that are there.
        limits: file of the limits by which the report judges the part; None for those that are built in.

    Returns:
        The summary as written; of a scene with cases, the summaries by case.

    Raises:
        InputError: bad input, before anything runs.
        RunError: the run had to stop; results up to its last good frame are written first.
    """
    from ...job.scaling import scaled_setup_of
    from ...job.scenes import scene_of
    from ...output import ResultFolder
    from ...output.writer import chosen_writers
    from ..run_into_folder import run_into_folder

    if file.job.scene is not None:
        scene, parameters = scene_of(file, out=out, overwrite=overwrite, limits=limits)
        return scene.run(parameters)
    output = file.job.output
    writers = tuple(kind.name for kind in chosen_writers(output.write, output.without or ()))
    if output.solver_fields and "paraview" not in writers:
        file.refuse(
            ["output", "solver_fields"], "solver_fields: has no effect without the results paraview; leave it out"
        )
    options = options_of(file)
    if limits is not None:
        options["limits"] = str(limits.absolute())
    how: dict[str, Any] = {"overwrite": overwrite, "options": options, "solver_fields": output.solver_fields}
    folder = ResultFolder(out, writers=writers, **how)
    with ExitStack() as stack:
        stack.callback(folder.release)
        setup = scaled_setup_of(file, before=folder.claim)
        return run_into_folder(
            setup, folder, options=options, checkpoint_interval=output.checkpoint_interval, stop_on=output.stop_on,
            reads_frames=False,
        )  # fmt: skip


def options_of(file: JobFile) -> dict[str, Any]:
    """What a job says, by dotted keys, for the record of the run and its report."""
    found: dict[str, Any] = {"job": str(file.path.absolute())}

    def enter(keys: tuple[str, ...], value: Any) -> None:
        if isinstance(value, Mapping):
            for key, item in value.items():
                enter((*keys, str(key)), item)
        elif isinstance(value, list) and value and all(isinstance(item, Mapping) for item in value):
            for index, item in enumerate(value):
                enter((*keys, str(item.get("name", index))), item)
        elif keys[-1] in ("file", "outline") and isinstance(value, str):
            found[".".join(keys)] = str(file.file(value, keys).absolute())
        else:
            found[".".join(keys)] = value

    for key, value in file.values.items():
        enter((key,), value)
    return found
