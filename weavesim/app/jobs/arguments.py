"""Arguments that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

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
