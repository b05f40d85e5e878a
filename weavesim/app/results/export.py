"""``weavesim export``: the end of a run in the formats of other programs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from ...errors import InputError
from ...input_files import IN_COMMAND, OF_EDGE_IN_COMMAND, units_given_as
from ..terminal import say


def export_command(
    run: Annotated[Path, typer.Argument(help="folder of a run, its --out", metavar="OUT")],
    to: Annotated[
        str,
        typer.Option(
            help="formats, comma-separated: calculix, abaqus, lsdyna, nastran, openradioss, vtkhdf, hdf5, csv"
        ),
    ] = "",
    map_onto: Annotated[
        Path | None,
        typer.Option(
            "--map", help="shell mesh that gets the plies, such as part.inp; its unit is --unit [default: own mesh]"
        ),
    ] = None,
    unit: Annotated[
        str | None,
        typer.Option(help='of the decks: "m" (m, N, Pa) or "mm" (mm, N, t, MPa), and of centres in csv [default: m]'),
    ] = None,
    whole: Annotated[bool, typer.Option("--whole", help="add the mirrored copies of a sheet cut at symmetry")] = False,
    yarns: Annotated[
        int | None,
        typer.Option(
            help="layers per ply: 2, warp and weft apart at half the thickness; 1, along the warp [default: 2]"
        ),
    ] = None,
    lamina: Annotated[
        Path | None, typer.Option(help="TOML file of the elastic constants of a layer [default: assumed, and said so]")
    ] = None,
    within: Annotated[
        float | None, typer.Option(help="largest distance from the mesh to the formed sheet [m; default: 2 elements]")
    ] = None,
    reference: Annotated[
        tuple[float, float, float] | None,
        typer.Option(help="direction from which OpenRadioss counts angles [default: x]"),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="folder for the files [default: OUT/export]")] = None,
    flat: Annotated[
        Path | None, typer.Option(help="DXF drawing of the flat blanks, with trim line and yarns, to write")
    ] = None,
    trim: Annotated[Path | None, typer.Option(help="DXF drawing of what becomes the part, to write")] = None,
    part_edge: Annotated[
        Path | None,
        typer.Option(help="edge of the part, a closed curve on the tools: .dxf, .csv, or the border of a mesh"),
    ] = None,
    edge_unit: Annotated[
        str | None, typer.Option(help="unit of the edge's file, such as mm [default: its own]")
    ] = None,
    edge_layer: Annotated[str | None, typer.Option(help="layer of the edge's drawing [default: all]")] = None,
    opening: Annotated[
        str | None, typer.Option(help="tool whose opening is the part's edge, in place of a file")
    ] = None,
) -> None:
    """Write the end of a run for other programs: fibre directions, thickness, flat pattern (docs/outputs.md)."""
    if not to and flat is None and trim is None and part_edge is None and opening is None:
        raise InputError("export: nothing to write; give formats (--to csv), or a drawing (--flat FILE, --trim FILE)")
    if not to:
        given = {"--map": map_onto is not None, "--unit": unit is not None, "--whole": whole,
                 "--yarns": yarns is not None, "--lamina": lamina is not None, "--within": within is not None,
                 "--reference": reference is not None, "--out": out is not None}  # fmt: skip
        if extra := [option for option, is_given in given.items() if is_given]:
            raise InputError(f"{', '.join(extra)}: no effect without formats (--to csv); leave it out")
    _tell_verdict(run)
    drawings = _drawings(run, flat, trim, part_edge, edge_unit, edge_layer, opening)
    if to:
        axis = (1.0, 0.0, 0.0) if reference is None else reference
        _formats(run, to, map_onto, unit or "m", whole, 2 if yarns is None else yarns, lamina, within, axis, out)
    drawings()


def _tell_verdict(run: Path) -> None:
    """Say of a run that should not be used that it should not, before its numbers go elsewhere."""
    from ..jobs.folders import read_summary

    if (verdict := read_summary(run).get("verdict")) == "do not use":
        say(f'note: the verdict of this run is "{verdict}"; weavesim view {run} tells why')


@units_given_as(OF_EDGE_IN_COMMAND)
def _drawings(
    run: Path,
    flat: Path | None,
    trim: Path | None,
    part_edge: Path | None,
    edge_unit: str | None,
    edge_layer: str | None,
    opening: str | None,
) -> Callable[[], None]:
    """Finds the flat patterns, so that all input is checked, and returns what writes them."""
    from ...job.units import unit_option
    from ...output.flat.pattern import FlatWish, flat_patterns, write_flat
    from ...output.stored.file import read_results

    scale = unit_option("edge unit", edge_unit)
    if part_edge is None and (edge_unit is not None or edge_layer is not None):
        raise InputError("edge unit and edge layer: they have an effect only with --part-edge; leave them out")
    wish = FlatWish(flat, trim, part_edge, edge_layer, scale, opening)
    if flat is None and trim is None:
        return lambda: None
    found = flat_patterns(read_results(run), wish)

    def write() -> None:
        for path in write_flat(found, wish):
            say(f"wrote {path}")
        for line in (*found.lines(), *(f"note: {note}" for note in (found.edge.notes if found.edge else ()))):
            say(line)

    return write


@units_given_as(IN_COMMAND)
def _formats(
    run: Path,
    to: str,
    map_onto: Path | None,
    unit: str,
    whole: bool,
    yarns: int,
    lamina: Path | None,
    within: float | None,
    reference: tuple[float, float, float],
    out: Path | None,
) -> None:
    from ...output.export.exporting import Export, export_run
    from ...output.export.lamina import Lamina
    from ...output.stored.file import read_results

    wish = Export(
        formats=[name.strip() for name in to.split(",") if name.strip()],
        folder=run / "export" if out is None else out,
        unit=unit,
        map_onto=map_onto,
        within=within,
        whole=whole,
        layers_per_ply=yarns,
        lamina=Lamina.from_file(lamina) if lamina else None,
        reference=reference,
    )
    done = export_run(read_results(run), wish)
    for path in done.files:
        say(f"wrote {path}")
    for note in done.notes:
        say(f"note: {note}")
