"""Measured angles and outlines, for comparison with results."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import InputError
from ..input_files import shown
from ..tables import Wanted, read_table

# A larger number is no number of a point.
LARGEST_POINT = 1_000_000


def load_measured_angles(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Measured shear angles from a table with the columns point and angle: point numbers (k,), angles (k,) [degrees].

    The header says the unit of the angles: "angle_deg", "angle [deg]", "angle [rad]".

    Raises:
        InputError: missing or unreadable file, missing columns, no rows, an entry that is not a number, or angles
            without a unit.
    """
    table = read_table(path, "measured angles")
    columns = table.columns(Wanted("point"), Wanted("angle", unit="deg", needs_unit=True))
    numbers, angles = columns.values
    seen: set[float] = set()
    for number, angle, line in zip(numbers.tolist(), angles.tolist(), columns.lines.tolist(), strict=True):
        place = f"measured angles {shown(path)}, line {line}"
        if number != round(number) or not 1.0 <= number <= LARGEST_POINT or number in seen:
            raise InputError(f"{place}: point {number:g}; point numbers must be integers from 1, each once")
        if abs(angle) >= 90.0:
            raise InputError(f"{place}: {angle:g} degrees; must be below 90")
        seen.add(number)
    return numbers.astype(int), angles


def load_measured_outline(path: str | Path) -> np.ndarray:
    """A measured outline from a table with the columns x and y, in plan view and in order, (k, 2) [m].

    The header says their unit: "x_mm" and "y_mm", "x [mm]" and "y [mm]", "x [m]" and "y [m]".

    Raises:
        InputError: missing or unreadable file, missing columns, no rows, an entry that is not a number, or
            coordinates without a unit.
    """
    wanted = [Wanted(name, unit="m", needs_unit=True) for name in ("x", "y")]
    points = np.column_stack(read_table(path, "measured outline").columns(*wanted).values)
    place = f"measured outline {shown(path)}"
    if len(points) < 2:
        raise InputError(f"{place}: only one point; give two or more, in order along the outline")
    if np.abs(points).max() > 20.0:
        raise InputError(f"{place}: it extends {np.abs(points).max():g} m from the origin; give the right unit")
    return points
