"""``weavesim verdict``: a finished run against the limits of its user; the same for ``--strict``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..ending import ExitCode, case_folders
from ..terminal import say

if TYPE_CHECKING:
    from ...measures.defects.judgement import Limits


def verdict_command(
    run: Annotated[Path, typer.Argument(help="folder of a run, its --out", metavar="OUT")],
    limits: Annotated[Path | None, typer.Option(help="TOML file of limits [default: built in]")] = None,
    out: Annotated[Path | None, typer.Option(help="folder for verdict.json, .csv and .png [default: OUT]")] = None,
) -> None:
    """Judge a run by limits: wrinkles, bridging, locking, gap, with their places; exit code 5 beyond one."""
    from ...output.stored.judged import read_limits

    passed, lines = judge_folder(run, read_limits(limits), out)
    for line in lines:
        say(line)
    if not passed:
        raise typer.Exit(int(ExitCode.BEYOND_LIMITS))


def judge_folder(run: Path, limits: Limits, out: Path | None = None) -> tuple[bool, list[str]]:
    """Judge the run of a folder and write the verdict there, or to ``out``.

    Returns:
        Whether it is within all limits, and what the user is told.

    Raises:
        InputError: no run, or its results cannot be read.
    """
    from ...output.files import check_writable
    from ...output.stored.file import read_results
    from ...output.stored.judged import judge_run, write_judged

    judged = judge_run(read_results(run), limits)
    folder = run if out is None else out
    check_writable(folder)
    files = write_judged(folder, judged)
    return judged.passed, [*judged.lines(), f"wrote {', '.join(file.name for file in files)} to {folder}"]


def strict_code(result: Mapping[str, Any], out: Path, limits: Limits) -> int:
    """Judge every run of a result and say so; exit code for ``--strict`` when nothing else is wrong.

    Args:
        result: a summary, or the summaries by case.
        out: folder of the run, or of its cases.
        limits: that all runs have to keep.
    """
    return max((_judged(folder, limits) for folder in case_folders(result, out)), default=0)


def _judged(folder: Path, limits: Limits) -> int:
    passed, lines = judge_folder(folder, limits)
    for line in _indented(lines):
        say(line)
    return 0 if passed else int(ExitCode.BEYOND_LIMITS)


def _indented(lines: list[str]) -> Iterator[str]:
    yield f"Verdict: {lines[0]}"
    yield from lines[1:]
