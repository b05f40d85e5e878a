"""``weavesim kinematic``: the drape of a net of inextensible yarns, alone or beside a run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...errors import InputError
from ..terminal import say


def kinematic_command(
    source: Annotated[Path, typer.Argument(help="folder of a run, or a job file", metavar="OUT|JOB")],
    tool: Annotated[str | None, typer.Option(help="tool for the net [default: the nearest at the seed]")] = None,
    seed: Annotated[
        tuple[float, float] | None, typer.Option(help="material point of the first crossing, x y [m] [default: 0 0]")
    ] = None,
    side: Annotated[float | None, typer.Option(help="distance of crossings [m] [default: size of an element]")] = None,
    out: Annotated[Path | None, typer.Option(help="folder for the files [default: OUT, or beside the job]")] = None,
) -> None:
    """Lay a net of inextensible yarns onto a tool, in seconds, and compare it with a run (docs/outputs.md)."""
    from ...output.files import check_writable

    folder = out or (source if source.is_dir() else source.parent)
    check_writable(folder)
    files, lines = (_of_run if source.is_dir() else _of_job)(source, folder, tool, seed, side)
    for line in lines:
        say(line)
    say(f"wrote {', '.join(file.name for file in files)} to {folder}")


_Answer = tuple[list[Path], list[str]]


def _of_run(
    source: Path, folder: Path, tool: str | None, seed: tuple[float, float] | None, side: float | None
) -> _Answer:
    from ...output.comparison.kinematic import beside_run, write_kinematic
    from ...output.stored.file import read_results

    run = read_results(source)
    files: list[Path] = []
    lines = []
    for place, sheet in enumerate(run.sheets):
        drape = beside_run(run, sheet, tool=tool, seed=seed, side=side)
        ending = "" if len(run.sheets) == 1 else f"_{place}"
        files += write_kinematic(folder, drape, run.run_id, ending)
        numbers = drape.numbers()
        lines.append(
            f"{sheet.name} on {drape.tool}: net up to {numbers['largest_net_angle_deg']:.1f} degrees, formed up to "
            f"{numbers['largest_formed_angle_deg']:.1f}"
        )
        if numbers["mean_absolute_difference_deg"] is not None:
            lines.append(
                "  where the sheet lies on the tool they differ by "
                f"{numbers['mean_absolute_difference_deg']:.1f} degrees on average, at most "
                f"{numbers['largest_difference_deg']:.1f}"
            )
    return files, lines


def _of_job(
    source: Path, folder: Path, tool: str | None, seed: tuple[float, float] | None, side: float | None
) -> _Answer:
    from ...job.build import setup_of
    from ...job.read import read_job
    from ...output.comparison.kinematic import of_flat_blank, write_kinematic

    file = read_job(source)
    if file.job.scene is not None:
        raise InputError(f"job {source}: it names a scene; run it, and give the folder of the run")
    setup = setup_of(file)
    names = [each.name for each in setup.tools]
    if tool is None and len(names) > 1:
        raise InputError(f"kinematic drape: give the tool with --tool: {', '.join(names)}")
    if tool is not None and tool not in names:
        raise InputError(f"kinematic drape: tool {tool!r}: choose from {', '.join(names) or 'none'}")
    if not names:
        raise InputError(f"job {source}: it has no tool to lie on")
    chosen = setup.tools[names.index(tool) if tool is not None else 0]
    sheet = setup.sheets[0]
    drape = of_flat_blank(sheet.oriented_blank, chosen, sheet.fabric.thickness, seed=seed, side=side)
    files = write_kinematic(folder, drape)
    return files, [f"{sheet.name} on {drape.tool}: net up to {drape.numbers()['largest_net_angle_deg']:.1f} degrees"]
