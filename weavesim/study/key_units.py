"""Units of the keys of a job, for values of a study that are written without one."""

from __future__ import annotations

from typing import Any

from ..checks import Parameters
from ..job.blanks.plies import fabric_of
from ..job.overrides import overridden
from ..job.read import JobFile
from ..job.scenes import known_scenes
from ..job.schema import Job
from ..job.tables import table_within
from ..ranges import Quantity, quantity_of


def unit_of_key(file: JobFile, key: str) -> str:
    """SI unit of a key as --set takes it, such as "N" for "tools.ring.force"; "" for a pure number, or for no number.

    Raises:
        InputError: a table or an entry that the job does not have.
    """
    _, places = overridden(file.values, [f"{key}=0"])
    ((first, *parts),) = places
    if first == "fabric":
        return _unit(_of_fabric(file, parts[0], parts[1:]))
    table: type[Parameters] | None = Job
    if first == "scene" and file.job.scene is not None:
        scene = known_scenes().get(str(file.job.scene.get("name")))
        table = None if scene is None else scene.load().parameters
    else:
        parts = [first, *parts]
    quantity = None
    for part in parts:
        if part.isdecimal():  # place in a list
            continue
        field = table.model_fields.get(part) if table is not None else None
        table, quantity = (None, None) if field is None else (table_within(field), quantity_of(field))
    return _unit(quantity)


def _of_fabric(file: JobFile, name: str, parts: list[str]) -> Quantity | None:
    """Quantity of a value of a fabric as the job has it: which laws it has decides what is below them."""
    index = next((k for k, ply in enumerate(file.job.ply) if ply.fabric == name), None)
    value: Any = None if index is None else fabric_of(file, index)
    quantity = None
    for part in parts:
        field = type(value).model_fields.get(part) if isinstance(value, Parameters) else None
        value, quantity = getattr(value, part, None), None if field is None else quantity_of(field)
    return quantity


def _unit(quantity: Quantity | None) -> str:
    return "" if quantity is None or quantity.row.unit == "1" else quantity.row.unit
