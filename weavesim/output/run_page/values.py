"""Values of a set-up for readers: words instead of names, units, and no Python."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from typing import Any, NamedTuple

import numpy as np
from pydantic.fields import FieldInfo

from ...checks import Kinded, Parameters, types_within
from ...ranges import Quantity

# Lists of more numbers are shown by their range.
LONGEST_LIST = 6
_UNIT = re.compile(r"\[([^\[\]]+)\]")
_CAPITAL = re.compile(r"(?<=[a-z0-9])(?=[A-Z])")
# Unit -> smallest size from which it is shown in another one, that one, and the factor to it.
_READABLE: dict[str, tuple[tuple[float, str, float], ...]] = {
    "m": ((10.0, "m", 1.0), (0.0, "mm", 1.0e3)),
    "rad": ((0.0, "°", 180.0 / math.pi),),
    "degrees": ((0.0, "°", 1.0),),
    "Pa": ((1.0e9, "GPa", 1.0e-9), (1.0e6, "MPa", 1.0e-6), (1.0e3, "kPa", 1.0e-3), (0.0, "Pa", 1.0)),
    "N/m^2": ((1.0e3, "kPa", 1.0e-3), (0.0, "Pa", 1.0)),
    "s": ((0.1, "s", 1.0), (1.0e-4, "ms", 1.0e3), (0.0, "µs", 1.0e6)),
    "m^2": ((0.01, "m²", 1.0), (0.0, "mm²", 1.0e6)),
    "kg/m^2": ((0.0, "kg/m²", 1.0),),
    "kg/m^3": ((0.0, "kg/m³", 1.0),),
    "m/s^2": ((0.0, "m/s²", 1.0),),
    "1": ((0.0, "", 1.0),),
    "m^4": ((0.0, "mm⁴", 1.0e12),),
}


class Row(NamedTuple):
    """One value.

    Attributes:
        label: what it is.
        text: the value with its unit.
        depth: 0, or 1 for a part of the row before it, and so on.
        meaning: more about what it is; "" if the label says it all.
    """

    label: str
    text: str
    depth: int = 0
    meaning: str = ""


def words(name: str) -> str:
    """A name of Python as words: "yarn_angle" as "yarn angle", "ForceDriven" as "force driven"."""
    return _CAPITAL.sub(" ", name).replace("_", " ").lower() if not name.isupper() else name


def number(value: float, unit: str = "") -> str:
    """A number with four digits and its unit, in millimetres, degrees, kPa, ... as readers expect."""
    if not math.isfinite(value):
        return "–"
    readable, factor = _readable(abs(value), unit)
    return _after(f"{_digits(value * factor)}", readable)


def _digits(value: float) -> str:
    if value != 0.0 and 1.0e4 <= abs(value) < 1.0e10:
        return f"{value:,.0f}".replace(",", "\u202f")
    text = f"{value:.4g}"
    if "e" in text:
        mantissa, exponent = text.split("e")
        text = f"{mantissa}\u00b710{_raised(int(exponent))}"
    return text.replace("-", "\u2212")


def _raised(exponent: int) -> str:
    return str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _readable(size: float, unit: str) -> tuple[str, float]:
    """Unit for readers of a number of that size, and the factor to it."""
    scales = _READABLE.get(unit, ((0.0, unit, 1.0),))
    for least, readable, factor in scales:
        if size >= least and size > 0.0:
            return readable, factor
    return scales[0 if unit == "s" else -1][1:]


def _after(text: str, unit: str) -> str:
    return text + ("" if unit in ("", "°") else "\u202f") + unit


def unit_of(info: FieldInfo) -> str:
    """Unit of a field, from its quantity, or else from its description; "" for none."""
    for part in (*info.metadata, *types_within(info.annotation)):
        for item in (part, *getattr(part, "__metadata__", ())):
            if isinstance(item, Quantity):
                return "" if item.row.unit == "1" else item.row.unit
    found = _UNIT.search(info.description or "")
    return found[1] if found and "default" not in found[1] else ""


def rows_of(value: Parameters, *, without: Sequence[str] = (), depth: int = 0) -> Iterator[Row]:
    """A row for each field of a value that says something, and below it those of its parts."""
    for name, info in type(value).model_fields.items():
        if name not in without:
            yield from _rows(words(name), getattr(value, name), unit_of(info), depth)


def _rows(label: str, value: Any, unit: str, depth: int) -> Iterator[Row]:
    if value is None or (isinstance(value, tuple | list | str) and len(value) == 0):
        return
    if isinstance(value, Parameters):
        kind = words(type(value).__name__) if isinstance(value, Kinded) else ""
        parts = list(rows_of(value, depth=depth + 1))
        if kind or parts:
            yield Row(label, kind, depth)
            yield from parts
    elif isinstance(value, tuple | list) and all(isinstance(item, Parameters) for item in value):
        for k, item in enumerate(value, start=1):
            own = getattr(item, "name", None)
            yield from _rows(own if isinstance(own, str) else f"{label} {k}", item, "", depth)
    else:
        yield Row(label, text_of(value, unit), depth)


def text_of(value: Any, unit: str = "") -> str:
    """A value with its unit as text."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, int | np.integer) and not unit:
        return _digits(int(value)) if abs(int(value)) >= 10_000 else str(value)
    if isinstance(value, int | float | np.number):
        return number(float(value), unit)
    if isinstance(value, Mapping):
        return ", ".join(f"{words(str(key))} {text_of(item, unit)}" for key, item in value.items()) or "none"
    if isinstance(value, np.ndarray | tuple | list | set | frozenset):
        return _list(value, unit)
    return str(value)


def in_words(value: Parameters, *, without: Sequence[str] = ()) -> str:
    """A value with its parts in one line: "dome punch, radius 60 mm, half length 85 mm"."""
    kind = [words(type(value).__name__)] if isinstance(value, Kinded) else []
    parts = [f"{row.label} {row.text}".strip() for row in rows_of(value, without=without)]
    return ", ".join([*kind, *parts])


def _list(value: Any, unit: str) -> str:
    items = list(value)
    if isinstance(value, np.ndarray) and value.ndim == 2 and value.size > 9 and not unit:
        return str(len(items))  # of a mesh: how many vertices or faces
    try:
        numbers = np.asarray(items, dtype=float)
    except (TypeError, ValueError):
        numbers = np.zeros(0)
    if numbers.size == 0 or any(isinstance(item, bool) for item in items):
        return ", ".join(text_of(item) for item in items) or "none"
    if numbers.size <= LONGEST_LIST and numbers.ndim == 1:
        size = float(np.abs(numbers[np.isfinite(numbers)]).max(initial=0.0))
        readable, factor = _readable(size, unit)
        text = ", ".join(_digits(float(x) * factor) for x in numbers)
        return _after(f"({text})" if len(items) > 1 else text, readable)
    if numbers.ndim == 2 and numbers.size <= 9:
        return ", ".join(_list(row, unit) for row in items)
    finite = numbers[np.isfinite(numbers)]
    if not finite.size:
        return f"{numbers.size} values"
    least, most = float(finite.min()), float(finite.max())
    return f"{numbers.size} values, {number(least, unit)} to {number(most, unit)}"
