"""Where the numbers of a fabric come from, how far each is trusted, and which of them are assumed."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple, Self

from pydantic import Field, field_validator, model_validator

from ..checks import Finite, Parameters
from ..errors import did_you_mean
from ..input_files import shown

if TYPE_CHECKING:
    from .fabric import Fabric

# Fields of a fabric that hold no numbers of the material.
NOT_OF_THE_MATERIAL = ("name", "source", "assumed", "provenance")
LONGEST_TEXT = 2000
_UNIT = re.compile(r" ?\[([^\[\]]+)\]")


class Origin(Parameters):
    """Where one number of a fabric, or several, come from.

    ``range`` is in the unit of the number: for a curve give it for the angles or curvatures, as the part of the curve
    that is trusted. ``scatter`` is the relative counterpart, for numbers that differ in size, such as moments.
    """

    of: tuple[str, ...] = Field(
        description='the numbers, by their names in a fabric file, such as "shear.angle", or whole tables, such as '
        '"bending"'
    )
    source: str = Field(description="where they come from: a publication, a test, a laboratory, or why they are so")
    assumed: bool = Field(default=False, description="true for numbers that nobody has measured on this fabric")
    range: tuple[Finite, Finite] | None = Field(
        default=None, description="least and largest value that is trusted; of the points of a curve, the trusted part"
    )
    scatter: Annotated[float, Field(gt=0.0, allow_inf_nan=False)] | None = Field(
        default=None, description="relative scatter: 0.4 for plus or minus 40 per cent"
    )
    note: str = Field(default="", description="anything else that one should know")

    @field_validator("of", mode="before")
    @classmethod
    def _one_is_enough(cls, value: Any) -> Any:
        return (value,) if isinstance(value, str) else value

    @model_validator(mode="after")
    def _says_something(self) -> Self:
        if not self.of or not all(name.strip() for name in self.of):
            raise ValueError('of: the name of at least one number is needed, such as "thickness"')
        if not self.source.strip():
            raise ValueError("source: a text is needed; for a number that nobody measured, say so, with assumed = true")
        if max(len(self.source), len(self.note)) > LONGEST_TEXT:
            raise ValueError(f"source and note: at most {LONGEST_TEXT} characters each are allowed")
        if self.range is not None and self.range[0] > self.range[1]:
            low, high = self.range
            raise ValueError(f"range = [{low:g}, {high:g}]: the least value comes first")
        return self


class Number(NamedTuple):
    """A number of a fabric, or a list of them.

    Attributes:
        name: as in a fabric file, with dots: "unit_cell.warp_modulus".
        value: None if it is optional and not given.
        unit: "" for a pure number.
        meaning: what it is.
    """

    name: str
    value: float | tuple[float, ...] | None
    unit: str
    meaning: str

    @property
    def values(self) -> tuple[float, ...]:
        """The value as a list; empty if it is not given."""
        if self.value is None:
            return ()
        return self.value if isinstance(self.value, tuple) else (self.value,)


def numbers_of(fabric: Fabric) -> dict[str, Number]:
    """Everything of a fabric that provenance can be about, by name: numbers, and optional values that are not given."""
    return {number.name: number for number in _numbers(fabric, "")}


def given_numbers(fabric: Fabric) -> dict[str, Number]:
    """The numbers of a fabric, by name."""
    return {name: number for name, number in numbers_of(fabric).items() if number.value is not None}


def _numbers(owner: Parameters, prefix: str) -> Iterator[Number]:
    for field, info in type(owner).model_fields.items():
        if not prefix and field in NOT_OF_THE_MATERIAL:
            continue
        name, value = f"{prefix}{field}", getattr(owner, field)
        if isinstance(value, Parameters):
            yield from _numbers(value, f"{name}.")
        elif value is None or _is_number(value):
            text = info.description or ""
            unit = _UNIT.search(text)
            meaning = text.replace(unit[0], "", 1).strip() if unit else text
            yield Number(name, value, unit[1] if unit else "", meaning)


def _is_number(value: object) -> bool:
    if isinstance(value, tuple):
        return len(value) > 0 and all(_is_number(item) for item in value)
    return isinstance(value, int | float) and not isinstance(value, bool)


def with_number(owner: Parameters, name: str, value: Any) -> Any:
    """A fabric with one number changed, by its name in a fabric file.

    Raises:
        InputError: a value that is not allowed.
    """
    field, _, rest = name.partition(".")
    return owner.model_copy(update={field: with_number(getattr(owner, field), rest, value) if rest else value})


def origin_of(provenance: Iterable[Origin], name: str) -> Origin | None:
    """The origin of a number: one that names it, else one that names a table that it is in, the innermost first."""
    named = {key: origin for origin in provenance for key in origin.of}
    while name not in named and "." in name:
        name = name.rpartition(".")[0]
    return named.get(name)


def check_provenance(fabric: Fabric) -> None:
    """Raise ValueError if the provenance of a fabric names what it does not have, or something twice."""
    if not fabric.provenance:
        return
    numbers, seen = numbers_of(fabric), set()
    tables = {name[: place.start()] for name in numbers for place in re.finditer(r"\.", name)}
    for origin in fabric.provenance:
        for name in origin.of:
            if name in seen:
                raise ValueError(f"provenance: {shown(name)} is named twice")
            seen.add(name)
            if name not in numbers and name not in tables:
                hint = did_you_mean(name, [*numbers, *tables])
                raise ValueError(f"provenance: {shown(name)[:80]} is no number of this fabric{hint}")
            if origin.range is not None and name in tables:
                raise ValueError(f"provenance: {name} is a table; a range needs the name of one of its numbers")
            if origin.range is not None and numbers[name].value is None:
                raise ValueError(f"provenance: {name} is not given, so it has no range")


def out_of_range(fabric: Fabric) -> Iterator[str]:
    """Sentences on numbers that are not within the range of their own provenance."""
    numbers = numbers_of(fabric) if fabric.provenance else {}
    for origin in fabric.provenance:
        for name in origin.of if origin.range else ():
            number, (low, high) = numbers[name], origin.range or (0.0, 0.0)
            unit = f" {number.unit}" if number.unit else ""
            if isinstance(number.value, tuple):
                if high < min(number.value) or low > max(number.value):
                    yield (
                        f"{name} is from {min(number.value):.6g} to {max(number.value):.6g}{unit}, but its provenance "
                        f"trusts {low:.6g} to {high:.6g}{unit}: check the units of both"
                    )
            elif number.value is not None and not low <= number.value <= high:
                yield (
                    f"{name} = {number.value:.6g}{unit}, but its provenance trusts {low:.6g} to {high:.6g}{unit}: "
                    "check the units of both, or say where the new value comes from"
                )


def still_true(fabric: Fabric, changed: Fabric) -> tuple[Origin, ...]:
    """The provenance of ``fabric`` that holds for ``changed`` too: of the numbers that are the same in both."""
    before, after = ({name: number.value for name, number in numbers_of(f).items()} for f in (fabric, changed))
    return renamed(fabric.provenance, lambda name: _kept(name, before, after))


def _kept(name: str, before: Mapping[str, object], after: Mapping[str, object]) -> list[str]:
    """The name if all that it stands for is the same, else the parts that are."""
    inside = [key for key in before if key == name or key.startswith(f"{name}.")]
    same = [key for key in inside if key in after and after[key] == before[key]]
    is_whole = len(same) == len(inside) and all(key in before for key in after if key.startswith(f"{name}."))
    return [name] if is_whole else same


def without(provenance: Sequence[Origin], names: Iterable[str]) -> tuple[Origin, ...]:
    """Provenance without anything on these names, and on what is inside them."""
    left_out = tuple(names)

    def kept(name: str) -> list[str]:
        return [] if any(name == other or name.startswith(f"{other}.") for other in left_out) else [name]

    return renamed(provenance, kept)


def renamed(provenance: Iterable[Origin], names_for: Callable[[str], list[str]]) -> tuple[Origin, ...]:
    """Provenance with the names that ``names_for`` returns for each name; origins without names are dropped."""
    result = []
    for origin in provenance:
        names = tuple(dict.fromkeys(new for name in origin.of for new in names_for(name)))
        if names:
            result.append(origin if names == origin.of else origin.model_copy(update={"of": names}))
    return tuple(result)
