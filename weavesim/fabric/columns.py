"""Columns of test tables in fabric files: ``{csv = "test.csv", column = "force"}`` in place of a list of numbers."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..checks import Parameters
from ..errors import InputError, did_you_mean
from ..input_files import shown, within_folder
from ..tables import Table, Wanted, read_table

NAMES = ("csv", "column", "scale")
# Units of what the constructors of laws take; a field's unit stands in its description.
_UNITS = {"angle": "rad", "machine_force": "N", "force_per_length": "N/m", "curvature": "1/m"}
# What is measured as a loop has the unit of the field that it becomes.
_OF_LOOP = {"loading": ("moment_values", "limit"), "unloading": ("moment_values", "limit")}


def is_reference(value: Mapping[str, Any]) -> bool:
    """True for a table that is meant as a reference to a column."""
    return "csv" in value or ("column" in value and "kind" not in value)


class ColumnReader:
    """Reads the columns that a fabric file refers to; each table is read once.

    Attributes:
        notes: what was not obvious in reading them, for the ``source`` of the fabric.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._tables: dict[Path, Table] = {}
        self.notes: list[str] = []

    def read(self, value: Mapping[str, Any], unit: str) -> tuple[float, ...]:
        """The numbers of a column in ``unit``, or as they stand there if the unit is not known.

        Raises:
            InputError: unknown names, a file out of the folder or one that cannot be read in exactly one way.
        """
        for key in value:
            if key not in NAMES:
                raise InputError(f"{shown(key)}: unknown name{did_you_mean(str(key), NAMES) or _NEEDED}")
        if "csv" not in value or "column" not in value:
            raise InputError(f"{sorted(value)} are given{_NEEDED}")
        column, scale = value["column"], value.get("scale")
        if not isinstance(column, str) or not re.search(r"\w", column):
            raise InputError(f"column = {column!r}: the name of a column is needed, as a text")
        if scale is not None and (
            isinstance(scale, bool) or not isinstance(scale, int | float) or not math.isfinite(scale) or scale == 0.0
        ):
            raise InputError(f"scale = {scale!r}: a finite number other than 0 is needed")
        path = within_folder(self._folder, value["csv"], "csv")
        if path not in self._tables:
            self._tables[path] = read_table(path, "table")
        columns = self._tables[path].columns(Wanted(column, unit, None if scale is None else float(scale)))
        for note in columns.notes:
            text = f"{shown(path.name)}: {note}"
            if text not in self.notes:
                self.notes.append(text)
        return tuple(columns.values[0].tolist())


_NEEDED = "; a column needs csv and column, optionally scale"


def unit_of(owner: type[Parameters] | None, name: str) -> str:
    """Unit in which a field of ``owner``, or an argument of one of its constructors, is needed; "" if not known."""
    fields = owner.model_fields if owner else {}
    for field in (name, *_OF_LOOP.get(name, ())):
        if field in fields:
            match = re.search(r"\[([^\[\]]+)\]\s*$", fields[field].description or "")
            return match[1] if match else ""
    return _UNITS.get(name, "")
