"""Element fields of frames, each defined once: meaning, unit, and form in files.

Rows that kernels write are described in ``kernels/rows.py``; fields that the host derives from them are defined here.
Frames, film, ParaView files and docs read this list. To add a field, add a row there or a ``Field`` here, or call
``add_field`` from your own code.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..kernels.rows import ElementField
from ..measures.defects.waves import WAVELENGTH_OF_FRAMES

if TYPE_CHECKING:
    from ..fabric.fabric import Fabric

# A cell has failed if its residual ever exceeds this share of the forces that it balances.
UNIT_CELL_FAILURE = 1.0e-3

Values = Mapping[str, np.ndarray]
# Computes a field from the fabric, the fields before it, and the report of the unit cells; None if not applicable.
Derivation = Callable[["Fabric", Values, Values], np.ndarray | None]


@dataclass(frozen=True)
class Field:
    """One value per element.

    Attributes:
        name: in frames, where it has SI units.
        unit: in frames; "1" for a pure number.
        description: for readers.
        derive: computes it on the host; None for a row that a kernel writes.
        diagnostic: it tells of the solver, not of the fabric: left out of films and of the frames for ParaView.
    """

    name: str
    unit: str
    description: str
    derive: Derivation | None = None
    diagnostic: bool = False

    @property
    def file_name(self) -> str:
        """Name in files, where angles are in degrees and named accordingly."""
        return f"{self.name}_deg" if self.unit == "rad" else self.name

    @property
    def file_unit(self) -> str:
        """Unit in files."""
        return "degrees" if self.unit == "rad" else self.unit

    def in_file(self, values: np.ndarray) -> np.ndarray:
        """``values`` in the unit of files."""
        return np.rad2deg(values) if self.unit == "rad" else values


def _thickness(fabric: Fabric, fields: Values, report: Values) -> np.ndarray:
    ratio = fabric.compaction.thickness_ratio(fabric.unit_cell, fields["area_ratio"], fields["crossover_pressure"])
    return fabric.thickness * ratio


def _fibre_volume_fraction(fabric: Fabric, fields: Values, report: Values) -> np.ndarray | None:
    return fabric.compaction.fibre_volume_fraction(fields["thickness"], fields["area_ratio"])


def _crossover_force(fabric: Fabric, fields: Values, report: Values) -> np.ndarray | None:
    area = fabric.unit_cell.crossover_area
    return fields["crossover_pressure"] * area if area > 0.0 else None


def _failed(fabric: Fabric, fields: Values, report: Values) -> np.ndarray:
    return (~(report["worst_residual"] < UNIT_CELL_FAILURE)).astype(np.float64)


def _of_contact(fabric: Fabric, fields: Values, report: Values) -> None:
    """The ledgers of sheets and interfaces add these."""


FIELDS: list[Field] = [
    *(Field(row.name, row.unit, row.description) for row in ElementField),
    Field("thickness", "m", "current thickness", _thickness),
    Field(
        "fibre_volume_fraction", "1", "share of the fibres in the volume, if the fabric states its fibre content",
        _fibre_volume_fraction,
    ),
    Field("crossover_force", "N", "force of a crossover, if the unit cell has an area of one", _crossover_force),
    Field(
        "unit_cell_residual", "1", "worst residual of the unit cell so far, over the forces that it balances",
        lambda fabric, fields, report: report["worst_residual"], diagnostic=True,
    ),
    Field(
        "unit_cell_iterations", "1", "iterations of the unit cell in this step",
        lambda fabric, fields, report: report["iterations"], diagnostic=True,
    ),
    Field(
        "unit_cell_failed", "1", f"1 where that residual is not below {UNIT_CELL_FAILURE:g}, else 0", _failed,
        diagnostic=True,
    ),
    Field(
        "tool_pressure_below", "Pa",
        "pressure of the tools on the side from which the normal points, on the current area", _of_contact,
    ),
    Field(
        "tool_pressure_above", "Pa",
        "pressure of the tools on the side to which the normal points, on the current area", _of_contact,
    ),
    Field("tool_friction_below", "Pa", "friction of the tools below over the same area", _of_contact),
    Field("tool_friction_above", "Pa", "friction of the tools above over the same area", _of_contact),
    Field(
        "tool_gap", "m",
        "from the face of the sheet, at the thickness of contact, to the nearest tool; negative inside",
        _of_contact,
    ),
    Field(
        "wrinkle_height", "m",
        f"of out-of-plane waves up to {WAVELENGTH_OF_FRAMES:g} m long, from trough to crest, across yarns that are "
        "shortened; bends of a free sheet as short as that are in it",
        _of_contact,
    ),
    Field("ply_pressure_below", "Pa", "pressure of the ply below, if there is an interface", _of_contact),
    Field("ply_pressure_above", "Pa", "pressure of the ply above", _of_contact),
    Field("ply_slip_below", "m", "way slid so far on the ply below", _of_contact),
    Field("ply_slip_above", "m", "way slid so far under the ply above", _of_contact),
]  # fmt: skip


def add_field(field: Field) -> Field:
    """Add your own field to all frames and files of this process, after the others.

    Raises:
        InputError: a field of this name exists, or ``derive`` is missing.
    """
    if field.derive is None:
        raise InputError(f"field {field.name}: derive is missing; only rows of a kernel have none")
    if field.name in {other.name for other in FIELDS}:
        raise InputError(f"field {field.name}: one of this name exists; choose another name")
    FIELDS.append(field)
    return field


def complete(fabric: Fabric, rows: Values, report: Values) -> dict[str, np.ndarray]:
    """All fields of a sheet in SI units, by name, (element_count,) each.

    Args:
        fabric: of the sheet.
        rows: written by the kernel, by names of ``ElementField``.
        report: of the unit cells, by names of ``CellReportRow``.
    """
    fields = dict(rows)
    for field in FIELDS:
        value = field.derive(fabric, fields, report) if field.derive else None
        if value is not None:
            fields[field.name] = value
    return fields
