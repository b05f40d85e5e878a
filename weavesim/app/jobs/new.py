"""``weavesim new``: a job for a tool of one's own."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from ...errors import InputError, did_you_mean
from ...input_files import IN_COMMAND, units_given_as
from ..terminal import say

# A gap of the closed tools over the thickness of the fabric, or the inverse; a stack may have many plies.
LARGEST_GAP_RATIO = 30.0
DEFAULT_FABRIC = "glass-polypropylene"
SCHEMA_NAME, JOB_NAME = "job.schema.json", "job.toml"


def new_command(
    name: Annotated[str, typer.Argument(help="of the job, and of the folder that it is written to")],
    die: Annotated[Path | None, typer.Option(help="surface of the die, a mesh or CAD file")] = None,
    punch: Annotated[Path | None, typer.Option(help="the punch, drawn closed [default: made from the die]")] = None,
    ring: Annotated[Path | None, typer.Option(help="the holder [default: made from the die's rim]")] = None,
    no_ring: Annotated[bool, typer.Option("--no-ring", help="without a holder")] = False,
    thickness: Annotated[
        str | None,
        typer.Option(help="gap between the closed tools, in mm or with a unit [default: of the fabric]"),
    ] = None,
    fabric: Annotated[
        str | None, typer.Option(help=f"a preset, or a file, which is copied [default: {DEFAULT_FABRIC}]")
    ] = None,
    unit: Annotated[str | None, typer.Option(help="of the files: mm, inch, m [default: from the size]")] = None,
    up: Annotated[
        str | None, typer.Option(help="direction in the files from die to punch: +z, -y, ... [default: found]")
    ] = None,
    mesh_size: Annotated[str | None, typer.Option(help="edge of an element, in mm or with a unit")] = None,
    scene: Annotated[str | None, typer.Option(help="write a job of this scene, with all its options")] = None,
    into: Annotated[Path | None, typer.Option(help="folder that is made [default: the name]")] = None,
) -> None:
    """Write a commented job for a die of your own, or for a scene."""
    from ...names import file_name

    file_name("name of the job", name)
    folder = into or Path(name)
    if (scene is None) == (die is None):
        raise InputError("give --die FILE for a tool of your own, or --scene NAME for a scene")
    if scene is not None:
        given = {"--punch": punch, "--ring": ring, "--no-ring": no_ring or None, "--thickness": thickness,
                 "--fabric": fabric, "--unit": unit, "--up": up, "--mesh-size": mesh_size}  # fmt: skip
        if extra := [option for option, value in given.items() if value is not None]:
            raise InputError(f"{', '.join(extra)}: no effect with --scene; set the options of the scene in the job")
        text = scene_text(scene)
        _write(folder, text, ())
    else:
        assert die is not None
        if no_ring and ring is not None:
            raise InputError("--ring and --no-ring: give one of them")
        text, own = _tool_text(
            name, die, punch, ring, not no_ring, thickness, fabric or DEFAULT_FABRIC, unit, up, mesh_size
        )
        tables = () if own is None else tables_of(own)
        _write(folder, text, tuple(path for path in (die, punch, ring, own, *tables) if path is not None))
    for line in text.split("\n"):
        if line.startswith("# "):
            say(line[2:])
    say(f"wrote {folder / JOB_NAME}; next: weavesim check {folder / JOB_NAME}")


@units_given_as(IN_COMMAND)
def _tool_text(
    name: str,
    die: Path,
    punch: Path | None,
    ring: Path | None,
    with_ring: bool,
    thickness: str | None,
    fabric: str,
    unit: str | None,
    up: str | None,
    mesh_size: str | None,
) -> tuple[str, Path | None]:
    """The text of the job, and the file of its fabric if that is no preset."""
    from ...fabric.file import resolve_fabric
    from ...fabric.presets.folder import SUFFIXES
    from ...job.draft.survey import survey
    from ...job.draft.template import Choices, new_job
    from ...job.surfaces import TURNS

    if up is not None and up not in TURNS:
        raise InputError(f"--up {up}: one of {', '.join(TURNS)} is needed")
    found = resolve_fabric(fabric)
    own = Path(fabric) if Path(fabric).suffix.lower() in SUFFIXES else None
    surface = survey(die, unit=unit, up=up)
    if ring is not None and not surface.is_female:
        raise InputError(f"--ring {ring}: the die has no opening with a rim for a holder to press on; leave it out")
    choices = Choices(
        name=name,
        die=die.name,
        fabric=fabric if own is None else own.name,
        gap=_millimetres("--thickness", thickness, "gap"),
        punch=None if punch is None else punch.name,
        ring=None if ring is None else ring.name,
        mesh_size=_millimetres("--mesh-size", mesh_size, "mesh size"),
        with_ring=with_ring,
        schema=SCHEMA_NAME,
    )
    if choices.gap is not None and not 1.0 / LARGEST_GAP_RATIO < choices.gap / found.thickness < LARGEST_GAP_RATIO:
        raise InputError(
            f"--thickness {thickness}: a gap of {1e3 * choices.gap:.4g} mm between the closed tools does not suit the "
            f"fabric {fabric}, which is {1e3 * found.thickness:.4g} mm thick; a number without a unit is in mm, and of "
            "several plies give their sum"
        )
    return new_job(surface, choices, found), own


def tables_of(fabric: Path) -> Iterator[Path]:
    """Tables of measured curves that a fabric file names.

    Raises:
        InputError: one lies in a folder below that of the file, where a copy would not be found.
    """
    from ...documents import read_document

    def within(value: Any) -> Iterator[str]:
        if isinstance(value, Mapping):
            if isinstance(value.get("csv"), str):
                yield value["csv"]
            value = list(value.values())
        if isinstance(value, list):
            for item in value:
                yield from within(item)

    for name in dict.fromkeys(within(read_document(fabric, "fabric").values)):
        if Path(name).name != name:
            raise InputError(f"--fabric {fabric}: its table {name} lies in another folder; put it beside the file")
        yield fabric.parent / name


def _millimetres(option: str, text: str | None, quantity: str) -> float | None:
    """A length that a user typed, in millimetres if it has no unit [m]."""
    from ...job.units import number_of
    from ...ranges import QUANTITIES, illegal

    if text is None:
        return None
    row = QUANTITIES[quantity]
    try:
        value = number_of(f"{text} mm" if text.strip().replace(".", "", 1).isdigit() else text, row)
    except ValueError as error:
        raise InputError(f"{option} {text}: {error}") from None
    if value <= 0.0 or (problem := illegal(value, row)):
        raise InputError(f"{option} {text}: {'a length above 0 is needed' if value <= 0.0 else problem}")
    return value


def scene_text(name: str) -> str:
    """A job of a scene: every option as a comment with its default."""
    from ...job.scenes import ELSEWHERE, known_scenes
    from ...ranges import quantity_of

    scenes = known_scenes()
    if name not in scenes:
        raise InputError(f"--scene {name}: one of {', '.join(scenes)} is needed{did_you_mean(name, scenes)}")
    parameters = scenes[name].load().parameters
    lines = [f"# {scenes[name].help}", "# A line without its # replaces the default; weavesim form runs it.", ""]
    lines += ["[scene]", f'name = "{name}"', ""]
    defaults = parameters().model_dump(mode="json")
    for key, field in parameters.model_fields.items():
        if key in ELSEWHERE:
            continue
        quantity, value = quantity_of(field), defaults[key]
        unit = f" [{quantity.row.unit}]" if quantity and quantity.row.unit != "1" else ""
        description = re.sub(r"\s*\[[^\]]*\]$", "", field.description or "")
        lines += [f"# {description}{unit}", f"# {key} = {_toml(value)}", ""]
    return "\n".join(lines) + "\n[output]\n# frame_count = 60\n"


def _toml(value: object) -> str:
    return '""' if value is None else json.dumps(value)


def _write(folder: Path, text: str, files: tuple[Path, ...]) -> None:
    """Write the job, its schema, and copies of the files into a folder that has no job yet."""
    from ...job.schema import Job
    from ...job.tables import schema_of
    from ...output.files import check_writable, write_text

    check_writable(folder)
    if (folder / JOB_NAME).exists():
        raise InputError(f"{folder / JOB_NAME}: it exists; give another name, or remove it first")
    names = [path.name for path in files]
    if len(set(names)) < len(names):
        raise InputError(f"{', '.join(names)}: two of these files have the same name; rename one")
    for path in files:
        if not (folder / path.name).exists() or not (folder / path.name).samefile(path):
            try:
                shutil.copyfile(path, folder / path.name)
            except OSError as error:
                raise InputError(f"{path}: cannot be copied to {folder} ({error.strerror})") from None
    write_text(folder / JOB_NAME, text)
    write_text(folder / SCHEMA_NAME, json.dumps(schema_of(Job), indent=1) + "\n")
