"""``weavesim export``: the end of a run in the formats of other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..terminal import say


def export_command(
    run: Annotated[Path, typer.Argument(help="folder of a run, its --out", metavar="OUT")],
    to: Annotated[
        str,
        typer.Option(
            help="formats, comma-separated: calculix, abaqus, lsdyna, nastran, openradioss, vtkhdf, hdf5, csv"
        ),
    ],
    map_onto: Annotated[
        Path | None,
        typer.Option(
            "--map", help="shell mesh that gets the plies, such as part.inp; its unit is --unit [default: own mesh]"
        ),
    ] = None,
    unit: Annotated[str, typer.Option(help='of the files: "m" (m, N, Pa) or "mm" (mm, N, t, MPa)')] = "m",
    whole: Annotated[bool, typer.Option("--whole", help="add the mirrored copies of a sheet cut at symmetry")] = False,
    yarns: Annotated[
        int, typer.Option(help="layers per ply: 2, warp and weft apart at half the thickness; 1, along the warp")
    ] = 2,
    lamina: Annotated[
        Path | None, typer.Option(help="TOML file of the elastic constants of a layer [default: assumed, and said so]")
    ] = None,
    within: Annotated[
        float | None, typer.Option(help="largest distance from the mesh to the formed sheet [m; default: 2 elements]")
    ] = None,
    reference: Annotated[
        tuple[float, float, float], typer.Option(help="direction from which OpenRadioss counts angles")
    ] = (1.0, 0.0, 0.0),
    out: Annotated[Path | None, typer.Option(help="folder for the files [default: OUT/export]")] = None,
) -> None:
    """Write the end of a run for other programs: fibre directions, thickness, layers (docs/outputs.md)."""
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
