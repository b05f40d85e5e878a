"""``weavesim fabric``: which fabrics there are, what is known of one, and a copy of it to change."""

from __future__ import annotations

import math
import os
import sys
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from ..errors import InputError
from .ending import ExitCode
from .terminal import say

if TYPE_CHECKING:
    from ..fabric.fabric import Fabric

fabric_application = typer.Typer(
    help="Fabrics: which there are, what is known of one, and a copy of it to change.",
    add_completion=False,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
# Of a terminal that is none, such as a file.
WIDTH, LEAST_WIDTH = 160, 60
Name = Annotated[str, typer.Argument(help="a preset, a file in your own folder by its name, or a .toml or .json file")]
Unusual = Annotated[bool, typer.Option("--accept-unusual", help="take unusual values as meant")]


@fabric_application.command("list")
def list_command() -> None:
    """List the presets, and the fabrics in your own folder."""
    from ..fabric.file import load_fabric
    from ..fabric.presets import PRESETS
    from ..fabric.presets.folder import VARIABLE, fabric_folder, kept_files, shadows
    from ..input_files import shown

    say("Presets:")
    for name, make in PRESETS.items():
        fabric = make()
        same = next((other for other, first in PRESETS.items() if first is make and other != name), "")
        alias = f" (the same as {same})" if same and list(PRESETS).index(same) < list(PRESETS).index(name) else ""
        say(f"  {name:32} {fabric.name}{alias}")
    files = kept_files()
    say(f"\nYour own folder, {shown(fabric_folder())} ({VARIABLE} names another):" + ("" if files else " no fabrics"))
    hidden, is_damaged = {path.stem for path in shadows().values()}, False
    for name, paths in files.items():
        for path in paths:
            problem = "this is the name of a preset: rename the file" if name in hidden else ""
            problem = problem or ("there are several files of this name: rename one" if len(paths) > 1 else "")
            try:
                text = load_fabric(path).name
            except InputError as error:
                text, problem = f"cannot be used: {error}", problem or "damaged"
            say(f"  {shown(path.name):32} {text}" + (f" ({problem})" if problem and problem != "damaged" else ""))
            is_damaged |= bool(problem)
    if is_damaged:
        raise typer.Exit(int(ExitCode.INPUT_ERROR))


@fabric_application.command("show")
def show_command(
    name: Name,
    out: Annotated[
        Path | None, typer.Option(help="draw the curves into this folder, and write the table there")
    ] = None,
    picture: Annotated[Literal["png", "svg"], typer.Option(help="format of the picture")] = "png",
    accept_unusual: Unusual = False,
) -> None:
    """Show every number of a fabric: unit, meaning, source, trusted range, and whether it is assumed."""
    from ..fabric.file import resolve_fabric

    fabric = resolve_fabric(name, accept_unusual=accept_unusual)
    text = _description(fabric, _width())
    say(text)
    if out is not None:
        for path in _drawn(fabric, Path(name).stem, out, picture):
            say(f"wrote {path}")


@fabric_application.command("copy")
def copy_command(
    name: Name,
    file: Annotated[Path, typer.Argument(help="a .toml or .json file that does not exist yet")],
    accept_unusual: Unusual = False,
) -> None:
    """Write all values of a fabric, with where they come from, to a file of your own."""
    from ..fabric.file import resolve_fabric
    from ..fabric.presets.folder import SUFFIXES
    from ..input_files import shown

    if file.suffix.lower() not in SUFFIXES:
        raise InputError(f"file {shown(file)}: its name must end in .toml or .json")
    fabric = resolve_fabric(name, accept_unusual=accept_unusual)
    text = fabric.to_toml() if file.suffix.lower() == ".toml" else fabric.to_json() + "\n"
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("x", encoding="utf-8", newline="\n") as stream:
            stream.write(text)
    except FileExistsError:
        raise InputError(f"file {shown(file)}: it exists; give another name, or remove it first") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"file {shown(file)}: cannot be written ({reason})") from None
    say(f"wrote {file}")


def _width() -> int:
    """Columns of the terminal; of a file or a pipe, enough for one line per number."""
    try:
        columns = os.get_terminal_size(sys.stdout.fileno()).columns
    except (OSError, ValueError, AttributeError):
        columns = WIDTH
    given = os.environ.get("COLUMNS", "")
    return max(int(given) if given.isdigit() else columns, LEAST_WIDTH)


def _description(fabric: Fabric, width: int) -> str:
    from ..measures.fabric_table import fabric_table, summary_of

    lines = [fabric.name]
    lines += textwrap.wrap(f"source: {fabric.source or 'none given'}", width)
    if fabric.assumed and not fabric.provenance:  # which says it of each number
        lines += textwrap.wrap(f"assumed: {', '.join(fabric.assumed)}", width)
    lines += ["", fabric_table(fabric, width), "", summary_of(fabric)]
    return "\n".join([*lines, *(line for text in _unloading(fabric) for line in textwrap.wrap(text, width))])


def _unloading(fabric: Fabric) -> list[str]:
    """What is known of unloading in shear, and what this fabric does."""
    from ..fabric.shear import unloading_doubt
    from ..measures.fabric_curves import SHOWN_ANGLE, unloading_of

    if fabric.unit_cell.law().depends_on_shear:
        return []
    found = unloading_of(fabric, min(fabric.shear.trusted_angle or SHOWN_ANGLE, SHOWN_ANGLE))
    top = f"{math.degrees(found.angle):.3g}°"
    text = f"let go at {top} of shear it goes back to {math.degrees(found.residual_angle):.3g}°"
    text += f", and friction takes {found.lost_share:.0%} of the work"
    doubt = unloading_doubt(fabric)
    return [f"unloading: {text}" + (f" ({doubt})" if doubt else "")]


def _drawn(fabric: Fabric, name: str, out: Path, picture: str) -> list[Path]:
    """Write the picture of the curves, and the table; returns the files."""
    from ..measures.fabric_curves import curves_of
    from ..output.files import check_writable, write_text
    from ..output.pictures.fabric_curves import fabric_curves
    from ..output.pictures.style import write_picture

    check_writable(out)
    files = [out / f"{name}.{picture}", out / f"{name}.txt"]
    write_picture(fabric_curves(fabric.name, curves_of(fabric)), files[0])
    write_text(files[1], _description(fabric, WIDTH) + "\n")
    return files
