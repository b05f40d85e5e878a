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
SQUARE_MILLIMETRES = Unit("mm2", "mm²")
# Longer endings first: "n_per_m" ends in "m" too.
UNITS = (
    Unit("n_per_m", "N/m"), Unit("n_m", "N m"), Unit("n_s", "N s"), PER_SECOND, SQUARE_MILLIMETRES, Unit("m2", "m²"),
    DEGREES, MILLIMETRES, SECONDS, JOULES, NEWTONS, METRES,
    Unit("pa", "Pa"), Unit("kg", "kg"), Unit("g", "g"), Unit("percent", "%"),
)  # fmt: skip


def split_unit(key: str) -> tuple[str, Unit]:
    """Name and unit of a key: "draw_in_mm" to "draw_in" and millimetres; a key without an ending is a pure number."""
    for unit in UNITS:
        if key.endswith(f"_{unit.ending}"):
            return key[: -len(unit.ending) - 1], unit
    return key, PURE


def with_unit(name: str, unit: str) -> str:
    """The name of a field with its unit, of which the name may have an ending already.

    Args:
        name: of a field, such as "warp_force" or "shear_angle_deg".
        unit: as fields have it: "N/m" gives "warp_force_n_per_m"; "1" is a pure number.
    """
    if unit in ("1", ""):
        return name
    ending = _ENDINGS.get(unit) or unit.lower().replace("/", "_per_").replace("^", "")
    return name if name.endswith(f"_{ending}") else f"{name}_{ending}"


# Of units that fields have, where they are not the unit in small letters.
_ENDINGS = {"degrees": "deg", "N/m^2": "pa"}
