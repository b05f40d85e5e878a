"""``weavesim kinematic``: the drape of a net of inextensible yarns, alone or beside a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from ...errors import InputError
from ...input_files import OF_EDGE_IN_COMMAND, units_given_as
from ..jobs.arguments import asked_of_a_job
from ..terminal import say

if TYPE_CHECKING:
    from ...engine.setup import Setup
    from ...output.comparison.kinematic import KinematicDrape
    from ...sheet.sheet import Sheet


def kinematic_command(
    source: Annotated[Path, typer.Argument(help="folder of a run, or a job file", metavar="OUT|JOB")],
    tool: Annotated[str | None, typer.Option(help="tool for the net [default: the nearest at the seed]")] = None,
    seed: Annotated[
        tuple[float, float] | None, typer.Option(help="material point of the first crossing, x y [m] [default: 0 0]")
    ] = None,
    side: Annotated[float | None, typer.Option(help="distance of crossings [m] [default: size of an element]")] = None,
    out: Annotated[Path | None, typer.Option(help="folder for the files [default: OUT, or beside the job]")] = None,
    blank: Annotated[
        Path | None, typer.Option(help="DXF drawing of a first blank, to write: the part's edge on the net, of a job")
    ] = None,
    part_edge: Annotated[
        Path | None, typer.Option(help="edge of the part, a closed curve on the tool: .dxf, .csv, or border of a mesh")
    ] = None,
    edge_unit: Annotated[
        str | None, typer.Option(help="unit of the edge's file, such as mm [default: its own]")
    ] = None,
    opening: Annotated[
        str | None, typer.Option(help="tool whose opening is the part's edge, in place of a file")
    ] = None,
    margin: Annotated[float, typer.Option(help="of the first blank around the part [m]")] = 0.0,
) -> None:
    """Lay a net of inextensible yarns onto a tool, in seconds, and compare it with a run (docs/outputs.md)."""
    from ...output.files import check_writable

    wish = _blank_wish(source, blank, part_edge, edge_unit, opening, margin)
    folder = out or (source if source.is_dir() else source.parent)
    check_writable(folder)
    if source.is_dir():
        files, lines = _of_run(source, folder, tool, seed, side)
    else:
        with asked_of_a_job(sets=False):
            files, lines = _of_job(source, folder, tool, seed, side, wish)
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
        lines += _told(drape, sheet.name, f", formed up to {numbers['largest_formed_angle_deg']:.1f}")
        if numbers["mean_absolute_difference_deg"] is not None:
            lines.append(
                "  where the sheet lies on the tool they differ by "
                f"{numbers['mean_absolute_difference_deg']:.1f} degrees on average, at most "
                f"{numbers['largest_difference_deg']:.1f}"
            )
    return files, lines


def _told(drape: KinematicDrape, name: str, more: str = "") -> list[str]:
    """The largest angle of a net, how much it covers, and where it ends."""
    largest = drape.numbers()["largest_net_angle_deg"]
    angle = f"net up to {largest:.1f} degrees" if largest is not None else "no cell of the net is whole"
    lines = [f"{name} on {drape.tool}: {angle}{more}"]
    if drape.covered_share < 1.0 or drape.ends:
        lines.append(f"  the net covers {100.0 * drape.covered_share:.3g} % of {name}; it ends")
        lines += [f"  - where {end.text()}" for end in drape.ends]
    else:
        lines.append(f"  the net covers all of {name}")
    return lines


class _BlankWish(NamedTuple):
    """A first blank: the drawing, the edge of the part (its file and metres per unit, or a tool), the margin [m]."""

    path: Path
    part_edge: Path | None
    scale: float | None
    opening: str | None
    margin: float


def _blank_wish(
    source: Path, blank: Path | None, part_edge: Path | None, unit: str | None, opening: str | None, margin: float
) -> _BlankWish | None:
    from ...job.units import unit_option
    from ...output.files import check_writable
    from ...ranges import argument

    if blank is None:
        if part_edge is not None or opening is not None or unit is not None or margin:
            raise InputError("kinematic drape: the part's edge and its margin need a drawing to write (--blank FILE)")
        return None
    if source.is_dir():
        raise InputError(
            "kinematic drape: --blank is for a job; of a run, weavesim export --trim has the formed material"
        )
    if (part_edge is None) == (opening is None):
        raise InputError("kinematic drape: --blank needs the edge of the part: --part-edge FILE or --opening TOOL")
    if blank.suffix.lower() != ".dxf":
        raise InputError(f"drawing {blank}: a name that ends in .dxf is needed")
    # before the drape is computed
    check_writable(blank.parent)
    scale = unit_option("edge unit", unit)
    return _BlankWish(blank, part_edge, scale, opening, argument("margin", margin, "displacement", zero=True))


def _first_blank(wish: _BlankWish, setup: Setup, sheet: Sheet, drape: KinematicDrape) -> _Answer:
    """Write the first blank of a sheet."""
    from dataclasses import replace

    from ...output.flat.drawing import flat_drawing, write_drawing
    from ...output.flat.first_blank import pattern_of_net, with_margin
    from ...output.flat.part_edge import opening_of, read_part_edge

    if wish.part_edge is not None:
        with units_given_as(OF_EDGE_IN_COMMAND):
            edge = read_part_edge(wish.part_edge, metres_per_unit=wish.scale)
    else:
        names = [tool.name for tool in setup.tools]
        if wish.opening not in names:
            raise InputError(f"opening of {wish.opening}: there is no such tool; choose from {', '.join(names)}")
        edge = opening_of(setup.tools[names.index(wish.opening)], 0.0)
    blank, thickness = sheet.oriented_blank, sheet.fabric.thickness
    pattern = pattern_of_net(drape, blank, thickness, sheet.name, edge, setup.worlds[0].symmetry)
    assert pattern.trim is not None
    first = replace(pattern, blank=(with_margin(pattern.trim[0], wish.margin),))
    write_drawing(wish.path, flat_drawing([first]))
    line = (
        f"first blank of {sheet.name}: {1e4 * first.blank_area:.1f} cm2, of which {1e4 * (first.part_area or 0.0):.1f} "
        f"become the part by the net; layer {sheet.name} of {wish.path} is an outline for a job"
    )
    return [wish.path], [line]


def _of_job(
    source: Path,
    folder: Path,
    tool: str | None,
    seed: tuple[float, float] | None,
    side: float | None,
    wish: _BlankWish | None,
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
    lines = _told(drape, sheet.name)
    more, told = _first_blank(wish, setup, sheet, drape) if wish is not None else ([], [])
    return [*write_kinematic(folder, drape), *more], [*lines, *told]
