"""Units of numbers in files, and the suffixes for them in names: the only list of both."""

from __future__ import annotations

from typing import NamedTuple


class Unit(NamedTuple):
    """A unit for displaying numbers.

    Attributes:
        ending: of names in files, without the underscore; "" for pure numbers.
        symbol: for readers.
    """

    ending: str
    symbol: str

    def named(self, name: str) -> str:
        """``name`` with the unit: ("draw_in") to "draw_in_mm"."""
        return f"{name}_{self.ending}" if self.ending else name

    def after(self, text: str) -> str:
        """``text`` followed by the unit."""
        return f"{text}{'' if self.symbol in ('', '°') else ' '}{self.symbol}"


PURE = Unit("", "")
DEGREES = Unit("deg", "°")
MILLIMETRES = Unit("mm", "mm")
SECONDS = Unit("s", "s")
JOULES = Unit("j", "J")
NEWTONS = Unit("n", "N")
METRES = Unit("m", "m")
PER_SECOND = Unit("per_second", "1/s")
# Longer endings first: "n_per_m" ends in "m" too.
UNITS = (
    Unit("n_per_m", "N/m"), PER_SECOND, DEGREES, MILLIMETRES, SECONDS, JOULES, NEWTONS, METRES,
    Unit("pa", "Pa"), Unit("kg", "kg"),
)  # fmt: skip


def split_unit(key: str) -> tuple[str, Unit]:
    """Name and unit of a key: "draw_in_mm" to "draw_in" and millimetres; a key without an ending is a pure number."""
    for unit in UNITS:
        if key.endswith(f"_{unit.ending}"):
            return key[: -len(unit.ending) - 1], unit
    return key, PURE
