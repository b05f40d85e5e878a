"""What is compared, beside distances: fields of the elements, with their units."""

from __future__ import annotations

from ...measures.units import with_unit

# Fields that are compared where both have them: name in files, and whether the sign is left out.
FIELDS = {
    "shear_angle_deg": True, "warp_stretch": False, "weft_stretch": False, "thickness": False,
    "fibre_volume_fraction": False, "warp_force": False, "weft_force": False,
}  # fmt: skip
# Their units; "" for the others, which are pure numbers.
UNITS = {"shear_angle_deg": "degrees", "thickness": "m", "warp_force": "N/m", "weft_force": "N/m"}


def keyed(name: str) -> str:
    """Name of a compared field in files, which ends in its unit: "thickness_m", "shear_angle_deg"."""
    return with_unit(name, UNITS.get(name, "1"))


_NAMES = {keyed(name): name for name in FIELDS}


def titled(key: str) -> str:
    """Name of a compared quantity for readers, with its unit: "shear angle [degrees]", "distance [mm]".

    Args:
        key: with or without its unit.
    """
    key = _NAMES.get(key, key)
    unit = UNITS.get(key, "mm" if key.endswith("_mm") else "")
    name = key.removesuffix("_deg").removesuffix("_mm").replace("_", " ")
    return f"{name} [{unit}]" if unit else name
