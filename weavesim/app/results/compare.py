"""``weavesim compare``: a run beside another run, a scan, or measured points."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...errors import InputError
from ...input_files import IN_COMMAND, units_given_as
from ..terminal import say

if TYPE_CHECKING:
    from ...output.stored.file import StoredRun, StoredSheet


def compare_command(
    first: Annotated[Path, typer.Argument(help="folder of a run", metavar="A")],
    second: Annotated[
        Path,
        typer.Argument(
            help="folder of another run, a scan (.stl, .ply, .obj), or a table of measured points (.csv)", metavar="B"
        ),
    ],
    unit: Annotated[
        str | None, typer.Option(help="of lengths in a scan or table, such as mm [default: its own]")
    ] = None,
    unit_scale: Annotated[float | None, typer.Option(help="metres per unit, in place of --unit")] = None,
    sheet: Annotated[str | None, typer.Option(help="sheet that was measured [default: all]")] = None,
    out: Annotated[Path | None, typer.Option(help="folder for the files [default: A]")] = None,
) -> None:
    """Compare a run with another one, a scan or measured points, on the same material (docs/outputs.md)."""
    from ...output.comparison.points import TABLES
    from ...output.files import check_writable
    from ...output.stored.file import read_results

    run = read_results(first)
    scale = _scale(unit, unit_scale)
    names = [each.name for each in run.sheets]
    if sheet is not None and sheet not in names:
        raise InputError(f"compare: sheet {sheet!r}: {first} has {', '.join(names)}")
    chosen = [each for each in run.sheets if sheet in (None, each.name)]
    if second.is_dir() and (sheet is not None or scale is not None):
        raise InputError("compare: --sheet and --unit are for scans and measured points; leave them out for two runs")
    if second.is_dir():
        found = _with_run(run, second)
    elif second.suffix.lower() in TABLES:
        found = _with_points(chosen, second, scale)
    else:
        found = _with_scan(chosen, second, scale)
    folder = first if out is None else out
    check_writable(folder)
    for place, (numbers, write) in enumerate(found):
        for line in _lines(numbers):
            say(line)
        files = write(folder, "" if len(found) == 1 else f"_{place}")
        say(f"wrote {', '.join(file.name for file in files)} to {folder}")


# Numbers of a comparison, and what writes its files into a folder, with an ending of their names.
_Found = tuple[dict[str, Any], Callable[[Path, str], list[Path]]]


def _scale(unit: str | None, unit_scale: float | None) -> float | None:
    """Metres per unit."""
    from ...job.units import unit_option
    from ...ranges import argument

    if unit is not None and unit_scale is not None:
        raise InputError("compare: --unit and --unit-scale: one of them is needed, both are given")
    if unit_scale is not None:
        return argument("unit_scale", unit_scale, "unit scale")
    return unit_option("compare: unit", unit)


def _with_run(run: StoredRun, folder: Path) -> list[_Found]:
    from ...output.comparison.runs import compare_sheets, write_comparison
    from ...output.stored.file import read_results

    other = read_results(folder)
    if len(other.sheets) != len(run.sheets):
        raise InputError(f"compare: {run.folder} has {len(run.sheets)} sheets, {folder} has {len(other.sheets)}")
    pairs = paired(run, other)
    found = (compare_sheets(own, each, f"{folder.name or folder} {each.name}") for own, each in pairs)
    return [(each.numbers(), partial(_write, write_comparison, each)) for each in found]


def paired(run: StoredRun, other: StoredRun) -> list[tuple[StoredSheet, StoredSheet]]:
    """Sheets of two runs with as many each, by their names; by their places, which is told, where these differ."""
    names, theirs = ([sheet.name for sheet in each.sheets] for each in (run, other))
    if set(names) == set(theirs):
        return [(own, other.sheets[theirs.index(own.name)]) for own in run.sheets]
    for own, each in zip(names, theirs, strict=True):
        if own != each:
            say(f"note: {own} is compared with {each}, by their places in the runs")
    return list(zip(run.sheets, other.sheets, strict=True))


def _with_points(sheets: Sequence[StoredSheet], path: Path, scale: float | None) -> list[_Found]:
    from ...output.comparison.points import compare_points, read_points, write_point_comparison

    points = read_points(path, metres_per_unit=scale)
    for note in points.notes:
        say(f"note: {note}")
    found = [compare_points(sheet, points) for sheet in sheets]
    for note in dict.fromkeys(note for each in found for note in each.notes):
        say(f"note: {note}")
    return [(each.numbers(), partial(_write, write_point_comparison, each)) for each in found]


@units_given_as(IN_COMMAND)
def _with_scan(sheets: Sequence[StoredSheet], path: Path, scale: float | None) -> list[_Found]:
    from ...output.comparison.runs import compare_scan, write_comparison

    found = [compare_scan(sheet, path, scale) for sheet in sheets]
    return [(each.numbers(), partial(_write, write_comparison, each)) for each in found]


def _write(write: Callable[[Path, Any, str], list[Path]], found: Any, folder: Path, ending: str) -> list[Path]:
    return write(folder, found, ending)


def _lines(numbers: dict[str, Any]) -> Iterator[str]:
    """What a user is told: every difference."""
    from ...output.comparison.fields import titled

    for key, entry in numbers.items():
        if isinstance(entry, dict) and "mean_absolute" in entry:
            whole = f"{numbers['point_count']} points" if "point_count" in numbers else "the sheet"
            yield (
                f"{numbers['sheet']}: {titled(key)} {entry['mean_absolute']:.3g} on average, at most "
                f"{entry['largest_absolute']:.3g}, over {entry['compared_share']:.0%} of {whole}"
            )
