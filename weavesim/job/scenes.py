"""A scene as a job: its options under their names, in SI units or with units."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any, get_args

from pydantic.fields import FieldInfo

from ..checks import typed_as, types_within
from ..errors import InputError, did_you_mean
from ..ranges import quantity_of
from .read import JobFile
from .units import in_units

# Options that belong to the command, or to the tables of every job.
ELSEWHERE = {
    "out": "give --out to the command",
    "overwrite": "give --overwrite to the command",
    "strict": "give --strict to the command",
    "limits": "give --limits to the command",
    "accept_unusual": "write accept_unusual at the top of the job",
    "device": "write it in [solver]",
    "precision": "write it in [solver]",
    "threads": "write it in [solver]",
    "time_step": "write it in [solver]",
    "target_step": "write it in [solver]",
    "mass_scaling_angle": "write it in [solver]",
    "mass_scaling_draw_in": "write it in [solver]",
    "write": "write it in [output]",
    "without": "write it in [output]",
    "frame_count": "write it in [output]",
    "checkpoint_interval": "write it in [output]",
    "stop_on": "write it in [output]",
}


def known_scenes() -> dict[str, Any]:
    """Scenes by name, not imported yet: they stand above this room, which only discovers them."""
    return import_module("weavesim.scenes.scene").known_scenes()


def scene_of(file: JobFile, *, out: Path, overwrite: bool = False, limits: Path | None = None) -> tuple[Any, Any]:
    """The scene that a job names, and its parameters.

    Args:
        file: the job.
        out: folder for the results.
        overwrite: replace results that are there.
        limits: file of the limits by which the report judges the part; None for those that are built in.

    Raises:
        InputError: no such scene, or options that it does not have or allow.
    """
    given = dict(file.job.scene or {})
    scenes = known_scenes()
    name = given.pop("name", None)
    if name not in scenes:
        hint = did_you_mean(str(name), scenes)
        file.refuse(["scene", "name"], f"name = {name!r}: one of {', '.join(scenes)} is needed{hint}")
    scene = scenes[name].load()
    fields = scene.parameters.model_fields
    values: dict[str, Any] = {"out": out, "overwrite": overwrite, "accept_unusual": file.job.accept_unusual}
    if limits is not None:
        values |= {"strict": True, "limits": limits.absolute()}
    for key, value in given.items():
        if key in ELSEWHERE:
            file.refuse(["scene", key], f"{key}: {ELSEWHERE[key]}")
        if key not in fields:
            file.refuse(["scene", key], f"{key} = {value!r}: the scene has no such option{did_you_mean(key, fields)}")
        values[key] = _converted(file, key, fields[key], value)
    values |= _of_tables(file, fields)
    try:
        with typed_as({}):
            return scene, scene.parameters(**values)
    except InputError as error:
        text = str(error).removeprefix(f"{scene.parameters.__name__}: ")
        key = text.split(" ")[0].rstrip(":")
        file.refuse(["scene", key] if key in given else ["scene"], text)


def _converted(file: JobFile, key: str, field: FieldInfo, value: Any) -> Any:
    """A value in SI units; a file within the job's folder."""
    quantity = quantity_of(field)
    if quantity is not None:
        try:
            return in_units(value, quantity.row)
        except ValueError as error:
            file.refuse(["scene", key], f"{key} = {value!r}: {error}")
    types = set(types_within(field.annotation))
    if isinstance(value, str) and Path in types:
        return file.file(value, ["scene", key])
    if key == "fabric" and isinstance(value, str) and value.lower().endswith((".toml", ".json")):
        return str(file.file(value, ["scene", key]))
    return tuple(value) if isinstance(value, list | tuple) and get_args(field.annotation) else value


def _of_tables(file: JobFile, fields: dict[str, FieldInfo]) -> dict[str, Any]:
    """Options of a scene that stand in the tables of every job."""
    found: dict[str, Any] = {}
    for table, keys in (("solver", file.job.solver), ("output", file.job.output)):
        for key in file.values.get(table, {}):
            value = getattr(keys, key)
            if key not in fields:
                file.refuse([table, key], f"{key}: this scene has no such option")
            found[key] = ",".join(value) if isinstance(value, tuple) else value
    return found
