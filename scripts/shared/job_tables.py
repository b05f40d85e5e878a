"""Tables of a job file for docs/job.md, from its models."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pydantic.fields import FieldInfo

from weavesim.job.schema import (
    GripperTable,
    InterfaceTable,
    Job,
    OutputTable,
    PairTable,
    PlyTable,
    PressureTable,
    ProcessTable,
    SolverTable,
    SpringTable,
    StageTable,
    ToolTable,
)
from weavesim.job.segments.tables import SegmentTable
from weavesim.job.stages.paths import RotationTable
from weavesim.job.stages.tables import EndTable, MoveTable, StagePressureTable, TrimTable
from weavesim.job.tables import JobTable, table_within, takes_numbers, words_of
from weavesim.job.units import EXAMPLES
from weavesim.ranges import quantity_of

SECTIONS: tuple[tuple[str, type[JobTable]], ...] = (
    ("Top of the file", Job), ("[[ply]]", PlyTable), ("[[tool]]", ToolTable), ("[[spring]]", SpringTable),
    ("[[gripper]]", GripperTable), ("[[pressure]]", PressureTable), ("[[stage]]", StageTable),
    ("[[stage.move]]", MoveTable), ("[tool.rotation]", RotationTable), ("[[tool.segment]]", SegmentTable),
    ("[stage.end]", EndTable), ("[[stage.pressure]]", StagePressureTable), ("[[stage.trim]]", TrimTable),
    ("[interface]", InterfaceTable),
    ("[[interface.pair]]", PairTable),
    ("[process]", ProcessTable), ("[solver]", SolverTable), ("[output]", OutputTable),
)  # fmt: skip


def tables() -> str:
    """All sections, one row per key."""
    return sections(SECTIONS)


def sections(listed: tuple[tuple[str, type[JobTable]], ...], elsewhere: frozenset[str] = frozenset()) -> str:
    """Tables of keys, one section for each class; those of the first that are tables ``elsewhere`` are left out."""
    parts = []
    own = {title.strip("[]") for title, _ in listed} | elsewhere
    for title, table in listed:
        text = (table.__doc__ or "").split("`")[0].strip().rstrip(".")
        heading = f"### `{title}`\n\n{text}.\n" if title.startswith("[") else f"### {title}\n"
        rows = list(_rows(table, own if table is listed[0][1] else set()))
        parts.append("\n".join([heading, "| key | value | default | meaning |", "|---|---|---|---|", *rows]) + "\n")
    return "\n".join(parts)


def _rows(table: type[JobTable], elsewhere: set[str]) -> Iterator[str]:
    base = next((kind for kind in (SpringTable, PressureTable) if table is not kind and issubclass(table, kind)), None)
    for name, field in table.model_fields.items():
        if name in elsewhere or (base is not None and name in base.model_fields):
            continue
        default = "required" if field.is_required() else _shown(field.get_default(call_default_factory=True))
        meaning = (field.description or "").replace("|", "\\|")
        yield f"| `{name}` | {_value(field)} | {default} | {meaning} |"
    if base is not None:
        yield f"| | | | and every key of `[[{'spring' if base is SpringTable else 'pressure'}]]` |"


def _value(field: FieldInfo) -> str:
    """What a key may be: a quantity with its range, one of several words, or a kind of value."""
    quantity, words = quantity_of(field), words_of(field)
    parts = [f'`"{word}"`' for word in words]
    text = str(field.annotation)
    many = text.count("tuple[") > 0
    if quantity is not None:
        row = quantity.row
        unit = "" if row.unit == "1" else f" {row.unit}"
        low, high = row.plausible
        bounds = f"usual up to {high:g}{unit}" if low == 0.0 else f"usual {low:g} to {high:g}{unit}"
        parts.append(f'{"numbers" if many else "number"}, `"{EXAMPLES[row.unit]}"`, {bounds}')
        if "dict" in text:
            parts.append("or a table")
    elif table_within(field) is not None:
        parts.append("tables" if many else "table")
    elif "typing.Any" in text and "dict" not in text:
        parts.append("values, with units or in SI" if many else "value, with its unit or in SI")
    elif "bool" in text:
        parts.append("true or false")
    elif "dict" in text:
        parts.append("table")
    elif not words and takes_numbers(field):
        parts.append("numbers" if many else "number")
    elif not words:
        parts.append("texts" if many else "text")
    return ("list: " if words and many else "") + ", ".join(parts)


def _shown(value: Any) -> str:
    if value is None or value in ((), {}):
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return "[" + ", ".join(f"{item:g}" for item in value) + "]"
    return f"{value:g}" if isinstance(value, int | float) else f'`"{value}"`'
