"""``weavesim check``: everything that can be known of a job before it runs."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...errors import InputError
from ..session import announced, interruptible
from ..terminal import say
from .arguments import FilesFrom, JobPath, Settings, asked_of_a_job

if TYPE_CHECKING:
    from ...engine.setup import Setup
    from ...job.read import JobFile

WIDTH = 120
SUFFIXES = (".png", ".svg", ".pdf")


def check_command(
    job: JobPath,
    set_: Settings = None,
    picture: Annotated[
        Path | None, typer.Option(help="file for the picture, .png, .svg or .pdf [default: beside the job file]")
    ] = None,
    files_from: FilesFrom = None,
) -> None:
    """Say what can be known of a job before it runs: radii, gaps, speeds, time and memory; and draw it."""
    from ...job.check import LOOK, check_setup, table_of
    from ...job.read import read_job
    from ...output.files import check_writable
    from ...output.pictures.before import before_run
    from ...output.pictures.style import write_picture
    from ...output.writer import chosen_writers
    from ...run.scaling.mass import FACTORS

    with asked_of_a_job():
        file = read_job(job, set_ or (), files_from or ())
    if picture is not None and picture.suffix.lower() not in SUFFIXES:
        raise InputError(f"--picture {picture}: a file that ends in {' or '.join(SUFFIXES)} is needed")
    check_writable((picture or job).parent)
    chosen_writers(file.job.output.write, file.job.output.without or ())
    with interruptible(), announced(), asked_of_a_job():
        for case, setup in setups_of(file).items():
            name = "_".join(filter(None, (job.stem, "check", case)))
            path = picture or job.with_name(f"{name}.png")
            # first, since it shows what is wrong with a run that is refused
            write_picture(before_run(setup), path)
            say(f"Picture: {path}")
            checked = check_setup(setup)
            if any(row.what == "error of distance" and row.judgement == LOOK for row in checked.rows):
                write_picture(before_run(setup, with_errors=True), path)
            say(f"{file.job.name}{f', {case}' if case else ''}")
            say(table_of(checked.rows, shutil.get_terminal_size((WIDTH, 24)).columns))
            if file.job.solver.mass_scaling_angle is not None or file.job.solver.mass_scaling_draw_in is not None:
                say(
                    "Before it, weavesim form looks for the largest mass scaling that keeps the tolerances of "
                    f"[solver]: up to {len(FACTORS) + 1} runs on elements 1.5 times as large, about as long as one run."
                )
            count = sum(row.judgement == "look" for row in checked.rows)
            say(
                f'Look at {count} line{"s" if count != 1 else ""} marked "look" before you run it.'
                if count
                else "Nothing speaks against running it."
            )


def setups_of(file: JobFile) -> dict[str, Setup]:
    """The set-ups of a job by case; the case of a single run is ""."""
    from ...job.build import setup_of
    from ...job.scenes import scene_of

    if file.job.scene is None:
        return {"": setup_of(file)}
    scene, parameters = scene_of(file, out=file.path.parent / "out")
    return scene.setups(parameters)
