"""What the tables of a job have in common: numbers may be texts with units, and a description belongs to every key."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import AfterValidator, ValidationInfo, field_validator
from pydantic.fields import FieldInfo

from ..checks import Finite, Parameters, json_schema, types_within
from ..ranges import Quantity, quantity_of, size_told, unit_after
from .units import EXAMPLES, in_units, length_unit

Coordinate = Annotated[Finite, Quantity("position")]
Point = tuple[Coordinate, Coordinate]


def _a_length(text: str) -> str:
    length_unit(text)
    return text


# Unit of a file, such as "mm".
FileUnit = Annotated[str, AfterValidator(_a_length)]


class JobTable(Parameters):
    """Base class of the tables of a job file.

    A field with a quantity takes a number in the unit of that quantity, or a text with a unit. Every field has a
    description, which the documents and the schema for editors show.
    """

    @field_validator("*", mode="before")
    @classmethod
    def _text_is_no_number(cls, value: Any, info: ValidationInfo) -> Any:
        field = cls.model_fields[info.field_name or ""]
        quantity = quantity_of(field)
        if field.annotation is bool and not isinstance(value, bool):
            raise ValueError("true or false is needed")
        if isinstance(value, str):
            if value in words_of(field):
                return value
            if quantity is None and takes_numbers(field) and not takes_texts(field):
                raise ValueError("a number is needed, not a text")
        try:
            return value if quantity is None else in_units(value, quantity.row)
        except ValueError as error:
            if not (words := words_of(field)):
                raise
            raise ValueError(f"{error}; or {' or '.join(map(repr, words))}") from None


def one_of(table: JobTable, names: tuple[str, ...]) -> str:
    """The one of several keys that a table gives.

    Raises:
        ValueError: it gives none, or more than one.
    """
    given = [name for name in names if getattr(table, name) is not None and getattr(table, name) is not False]
    if len(given) != 1:
        what = f"{' and '.join(given)} are given" if given else "none is given"
        raise ValueError(f"{', '.join(names[:-1])} or {names[-1]}: one of them is needed, {what}")
    return given[0]


def without(table: JobTable, names: tuple[str, ...], needed: str) -> None:
    """Refuse keys that have no effect without another one.

    Raises:
        ValueError: one of them is given.
    """
    for name in names:
        if name in table.model_fields_set and getattr(table, name) is not None:
            raise ValueError(f"{name}: has no effect without {needed}; leave it out")


def words_of(field: FieldInfo) -> tuple[str, ...]:
    """The words that a field allows by name."""
    found: list[str] = []
    for part in types_within(field.annotation):
        if get_origin(part) is Literal:
            found += [word for word in get_args(part) if isinstance(word, str) and word not in found]
    return tuple(found)


def check_knots(times: tuple[float, ...] | None, values: tuple | None, name: str, what: str) -> None:
    """Check that there are as many increasing times as values; ``name`` is that of the times, ``what`` the values are.

    Raises:
        ValueError: there are not.
    """
    if times is None:
        raise ValueError(f"{name}: is required with {what}, one for each")
    if len(times) != len(values or ()) or not times:
        raise ValueError(f"{name}: {len(times)} times for {len(values or ())} {what}; one for each is needed")
    if any(b <= a for a, b in zip(times, times[1:], strict=False)):
        raise ValueError(f"{name}: times must increase")


def table_within(field: FieldInfo) -> type[JobTable] | None:
    """The table that a field holds, or several of; None if it holds none."""
    for part in types_within(field.annotation):
        if isinstance(part, type) and issubclass(part, JobTable):
            return part
    return None


def takes_numbers(field: FieldInfo) -> bool:
    """Whether numbers are among the values of a field."""
    return bool({int, float} & set(types_within(field.annotation)))


def takes_texts(field: FieldInfo) -> bool:
    """Whether any text is among the values of a field."""
    return any(isinstance(part, type) and issubclass(part, str) for part in types_within(field.annotation))


def unusual_keys(table: Parameters, keys: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], str]]:
    """The keys of all unusual numbers in a table and those within it, each with a sentence that begins with its name.

    Args:
        table: of a job, or the job.
        keys: of the table; an entry of a list has its place as text.
    """
    for name, field in type(table).model_fields.items():
        value, own = getattr(table, name), (*keys, name)
        if table_within(field) is not None:
            several = isinstance(value, tuple)
            for index, entry in enumerate(value if several else (value,)):
                if entry is not None:
                    yield from unusual_keys(entry, (*own, str(index)) if several else own)
        elif (quantity := quantity_of(field)) and (numbers := tuple(_numbers_of(value))):
            item = value if isinstance(value, int | float) else numbers
            if question := quantity.unusual(item):
                yield own, f"{name} = {size_told(item)}{unit_after(quantity.row)}: {question}"


def _numbers_of(value: Any) -> Iterator[float]:
    """All numbers in a value of a key: lists may be uneven, and what has a name, such as a law, is made elsewhere."""
    if isinstance(value, int | float):
        yield float(value)
    elif isinstance(value, list | tuple):
        for item in value:
            yield from _numbers_of(item)
    elif isinstance(value, dict) and "kind" not in value:
        for item in value.values():
            yield from _numbers_of(item)


def schema_of(cls: type[Parameters]) -> dict[str, Any]:
    """JSON schema of a job file for editors: where a number is a quantity, a text with a unit will do too."""
    schema = json_schema(cls)
    for kind in (cls, *_tables_within(cls)):
        part = schema if kind is cls else schema["$defs"][kind.__name__]
        for name, field in kind.model_fields.items():
            if (quantity := quantity_of(field)) is None:
                continue
            entry = part["properties"][name]
            unit = quantity.row.unit
            texts = {"type": "string", "examples": [EXAMPLES[unit]]}
            part["properties"][name] = _with_texts(entry, texts)
    return schema


def _with_texts(entry: Any, texts: dict[str, Any]) -> Any:
    """A schema in which every number may be a text with a unit."""
    if isinstance(entry, list):
        return [_with_texts(item, texts) for item in entry]
    if not isinstance(entry, dict):
        return entry
    if entry.get("type") == "number":
        kept = {key: value for key, value in entry.items() if key in ("description", "default", "title")}
        number = {key: value for key, value in entry.items() if key not in kept}
        return {**kept, "anyOf": [number, texts]}
    return {key: value if key in ("default", "description") else _with_texts(value, texts)
            for key, value in entry.items()}  # fmt: skip


def _tables_within(cls: type[Parameters]) -> list[type[Parameters]]:
    found: list[type[Parameters]] = []
    for field in cls.model_fields.values():
        for part in types_within(field.annotation):
            if isinstance(part, type) and issubclass(part, JobTable) and part not in found:
                found += [part, *_tables_within(part)]
    return found
