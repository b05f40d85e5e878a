"""Friction in a job: a coefficient, or a law with the names of its values and their units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

from pydantic import Discriminator, Tag

from ..checks import NotNegative
from ..errors import InputError, did_you_mean
from ..process.friction import Friction, YarnAngleFriction
from ..ranges import Quantity, quantity_of
from .units import in_units

if TYPE_CHECKING:
    from .read import JobFile


def _kind_of(value: object) -> str:
    return "law" if isinstance(value, Mapping) else "number"


FrictionValue = Annotated[
    Annotated[NotNegative, Quantity("friction"), Tag("number")] | Annotated[dict[str, Any], Tag("law")],
    Discriminator(_kind_of),
]
LAWS = "a coefficient, or a law: {kind = ..., ...} with the names of its values (docs/plies.md)"


def friction_of(
    file: JobFile, keys: list[object], value: float | Mapping[str, Any], *, of_tool: bool
) -> Friction | float:
    """The friction that stands under some keys.

    Raises:
        InputError: an unknown law, a value that it does not have, or one that is not allowed.
    """

    def refuse(problem: object) -> NoReturn:
        file.refuse(keys, f"friction: {problem}")

    if not isinstance(value, Mapping):
        return float(value)
    kinds = {name: kind for name, kind in Friction.kinds().items() if not (of_tool and kind is YarnAngleFriction)}
    name = value.get("kind")
    if name == YarnAngleFriction.__name__ and of_tool:
        refuse(
            f"kind = {name!r}: it depends on the angle between the warps of two plies, and a tool has no yarns; one of "
            f"{', '.join(kinds)} is needed"
        )
    if name not in kinds:
        refuse(f"kind = {name!r}: one of {', '.join(kinds)} is needed{did_you_mean(str(name), kinds)}")
    kind, numbers = kinds[str(name)], {}
    for key, given in value.items():
        if key == "kind":
            continue
        field = kind.model_fields.get(key)
        if field is None:
            refuse(f"{key}: {name} has no such value{did_you_mean(key, kind.model_fields)}; it has "
                   f"{', '.join(kind.model_fields)}")  # fmt: skip
        quantity = quantity_of(field)
        try:
            numbers[key] = given if quantity is None else in_units(given, quantity.row)
        except ValueError as error:
            refuse(f"{key} = {given!r}: {error}")
    try:
        law = kind(**numbers)
    except InputError as error:
        refuse(error)
    file.ask(keys, law)
    return law
