"""What a fabric consists of, as text: every number with its unit, meaning, source and trusted range."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

from ..fabric.provenance import Number, Origin, given_numbers, numbers_of
from ..input_files import shown

if TYPE_CHECKING:
    from ..fabric.fabric import Fabric

HEADER = ("number", "value", "unit", "trusted", "", "source", "what it is")
NOT_SAID = "not said"
# What it is goes below a number where fewer columns are left for it.
LEAST_WIDTH = 36


class Row(NamedTuple):
    """One number of a fabric, as text.

    Attributes:
        table: that it is in, "" for the fabric itself.
        cells: name in the table, value, unit, trusted range, "assumed" or "", number of its source.
        meaning: what it is.
    """

    table: str
    cells: tuple[str, ...]
    meaning: str


def fabric_table(fabric: Fabric, width: int) -> str:
    """Every number of a fabric in one line each, and the sources below, for that many columns."""
    rows, sources = rows_of(fabric)
    widths = [max(len(row.cells[k]) for row in [Row("", HEADER, ""), *rows]) for k in range(6)]
    widths[0] += 2
    left = sum(widths) + 2 * len(widths)
    is_wide = width - left >= LEAST_WIDTH
    lines = [_line(HEADER[:6], widths) + (HEADER[6] if is_wide else ""), ""]
    table = ""
    for row in rows:
        if row.table != table:
            table = row.table
            lines += [f"{table} ({_kind(fabric, table)})"]
        name = ("  " if table else "") + row.cells[0]
        start = _line((name, *row.cells[1:]), widths)
        if is_wide:
            lines += _folded(start, row.meaning, width, left)
        else:
            lines += [start, *_folded("      ", row.meaning, width, 6)]
    lines += ["", "sources"]
    for k, source in enumerate(sources, start=1):
        lines += _folded(f"{f'[{k}]':>5} ", source, width, 6)
    return "\n".join(line.rstrip() for line in lines)


def rows_of(fabric: Fabric) -> tuple[list[Row], list[str]]:
    """One row for each number, and for optional values that are not given but have an origin; and all sources."""
    rows: list[Row] = []
    sources: list[str] = []
    # what is in no table first
    for name, number in sorted(numbers_of(fabric).items(), key=lambda item: "." in item[0]):
        origin = fabric.origin_of(name)
        if number.value is None and origin is None:
            continue
        place = NOT_SAID
        if origin is not None:
            source = shown("; ".join(filter(None, [origin.source, origin.note])))
            if source not in sources:
                sources.append(source)
            place = f"[{sources.index(source) + 1}]"
        table, _, field = name.rpartition(".")
        assumed = "assumed" if origin is not None and origin.assumed else ""
        rows.append(
            Row(table, (field, _value(number), number.unit, _trusted(number, origin), assumed, place), number.meaning)
        )
    return rows, sources


def summary_of(fabric: Fabric) -> str:
    """How many numbers there are, and of how many nobody said where they come from."""
    origins = [fabric.origin_of(name) for name in given_numbers(fabric)]
    assumed = sum(origin.assumed for origin in origins if origin is not None)
    unknown = sum(origin is None for origin in origins)
    text = f"{len(origins)} numbers, of which {assumed} are assumed"
    return (
        f"{text}; of {unknown} nobody said where they come from ([[provenance]] of its file does)" if unknown else text
    )


def _kind(fabric: Fabric, table: str) -> str:
    value: object = fabric
    for part in table.split("."):
        value = getattr(value, part)
    return type(value).__name__


def _line(cells: Sequence[str], widths: Sequence[int]) -> str:
    return "".join(f"{cell:{width}}  " for cell, width in zip(cells, widths, strict=True))


def _folded(start: str, text: str, width: int, left: int) -> Iterator[str]:
    """``text`` behind ``start``, and in as many more lines as it needs, from column ``left`` on."""
    first, *rest = textwrap.wrap(text, max(width - left, 20)) or [""]
    yield start + first
    for line in rest:
        yield " " * left + line


def _value(number: Number) -> str:
    if number.value is None:
        return "none"
    if len(number.values) == 1:
        return _interval(number.unit, number.values[0], number.values[0], "{:.6g}")
    return f"{len(number.values)} points, {_interval(number.unit, min(number.values), max(number.values))}"


def _trusted(number: Number, origin: Origin | None) -> str:
    if origin is None:
        return ""
    parts = [_interval(number.unit, *origin.range)] if origin.range is not None else []
    if origin.scatter is not None:
        parts.append(f"± {100.0 * origin.scatter:.3g} %")
    return ", ".join(parts) or (NOT_SAID if number.values else "")


def _interval(unit: str, low: float, high: float, form: str = "{:.4g}") -> str:
    """ "0 to 0.611 (0 to 35°)", or one value."""
    ends = (low,) if low == high else (low, high)
    text = " to ".join(form.format(end) for end in ends)
    if unit == "rad" and high != 0.0:
        text += f" ({' to '.join(f'{math.degrees(end):.3g}' for end in ends)}°)"
    return text
