"""Tables of a formed sheet as CSV: shear angles at points, and the draw-in along its outline."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..measures.findings import FormedSheet
from .files import replacing


def write_table(path: str | Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV with a header line; floats with 9 significant digits."""
    with replacing(Path(path)) as temporary, open(temporary, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows([f"{value:.9g}" if isinstance(value, float) else value for value in row] for row in rows)


def write_shear_angles(path: str | Path, sheet: FormedSheet) -> None:
    """Write the absolute shear angle at the material points of the sheet, at least one."""
    rows = [
        [i + 1, 1.0e3 * float(x), 1.0e3 * float(y), float(angle)]
        for i, ((x, y), angle) in enumerate(zip(np.asarray(sheet.points), sheet.point_angles_deg, strict=True))
    ]
    write_table(path, ["point", "material_x_mm", "material_y_mm", "shear_angle_deg"], rows)


def write_sheets(path: str | Path, findings: Mapping[str, Mapping[str, Any]]) -> None:
    """Write the numbers of several sheets side by side, one line each; what a sheet has not is left empty.

    Args:
        path: of the file.
        findings: numbers by key, by the name of the sheet.
    """
    names = [key for own in findings.values() for key, value in own.items() if isinstance(value, int | float)]
    header = list(dict.fromkeys(names))
    write_table(
        path, ["sheet", *header], ([name, *(own.get(key, "") for key in header)] for name, own in findings.items())
    )


def write_draw_in(path: str | Path, sheet: FormedSheet) -> None:
    """Write the free border of the computed part in order: flat and formed positions, and draw-in of each node.

    The draw-in is the in-plan displacement of the node against the outward normal of the flat border (at a corner,
    against the mean of the two sides' normals). Nodes of a user's mesh have their number there too.
    """
    node = sheet.border.node
    lengths = 1.0e3 * np.column_stack([sheet.blank.material_coordinates[node], sheet.position[node]])
    values = np.column_stack([lengths, sheet.border_draw_in_mm])
    header = ["node", "flat_x_mm", "flat_y_mm", "formed_x_mm", "formed_y_mm", "formed_z_mm", "draw_in_mm"]
    names = node[:, None]
    if (numbers := sheet.blank.node_number) is not None:
        names, header = np.column_stack([node, numbers[node]]), ["node", "node_number", *header[1:]]
    write_table(path, header, ([*n, *row] for n, row in zip(names.tolist(), values.tolist(), strict=True)))
