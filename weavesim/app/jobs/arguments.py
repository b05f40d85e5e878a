"""Arguments that several commands share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from ...errors import InputError

JobPath = Annotated[Path, typer.Argument(help="a job file, .toml or .json", metavar="JOB")]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", help="a value beside the file, such as tools.ring.force=600; may be repeated", metavar="KEY=VALUE"
    ),
]
FilesFrom = Annotated[
    list[Path] | None,
    typer.Option(help="a folder outside the job's own that the job may read files from; may be repeated"),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="replace the results of an earlier run in that folder")]


@contextmanager
def asked_of_a_job(*, sets: bool = True) -> Iterator[None]:
    """Have a question about an unusual value answered where a job answers it: its commands have no option for that.

    Args:
        sets: whether the command has ``--set``.
    """
    from ...ranges import ACCEPTING, ACCEPTING_IN_JOB

    try:
        yield
    except InputError as error:
        answer = ACCEPTING_IN_JOB
        if sets:
            answer = f"{answer.removesuffix('.')}, or --set accept_unusual=true."
        told = str(error).replace(ACCEPTING_IN_JOB, answer).replace(ACCEPTING, answer)
        if told == str(error):
            raise
        raise InputError(told) from None
