"""Fields of the elements as the page shows them: label, unit for readers, scale."""

from __future__ import annotations

from dataclasses import dataclass

from ...run.fields import FIELDS

# Unit in frames -> unit for readers, and the factor between them.
_READABLE = {
    "rad": ("°", 57.29577951308232),
    "m": ("mm", 1.0e3),
    "Pa": ("kPa", 1.0e-3),
    "N/m^2": ("kPa", 1.0e-3),
    "1/m": ("1/m", 1.0),
    "1": ("", 1.0),
}
# What readers ask for first.
_FIRST = (
    "shear_angle",
    "thickness",
    "fibre_volume_fraction",
    "warp_stretch",
    "weft_stretch",
    "warp_force",
    "weft_force",
    "tool_pressure_below",
    "tool_pressure_above",
    "tool_gap",
    "wrinkle_height",
)
_LAST = ("unit_cell_residual", "unit_cell_failed")


@dataclass(frozen=True)
class ShownField:
    """A field in the menu of the page.

    Attributes:
        name: as in frames.
        label: for readers.
        unit: for readers; "" for a pure number.
        factor: from the unit of frames to that for readers.
        description: one sentence.
        absolute: colours show its size, without sign.
        logarithmic: whether it spreads over decades.
        last_only: whether only the last frame has it.
    """

    name: str
    label: str
    unit: str
    factor: float
    description: str
    absolute: bool = False
    logarithmic: bool = False
    last_only: bool = False

    def as_dict(self) -> dict[str, object]:
        """For the page."""
        return {
            "name": self.name, "label": self.label, "unit": self.unit, "description": self.description,
            "absolute": self.absolute, "logarithmic": self.logarithmic, "lastOnly": self.last_only,
        }  # fmt: skip


def _shown(name: str, unit: str, description: str) -> ShownField:
    readable, factor = _READABLE.get(unit, (unit, 1.0))
    return ShownField(
        name, name.replace("_", " "), readable, factor, description,
        absolute=name == "shear_angle", logarithmic=name == "unit_cell_residual",
    )  # fmt: skip


def shown_field(name: str) -> ShownField:
    """How a field of frames is shown."""
    for field in FIELDS:
        if field.name == name:
            return _shown(name, field.unit, field.description)
    return _shown(name, "", "")


# What the judgement of the formed sheet adds, at the last frame.
JUDGED_FIELDS = (
    ShownField("wrinkle_amplitude", "wrinkle amplitude", "mm", 1.0e3,
               "half the height of a wave from trough to crest, as the verdict takes it", last_only=True),
    ShownField("wrinkle_wavelength", "wavelength", "mm", 1.0e3, "length of these waves", last_only=True),
    ShownField("self_contact_gap", "gap to the sheet itself", "mm", 1.0e3,
               "between the surfaces of parts of the sheet that lie on each other; no value where none is near",
               last_only=True),
)  # fmt: skip


def in_order(names: list[str]) -> list[str]:
    """Names of fields in the order of the menu."""
    first = [name for name in _FIRST if name in names]
    last = [name for name in _LAST if name in names]
    return [*first, *(name for name in names if name not in (*first, *last)), *last]
