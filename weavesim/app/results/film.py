"""``weavesim film``: a movie of a run, in the colours of any field."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..terminal import say


def film_command(
    run: Annotated[Path, typer.Argument(help="folder of a run, its --out", metavar="OUT")],
    field: Annotated[
        str, typer.Option(help="of the elements: shear_angle, thickness, warp_stretch ...; a wrong one lists all")
    ] = "shear_angle",
    mirror: Annotated[bool, typer.Option("--mirror/--no-mirror", help="the whole part, or what was computed")] = True,
    tools: Annotated[bool, typer.Option("--tools/--no-tools", help="with or without tools")] = True,
    back: Annotated[bool, typer.Option("--back", help="look at the other side")] = False,
    fps: Annotated[float, typer.Option(help="frames of the run per second of the movie")] = 24.0,
    size: Annotated[tuple[int, int], typer.Option(help="width and height in pixels")] = (1280, 720),
    limits: Annotated[
        tuple[float, float] | None,
        typer.Option("--range", help="ends of the scale, in SI units or degrees [default: from all frames]"),
    ] = None,
    mp4: Annotated[bool, typer.Option("--mp4/--no-mp4", help="write a movie")] = True,
    png: Annotated[bool, typer.Option("--png", help="write a picture of every frame")] = False,
    out: Annotated[Path | None, typer.Option(help="folder for the files [default: OUT]")] = None,
) -> None:
    """Draw a run as a movie, or as pictures, from its film (pip install "weavesim[film]"; docs/outputs.md)."""
    from ...errors import InputError
    from ...output.files import check_writable
    from ...output.film.movie import Movie, field_of, write_mp4, write_pictures
    from ...output.film.reading import StoredFilm
    from ..jobs.folders import read_record

    if not mp4 and not png:
        raise InputError("film: nothing to write; give --mp4, --png, or both")
    movie = Movie(field, mirror, tools, back, size, fps, limits)
    name = str(read_record(run).get("name", "run"))
    film = StoredFilm(run / f"{name}.usdc")
    stem = f"{name}_{field_of(film, field).name.removesuffix('_deg')}"
    folder = run if out is None else out
    check_writable(folder)
    seconds = len(film.frames) / fps
    if mp4:
        write_mp4(film, movie, folder / f"{stem}.mp4")
        say(f"wrote {folder / stem}.mp4: {len(film.frames)} frames, {seconds:.3g} s")
    if png:
        files = write_pictures(film, movie, folder / stem)
        say(f"wrote {len(files)} pictures to {folder / stem}")
