"""Units of exported decks: structural codes have none, so that a deck is in one consistent system."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class UnitSystem:
    """Factors that convert SI values.

    Attributes:
        name: as typed.
        text: for comments.
        length: units per metre.
        stress: units per pascal.
        density: units per kg/m^3.
    """

    name: str
    text: str
    length: float
    stress: float
    density: float

    @property
    def metres(self) -> float:
        """Metres per unit of length."""
        return 1.0 / self.length


UNITS = {
    "m": UnitSystem("m", "m, N, kg, s, Pa", 1.0, 1.0, 1.0),
    "mm": UnitSystem("mm", "mm, N, t, s, MPa", 1.0e3, 1.0e-6, 1.0e-12),
}
