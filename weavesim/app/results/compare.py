"""``weavesim compare``: a run beside another run, or beside a scan."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...errors import InputError
from ..terminal import say


def compare_command(
    first: Annotated[Path, typer.Argument(help="folder of a run", metavar="A")],
    second: Annotated[Path, typer.Argument(help="folder of another run, or a scan: .stl, .ply, .obj", metavar="B")],
    unit_scale: Annotated[float, typer.Option(help="metres per unit of a scan")] = 1.0,
    out: Annotated[Path | None, typer.Option(help="folder for the files [default: A]")] = None,
) -> None:
    """Compare a run with another one or with a scan, at the same points of the flat blank (docs/outputs.md)."""
    from ...output.comparison.runs import compare_scan, compare_sheets, write_comparison
    from ...output.files import check_writable
    from ...output.stored.file import read_results
    from ...ranges import argument

    run = read_results(first)
    scale = argument("unit_scale", unit_scale, "unit scale")
    if second.is_dir():
        other = read_results(second)
        if len(other.sheets) != len(run.sheets):
            raise InputError(f"compare: {first} has {len(run.sheets)} sheets, {second} has {len(other.sheets)}")
        pairs = zip(run.sheets, other.sheets, strict=True)
        found = [compare_sheets(own, sheet, f"{second.name or second} {sheet.name}") for own, sheet in pairs]
    else:
        found = [compare_scan(sheet, second, scale) for sheet in run.sheets]
    folder = first if out is None else out
    check_writable(folder)
    for place, comparison in enumerate(found):
        numbers = comparison.numbers()
        names = {"distance_mm": "distance [mm]", "shear_angle_deg": "shear angle [degrees]"}
        for key, name in names.items():
            if (entry := numbers.get(key)) and "mean_absolute" in entry:
                say(
                    f"{comparison.sheet.name}: {name} {entry['mean_absolute']:.3g} on average, at most "
                    f"{entry['largest_absolute']:.3g}, over {entry['compared_share']:.0%} of the sheet"
                )
        files = write_comparison(folder, comparison, "" if len(found) == 1 else f"_{place}")
        say(f"wrote {', '.join(file.name for file in files)} to {folder}")
