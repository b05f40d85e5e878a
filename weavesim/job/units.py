"""Quantities as people write them, "5 mm" or "20 kPa", in the units of the table of quantities.

The product is formed in decimal, so that "61.2 mm" is the number 0.0612 and a job has the same bits as a script.
"""

from __future__ import annotations

import difflib
import math
import re
from decimal import Decimal, InvalidOperation
from typing import Any

from ..errors import InputError
from ..ranges import Row
from ..tables.units import Unit, parse_unit

_WRITTEN = re.compile(r"\s*(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(?P<unit>\D.*)?")
# How a quantity of each unit may be written.
EXAMPLES = {
    "m": "5 mm", "m^2": "2 cm^2", "m^4": "0.1 mm^4", "1/m": "0.1 1/mm", "rad": "45 deg", "degrees": "45 deg",
    "Pa": "20 kPa", "Pa s": "0.2 Pa s", "N/m": "2 N/mm", "N m": "3 mN mm", "N": "600 N", "kg": "2 kg",
    "kg/m^2": "300 g/m^2", "kg/m^3": "2.5 g/cm^3", "m/s": "500 mm/s", "m/s^2": "9.81 m/s^2", "s": "2 ms",
    "1/s": "100 1/s", "rad/s": "90 deg/s", "1": "0.2", "m/unit": "1 mm",
}  # fmt: skip
_KNOWN = (
    "mm", "cm", "m", "um", "inch", "deg", "rad", "N", "kN", "mN", "MN", "Pa", "kPa", "MPa", "GPa", "bar", "psi", "g",
    "kg", "s", "ms", "us", "min", "m/s", "mm/s", "mm/min", "g/m^2", "kg/m^2", "N/mm", "N/m", "1/s",
    "deg/s", "rad/s", "%",
)  # fmt: skip
# What plain numbers are in.
_METRE = Unit("m", (0, 1, 0, 0))
LONGEST_TEXT = 60


def number_of(text: str, row: Row) -> float:
    """``text`` as a number in the unit of a row of the table of quantities; a number without a unit is in that unit.

    Raises:
        ValueError: no number, a unit that is not known, or one of another quantity.
    """
    example = EXAMPLES[row.unit]
    match = _WRITTEN.fullmatch(text) if len(text) <= LONGEST_TEXT else None
    if match is None:
        raise ValueError(f"a number with its unit is needed, such as {example!r}")
    number, written = match["number"], (match["unit"] or "").strip()
    own = _METRE if row.unit == "m/unit" else parse_unit(row.unit) or Unit("1")
    unit = parse_unit(written, strict=True) if written else own
    if unit is None and re.match(r",\d", written):
        raise ValueError(f"decimals need a point, not a comma: write '{number}.{written[1:]}'")
    if unit is None and (meant := as_meant(written, own)):
        raise ValueError(f"{written!r}: capitals count in units, since m is milli and M is mega: write {meant}")
    if unit is None:
        near = difflib.get_close_matches(written, _KNOWN, n=1)
        meant = f"; did you mean {near[0]!r}?" if near else ""
        raise ValueError(f"{written!r} is no unit that is known, write {example!r} or a number in {row.unit}{meant}")
    if unit.dimension != own.dimension:
        raise ValueError(f"{written!r} is no unit of it, write {example!r} or a number in {row.unit}")
    ratio = unit.factor / own.factor
    try:
        value = float(Decimal(number) * _decimal(ratio))
    except (InvalidOperation, OverflowError):
        value = math.inf
    if not math.isfinite(value):
        raise ValueError("a finite number is needed")
    return value


def as_meant(text: str, own: Unit) -> str:
    """The units of the dimension of ``own`` that a text would be with other capitals; "" for none."""
    near = [known for known in _KNOWN if known.lower() == text.lower() and known != text]
    return " or ".join(repr(known) for known in near if (unit := parse_unit(known)) and unit.dimension == own.dimension)


def _decimal(ratio: float) -> Decimal:
    """A ratio of units in as few digits as it has: binary arithmetic may have lost the last of a power of ten."""
    short = f"{ratio:.12g}"
    return Decimal(short) if math.isclose(float(short), ratio, rel_tol=1.0e-15) else Decimal(ratio)


def in_units(value: Any, row: Row) -> Any:
    """``value`` with every text in it, however nested in lists, as a number in the unit of the row.

    Raises:
        ValueError: see ``number_of``.
    """
    if isinstance(value, str):
        return number_of(value, row)
    if isinstance(value, list | tuple):
        return tuple(in_units(item, row) for item in value)
    return value


def unit_option(what: str, text: str | None) -> float | None:
    """``length_unit`` of an option of a command; None where it is not given.

    Raises:
        InputError: no unit of length, with ``what`` it was given for.
    """
    try:
        return None if text is None else length_unit(text)
    except ValueError as error:
        raise InputError(f"{what} {text!r}: {error}") from None


def length_unit(text: str) -> float:
    """Metres per unit, for the unit of a file: "mm", "inch", "m".

    Raises:
        ValueError: no unit of length.
    """
    unit = parse_unit(text, strict=True)
    if unit is None or unit.dimension != _METRE.dimension:
        if found := as_meant(text, _METRE):
            raise ValueError(f"capitals count in units, since m is milli and M is mega: write {found}")
        raise ValueError("a unit of length is needed, such as 'mm', 'cm', 'm' or 'inch'")
    return float(_decimal(unit.factor))
