"""Measured angles and outlines, for comparison with results."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..errors import InputError


def load_measured_angles(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Measured shear angles from a CSV with the columns point and angle_deg: point numbers (k,), angles (k,) [degrees].

    Raises:
        InputError: missing or unreadable file, missing columns, no rows, or an entry that is not a number.
    """
    table = _load_columns(path, ("point", "angle_deg"))
    numbers, angles = table.T
    if np.any(numbers != np.rint(numbers)) or np.any(numbers < 1) or len(np.unique(numbers)) < len(numbers):
        raise InputError(f"measured angles {path}: point numbers must be integers from 1, each once; got {numbers}")
    if np.any(np.abs(angles) >= 90.0):
        raise InputError(f"measured angles {path}: {angles[np.argmax(np.abs(angles))]:g} degrees; must be below 90")
    return numbers.astype(int), angles


def load_measured_outline(path: str | Path) -> np.ndarray:
    """A measured outline from a CSV with the columns x_mm and y_mm, in plan view and in order, (k, 2) [m].

    Raises:
        InputError: missing or unreadable file, missing columns, no rows, or an entry that is not a number.
    """
    points = 1.0e-3 * _load_columns(path, ("x_mm", "y_mm"))
    if len(points) < 2:
        raise InputError(f"measured outline {path}: only one point; give two or more, in order along the outline")
    if np.abs(points).max() > 20.0:
        raise InputError(
            f"measured outline {path}: it extends {np.abs(points).max():g} m from the origin; give millimetres"
        )
    return points


def _load_columns(path: str | Path, names: Sequence[str]) -> np.ndarray:
    wanted = ",".join(names)
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            reader = csv.DictReader(file, skipinitialspace=True)
            given = [(name or "").strip() for name in reader.fieldnames or []]
            if missing := [name for name in names if name not in given]:
                raise InputError(
                    f"measured data {path}: no column {', '.join(missing)} among {given}; "
                    f"the first line must be {wanted}"
                )
            reader.fieldnames = given
            table = []
            for row in reader:
                entries = [row[name] for name in names]
                if not any(str(entry or "").strip() for entry in entries):
                    continue
                try:
                    table.append([float(entry) for entry in entries])
                except (TypeError, ValueError):
                    table.append([math.nan])
                if not all(map(math.isfinite, table[-1])):
                    raise InputError(f"measured data {path}, line {reader.line_num}: {entries} are not finite numbers")
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"measured data {path}: cannot be read ({reason}); give a CSV file with {wanted}") from None
    if not table:
        raise InputError(f"measured data {path}: no rows below the header {wanted}")
    return np.array(table)
