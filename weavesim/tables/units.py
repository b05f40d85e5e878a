"""Units as they stand in the headers of tables, and their factors to SI."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

# Powers of angle, length, mass and time. Angles count as a dimension, so that degrees are never taken for a number.
Dimension = tuple[int, int, int, int]
_NONE, _ANGLE, _LENGTH, _MASS, _TIME = (0, 0, 0, 0), (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)
_FORCE, _PRESSURE, _MOMENT = (0, 1, 1, -2), (0, -1, 1, -2), (0, 2, 1, -2)
_GRAVITY, _POUND, _INCH = 9.80665, 0.45359237, 0.0254

_SYMBOLS: dict[str, tuple[Dimension, float]] = {
    "rad": (_ANGLE, 1.0), "mrad": (_ANGLE, 1e-3), "°": (_ANGLE, math.pi / 180.0), "gon": (_ANGLE, math.pi / 200.0),
    "m": (_LENGTH, 1.0), "dm": (_LENGTH, 0.1), "cm": (_LENGTH, 1e-2), "mm": (_LENGTH, 1e-3), "µm": (_LENGTH, 1e-6),
    "nm": (_LENGTH, 1e-9), "in": (_LENGTH, _INCH), "ft": (_LENGTH, 12.0 * _INCH),
    "kg": (_MASS, 1.0), "g": (_MASS, 1e-3), "mg": (_MASS, 1e-6),
    "s": (_TIME, 1.0), "ms": (_TIME, 1e-3), "µs": (_TIME, 1e-6), "ns": (_TIME, 1e-9),
    "min": (_TIME, 60.0), "h": (_TIME, 3600.0),
    "N": (_FORCE, 1.0), "mN": (_FORCE, 1e-3), "cN": (_FORCE, 1e-2), "daN": (_FORCE, 10.0), "kN": (_FORCE, 1e3),
    "MN": (_FORCE, 1e6), "gf": (_FORCE, 1e-3 * _GRAVITY), "kgf": (_FORCE, _GRAVITY), "kp": (_FORCE, _GRAVITY),
    "lbf": (_FORCE, _POUND * _GRAVITY),
    "Pa": (_PRESSURE, 1.0), "hPa": (_PRESSURE, 1e2), "kPa": (_PRESSURE, 1e3), "MPa": (_PRESSURE, 1e6),
    "GPa": (_PRESSURE, 1e9), "bar": (_PRESSURE, 1e5),
    "psi": (_PRESSURE, _POUND * _GRAVITY / _INCH**2), "ksi": (_PRESSURE, 1e3 * _POUND * _GRAVITY / _INCH**2),
    "Nm": (_MOMENT, 1.0), "Nmm": (_MOMENT, 1e-3), "Ncm": (_MOMENT, 1e-2), "kNm": (_MOMENT, 1e3),
    "mNm": (_MOMENT, 1e-3),
    "%": (_NONE, 1e-2), "1": (_NONE, 1.0), "-": (_NONE, 1.0),
}  # fmt: skip
LONGEST_NAME = 200
# Other ways to write them; those in lower case are accepted in any case.
_WRITTEN = {
    "deg": "°", "degs": "°", "degree": "°", "degrees": "°", "º": "°", "˚": "°", "degré": "°", "degrés": "°",
    "grado": "°", "grados": "°", "gradi": "°", "Grad": "°", "radian": "rad", "radians": "rad", "um": "µm", "μm": "µm",
    "us": "µs", "μs": "µs",
    "micron": "µm", "microns": "µm", "inch": "in", "inches": "in", "meter": "m", "metre": "m", "meters": "m",
    "metres": "m", "millimeter": "mm", "millimetre": "mm", "millimeters": "mm", "millimetres": "mm", "newton": "N",
    "newtons": "N", "kilonewton": "kN", "kilonewtons": "kN", "sec": "s", "secs": "s", "sek": "s", "second": "s",
    "seconds": "s", "minutes": "min", "kn": "kN", "kpa": "kPa", "gpa": "GPa", "mpa": "MPa", "mm": "mm", "rad": "rad",
    "percent": "%",
}  # fmt: skip
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_FACTOR = re.compile(r"(?P<symbol>[^\W\d_]+|[°º˚]|%|-|1)(?:\^?(?P<power>[+-]?[1-9]))?")
# At the end of a name, after an underscore; a single letter may mean anything ("force_m" is a mean).
_SUFFIX = re.compile(r"(?P<name>.+)_(?P<unit>[^\W\d_]+)")
_SUFFIXES = {"deg", "rad", "mrad", "kn", "mN", "MN", "cN", "mm", "cm", "um", "kpa", "mpa", "gpa", "ms"}
_PER_LENGTH = re.compile(r"(?P<name>.+)_(?P<unit>k?n)_per_(?P<length>m|cm|mm)", re.IGNORECASE)
_BRACKETS = re.compile(r"(?P<name>.*\S)\s*(?:\[(?P<a>[^\[\]]*)\]|\((?P<b>[^()]*)\)|\{(?P<c>[^{}]*)\}|<(?P<d>[^<>]*)>)")
_WHOLE_BRACKETS = re.compile(r"\[([^\[\]]*)\]|\(([^()]*)\)|\{([^{}]*)\}|<([^<>]*)>")


@dataclass(frozen=True)
class Unit:
    """A unit, as written. ``is_known`` is False for text in brackets that is no unit known here."""

    text: str
    dimension: Dimension = _NONE
    factor: float = 1.0
    is_known: bool = True

    def same_as(self, other: Unit) -> bool:
        """True for two ways to write one unit."""
        if not (self.is_known and other.is_known):
            return self.text.strip() == other.text.strip()
        return self.dimension == other.dimension and math.isclose(self.factor, other.factor)


def parse_unit(text: str, *, strict: bool = False) -> Unit | None:
    """The unit that ``text`` is, such as "kN", "N/mm", "N·m/m", "gf·cm²/cm", "1/m" or "mm^-1"; None if it is none.

    Args:
        text: as written.
        strict: capitals count in symbols, since m is milli and M mega, k kilo and K kelvin. Laboratories write them in
            any case.
    """
    rest = text.strip().translate(_SUPERSCRIPTS).replace("**", "^").removesuffix(".")
    if not rest or rest == "1" or len(rest) > 40:
        return None
    powers, factor = [0, 0, 0, 0], 1.0
    for index, part in enumerate(rest.split("/")):
        symbols = re.split(r"\s*[·⋅*×.]\s*|\s+", part.strip())
        for symbol in symbols:
            match = _FACTOR.fullmatch(symbol)
            known = _symbol(match["symbol"], strict) if match else None
            if match is None or known is None:
                return None
            power = int(match["power"] or 1) * (-1 if index else 1)
            powers = [p + power * q for p, q in zip(powers, known[0], strict=True)]
            factor *= known[1] ** power
    return Unit(text.strip(), (powers[0], powers[1], powers[2], powers[3]), factor)


def split_header(header: str) -> tuple[str, Unit | None]:
    """Name and unit of a column: from "force [kN]", "force (kN)", "force / kN", "force in kN", "force, kN", "force_kn",
    "force_n_per_mm".

    Other text in brackets stays part of the name, with a unit that is not known.
    """
    text = " ".join(header.split())
    if len(text) > LONGEST_NAME:
        return text, None
    if match := _BRACKETS.fullmatch(text):
        inside = next(part for part in match.group("a", "b", "c", "d") if part is not None)
        unit = parse_unit(inside)
        return (match["name"], unit) if unit else (text, Unit(inside, is_known=False))
    for mark in (r"\s*/\s*", r"\s+in\s+", r"\s*,\s*"):
        for found in re.finditer(mark, text):
            unit = parse_unit(text[found.end() :])
            if found.start() and unit:
                return text[: found.start()], unit
    if text[:-1].strip() and text[-1] in "°º˚":
        return text[:-1].strip(), parse_unit(text[-1])
    if match := _PER_LENGTH.fullmatch(text):
        return match["name"], parse_unit(f"{'kN' if len(match['unit']) > 1 else 'N'}/{match['length'].lower()}")
    if (match := _SUFFIX.fullmatch(text)) and match["unit"] == "mn":  # milli or mega
        return text, Unit("mn", is_known=False)
    if (match := _SUFFIX.fullmatch(text)) and (match["unit"] in _SUFFIXES or match["unit"].lower() in _SUFFIXES):
        return match["name"], parse_unit(match["unit"])
    return text, None


def bare_name(header: str) -> str:
    """The name without what may be a unit, known or not."""
    name, unit = split_header(header)
    if unit is None or unit.is_known or len(name) > LONGEST_NAME:
        return name
    match = _BRACKETS.fullmatch(name) or _SUFFIX.fullmatch(name)
    return match["name"] if match else name


def unit_cell(cell: str) -> Unit | None:
    """The unit in a cell of a line of units, with or without brackets; None if it is none."""
    text = cell.strip()
    if match := _WHOLE_BRACKETS.fullmatch(text):
        inside = next(part for part in match.groups() if part is not None)
        return parse_unit(inside) or Unit(inside, is_known=False)
    return parse_unit(text)


def _symbol(text: str, strict: bool) -> tuple[Dimension, float] | None:
    if text in _SYMBOLS:
        return _SYMBOLS[text]
    written = _WRITTEN.get(text) or (_WRITTEN.get(text.lower()) if text != "mPa" else None)
    if strict and written is not None and (written.lower() == text.lower() or (len(text) < 3 and text not in _WRITTEN)):
        return None  # "MM", "kn", "uM"; a whole word may have any capitals
    return _SYMBOLS[written] if written else None
