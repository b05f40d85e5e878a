"""Sheets in the series for ParaView."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...measures.angles import yarn_angles, yarn_components, yarn_vectors
from ...measures.stresses import STRESS_FIELDS, stress_fields
from ...measures.units import with_unit
from ...run.fields import FIELDS
from ...run.frame import SheetFrame, SheetInfo
from ...run.staging.part import Part
from .files import Grid


class SheetFiles:
    """Files of one sheet: the whole part in every frame, and the computed part at the end.

    Args:
        folder: for the files.
        run_id: of the run.
        place: of the sheet in the run.
        file_name: of the sheet in the names of files.
        info: of the sheet.
        shift: along z, for an exploded view [m].
        several: whether the run has others.
        diagnostics: whether frames have the fields of the solver.
    """

    def __init__(
        self,
        folder: Path,
        run_id: str,
        place: int,
        file_name: str,
        info: SheetInfo,
        shift: float,
        several: bool,
        diagnostics: bool,
    ) -> None:
        self._folder, self._run_id, self._file_name = folder, run_id, file_name
        self._symmetry, self._fabric = info.symmetry, info.fabric
        self.name, self._place, self._shift, self._several = info.name, place, shift, several
        self._diagnostics = diagnostics
        self._copies = len(self._symmetry.mirror_factors)
        self._info = info
        self._see(Part(info, np.zeros(0, dtype=bool)))

    def _see(self, part: Part) -> None:
        """Write a part of the sheet from now on: what a stage has left of it."""
        self._part, self._blank = part, part.info.blank
        self._yarn_components = yarn_components(self._blank)
        self._whole = self._grid(whole=True, real=np.float32)

    def _there(self, frame: SheetFrame) -> SheetFrame:
        """A frame without what has been trimmed."""
        if not self._part.holds(frame):
            self._see(Part(self._info, frame.kept))
        return self._part.of(frame)[1]

    def _grid(self, *, whole: bool, real: type) -> Grid:
        """Elements, with what does not change."""
        blank = self._blank
        copies = self._symmetry.mirror_factors if whole else ((1, 1),)
        # a mirror turns elements over
        quads = [
            (blank.quads if np.prod(factors) > 0 else blank.quads[:, ::-1]) + k * blank.node_count
            for k, factors in enumerate(copies)
        ]
        flat = self._symmetry.mirrored(blank.node_position) if whole else blank.node_position
        points: dict[str, np.ndarray] = {"flat_coordinates_m": flat.astype(real)}
        cells: dict[str, np.ndarray] = {}
        if blank.node_number is not None:
            points["node_number"] = np.tile(blank.node_number, len(copies))
        if blank.element_number is not None:
            cells["element_number"] = np.tile(blank.element_number, len(copies))
        if whole and len(copies) > 1:
            cells["mirrored"] = np.repeat(np.arange(len(copies)) > 0, blank.element_count).astype(np.uint8)
        if self._several:
            points["exploded_m"] = np.tile(np.array([0.0, 0.0, self._shift], dtype=real), (len(flat), 1))
            cells["sheet"] = np.full(len(copies) * blank.element_count, self._place, dtype=np.int32)
        return Grid(np.concatenate(quads), cells, points)

    def write(self, frame: SheetFrame, stem: str) -> str:
        """Write the whole part in single precision; returns the name of the file."""
        frame = self._there(frame)
        points = {"displacement_m": self._mirrored(frame.position - self._blank.node_position)}
        fields = self._fields(frame, diagnostics=self._diagnostics)
        rows = np.array(list(fields.values()), dtype=np.float32)
        cells = dict(zip(fields, np.tile(rows, self._copies), strict=True))
        for name, vectors in self._directions(frame).items():
            cells[name] = self._mirrored(vectors)
        file = f"{stem}_{self._file_name}.vtu"
        self._whole.write(self._folder / file, self._mirrored(frame.position), points, cells, self._run_id)
        return file

    def _mirrored(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors (n, 3) of all copies in single precision; signs change no digit, so rounding comes first."""
        return self._symmetry.mirrored(vectors.astype(np.float32))

    def write_final(self, frame: SheetFrame, file: str) -> None:
        """Write the computed part in double precision, with everything that is known of it."""
        frame = self._there(frame)
        blank = self._blank
        cells = self._fields(frame, diagnostics=True)
        angles = np.rad2deg(yarn_angles(blank, frame.position))
        cells |= dict(zip(("warp_angle_deg", "weft_angle_deg"), angles, strict=True))
        cells |= self._directions(frame)
        if frame.resultants:
            stresses = stress_fields(
                blank, self._fabric, frame.position, frame.director, frame.fields, frame.resultants
            )
            cells |= {with_unit(name, STRESS_FIELDS[name][0]): values for name, values in stresses.items()}
        points = {"displacement_m": frame.position - blank.node_position, "director": frame.director}
        points = {name: values.astype(np.float64) for name, values in points.items()}
        cells = {name: values.astype(np.float64) for name, values in cells.items()}
        grid = self._grid(whole=False, real=np.float64)
        grid.write(self._folder / file, frame.position.astype(np.float64), points, cells, self._run_id)

    def _fields(self, frame: SheetFrame, *, diagnostics: bool) -> dict[str, np.ndarray]:
        """Fields by their names in the series."""
        fields: Mapping[str, np.ndarray] = frame.fields
        found = {
            with_unit(field.file_name, field.file_unit): field.in_file(fields[field.name])
            for field in FIELDS
            if field.name in fields and (diagnostics or not field.diagnostic)
        }
        known = {field.name for field in FIELDS}
        return found | {name: values for name, values in fields.items() if name not in known}

    def _directions(self, frame: SheetFrame) -> dict[str, np.ndarray]:
        vectors = yarn_vectors(self._blank, frame.position, self._yarn_components)
        return dict(zip(("warp_direction", "weft_direction"), vectors, strict=True))
