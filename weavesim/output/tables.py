"""Tables of a run as CSV: history, shear angles at points, draw-in along the outline; and measured ones to compare."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..measures.angles import shear_angle_at
from ..measures.border import border_draw_in, outline
from ..run.frame import Frame, Outcome, RunInfo
from ..sheet.symmetry import WHOLE, Symmetry
from .files import replacing

if TYPE_CHECKING:
    from ..sheet.blank import Blank


def write_table(path: str | Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV with a header line; floats with 9 significant digits."""
    with replacing(Path(path)) as temporary, open(temporary, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows([f"{value:.9g}" if isinstance(value, float) else value for value in row] for row in rows)


# Entries of the ledger that are named after what they are; the others are energies.
_NOT_ENERGIES = ("energy", "work", "loss", "error", "supplied", "used")


class History:
    """Observer that keeps the scalars of every frame and the last frame.

    Attributes:
        tool_names: in the order of the tools.
        last_frame: the latest frame, None before the first.
        index, step_count, time [s], stroke [m]: one per frame.
        tool_displacement: (frame_count, tool_count) [m].
        tool_reaction: force of the sheet on each tool, (frame_count, tool_count, 3) [N].
        energies: by name, (frame_count,) [J].
        support_names, drive_names: in the order of the supports, and of all their drives.
        support_force: of each support on the sheet, (frame_count, support_count, 3) [N].
        drive_displacement, drive_force: (frame_count, drive_count) [m], [N].
    """

    def __init__(self) -> None:
        self.tool_names: list[str] = []
        self.support_names: list[str] = []
        self.drive_names: list[str] = []
        self.last_frame: Frame | None = None
        self._rows: list[tuple] = []

    def start(self, info: RunInfo) -> None:
        self.tool_names = [tool.name for tool in info.tools]
        self.support_names = [support.name for support in info.supports]
        self.drive_names = [f"{s.name}_drive_{k + 1}" for s in info.supports for k in range(len(s.drives))]
        self.last_frame, self._rows = None, []

    def frame(self, frame: Frame) -> None:
        self.last_frame = frame
        self._rows.append(
            (
                frame.index,
                frame.step_count,
                frame.time,
                frame.stroke,
                np.array(frame.tool_displacement, dtype=float),
                np.array(frame.tool_reaction, dtype=float).reshape(-1, 3),
                dict(frame.energies),
                np.array(frame.support_force, dtype=float).reshape(-1, 3),
                np.array(frame.drive_displacement, dtype=float),
                np.array(frame.drive_force, dtype=float),
            )
        )

    def finish(self, outcome: Outcome) -> None:
        """Nothing to close; ``write`` makes the file."""

    @property
    def frame_count(self) -> int:
        return len(self._rows)

    @property
    def index(self) -> np.ndarray:
        return self._column(0)

    @property
    def step_count(self) -> np.ndarray:
        return self._column(1)

    @property
    def time(self) -> np.ndarray:
        return self._column(2)

    @property
    def stroke(self) -> np.ndarray:
        return self._column(3)

    @property
    def tool_displacement(self) -> np.ndarray:
        return self._column(4).reshape(self.frame_count, len(self.tool_names))

    @property
    def tool_reaction(self) -> np.ndarray:
        return self._column(5).reshape(self.frame_count, len(self.tool_names), 3)

    @property
    def energies(self) -> dict[str, np.ndarray]:
        names = self._rows[0][6] if self._rows else {}
        return {name: np.array([row[6].get(name, math.nan) for row in self._rows], dtype=float) for name in names}

    @property
    def support_force(self) -> np.ndarray:
        return self._column(7).reshape(self.frame_count, len(self.support_names), 3)

    @property
    def drive_displacement(self) -> np.ndarray:
        return self._column(8).reshape(self.frame_count, len(self.drive_names))

    @property
    def drive_force(self) -> np.ndarray:
        return self._column(9).reshape(self.frame_count, len(self.drive_names))

    def _column(self, place: int) -> np.ndarray:
        return np.array([row[place] for row in self._rows])

    def write(self, path: str | Path) -> None:
        """Write ``history.csv``: frame, step count, time, stroke; displacement and force of each tool; force of each
        support; displacement and force of each of their drives; every energy.
        """
        energies = self.energies
        header = ["frame", "step_count", "time_s", "stroke_m"]
        for name in self.tool_names:
            header += [f"{name}_displacement_m", *(f"{name}_force_{axis}_n" for axis in "xyz")]
        header += [f"{name}_force_{axis}_n" for name in self.support_names for axis in "xyz"]
        header += [f"{name}_{what}" for name in self.drive_names for what in ("displacement_m", "force_n")]
        header += [f"{name}_j" if name.endswith(_NOT_ENERGIES) else f"{name}_energy_j" for name in energies]
        rows = []
        for i, (index, step_count, time, stroke, displacement, reaction, _, support, way, force) in enumerate(
            self._rows
        ):
            tools = np.column_stack([displacement, reaction]).ravel().tolist() if len(displacement) else []
            supports = [*support.ravel().tolist(), *np.column_stack([way, force]).ravel().tolist()]
            values = (float(values[i]) for values in energies.values())
            rows.append([index, step_count, time, stroke, *tools, *supports, *values])
        write_table(path, header, rows)


def write_shear_angles(
    path: str | Path, blank: Blank, shear_angle: np.ndarray, points: np.ndarray, symmetry: Symmetry = WHOLE
) -> np.ndarray:
    """Write the absolute shear angle at material points by the rule of ``shear_angle_at``; also returned [degrees]."""
    angles = shear_angle_at(blank, shear_angle, points, symmetry)
    rows = [
        [i + 1, 1.0e3 * float(x), 1.0e3 * float(y), float(angle)]
        for i, ((x, y), angle) in enumerate(zip(np.asarray(points), angles, strict=True))
    ]
    write_table(path, ["point", "material_x_mm", "material_y_mm", "shear_angle_deg"], rows)
    return angles


def write_draw_in(path: str | Path, blank: Blank, position: np.ndarray, symmetry: Symmetry = WHOLE) -> None:
    """Write the free border of the computed part, in order: flat and formed, and the draw-in of each node.

    The draw-in is the plan movement of the node against the outward normal of the flat border (at a corner, against
    the mean of the two sides' normals).
    """
    border = outline(blank, symmetry)
    flat, formed = blank.material_coordinates[border.node], position[border.node]
    values = 1.0e3 * np.column_stack([flat, formed, border_draw_in(blank, position, border)])
    header = ["node", "flat_x_mm", "flat_y_mm", "formed_x_mm", "formed_y_mm", "formed_z_mm", "draw_in_mm"]
    write_table(path, header, ([node, *row] for node, row in zip(border.node.tolist(), values.tolist(), strict=True)))


def load_measured_angles(path: str | Path) -> tuple[np.ndarray, np.ndarray]:
    """Measured shear angles from a CSV with the columns point and angle_deg: point numbers (k,), angles (k,) [degrees].

    Raises:
        InputError: missing or unreadable file, missing columns, no rows, or an entry that is not a number.
    """
    table = _load_columns(path, ("point", "angle_deg"))
    numbers, angles = table.T
    if np.any(numbers != np.rint(numbers)) or np.any(numbers < 1) or len(np.unique(numbers)) < len(numbers):
        raise InputError(f"measured angles {path}: point numbers must be whole, from 1, each once; got {numbers}")
    if np.any(np.abs(angles) >= 90.0):
        raise InputError(f"measured angles {path}: {angles[np.argmax(np.abs(angles))]:g} degrees; below 90 is allowed")
    return numbers.astype(int), angles


def load_measured_outline(path: str | Path) -> np.ndarray:
    """A measured outline from a CSV with the columns x_mm and y_mm, in plan view and in order, (k, 2) [m].

    Raises:
        InputError: missing or unreadable file, missing columns, no rows, or an entry that is not a number.
    """
    points = 1.0e-3 * _load_columns(path, ("x_mm", "y_mm"))
    if len(points) < 2:
        raise InputError(f"measured outline {path}: one point only; give two or more, in order along the outline")
    if np.abs(points).max() > 20.0:
        raise InputError(
            f"measured outline {path}: it reaches {np.abs(points).max():g} m from the origin; give millimetres"
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
