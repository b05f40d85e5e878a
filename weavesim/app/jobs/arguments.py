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
    from ...ranges import ACCEPTING

    try:
        yield
    except InputError as error:
        if ACCEPTING not in str(error):
            raise
        answer = "If this is meant, write accept_unusual = true at the top of the job"
        answer += ", or --set accept_unusual=true." if sets else "."
        raise InputError(str(error).replace(ACCEPTING, answer)) from None
