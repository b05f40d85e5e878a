"""The frames of a run for ParaView."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

import numpy as np

from ..errors import InputError
from ..measures import yarn_vectors
from ..recording import Frame, Outcome
from .files import replacing, write_text

if TYPE_CHECKING:
    from ..simulation import Simulation

# Wider than the gap between two output frames by its round-off only.
_TIME_SLACK = 1.0e-9


class ParaViewSeries:
    """Observer that writes ``frame_0000.vtu`` ..., ``series.pvd`` with their times, and ``final_state.vtu``.

    Point data: ``displacement`` [m] and ``director``. Cell data: every field of the frame; angles in degrees as
    ``shear_angle_deg``, and the yarn directions. Frames are in single precision, the final state in double. Only the
    computed part is written (ParaView's Reflect filter mirrors it).

    Args:
        folder: made if it is not there; numbered frames of a former run are removed at the start.
        every: write each ``every``-th frame; by default about 30 frames, evenly over the duration.

    Raises:
        InputError: ``every`` below 1.
    """

    def __init__(self, folder: str | Path, every: int | None = None) -> None:
        if every is not None and every < 1:
            raise InputError(f"ParaView series of each {every}-th frame: give 1 or more")
        self.folder = Path(folder)
        self._every = every
        self._last: Frame | None = None

    def start(self, simulation: Simulation) -> None:
        self._blank = simulation.blank
        self._interval = simulation.duration / 30.0
        self._next_time = 0.0
        self._written: list[tuple[float, str]] = []
        self.folder.mkdir(parents=True, exist_ok=True)
        for old in self.folder.glob("frame_[0-9][0-9][0-9][0-9].vtu"):
            old.unlink()

    def frame(self, frame: Frame) -> None:
        self._last = frame
        if self._every is None:
            due = frame.time >= self._next_time - _TIME_SLACK * self._interval
        else:
            due = frame.index % self._every == 0
        if due:
            self._next_time = max(self._next_time + self._interval, frame.time)
            self._add(frame)

    def finish(self, outcome: Outcome) -> None:
        if self._last is None:
            return
        if not self._written or self._written[-1][0] < self._last.time:
            self._add(self._last)
        self._write(self._last, self.folder / "final_state.vtu", np.float64)

    def _add(self, frame: Frame) -> None:
        name = f"frame_{frame.index:04d}.vtu"
        self._write(frame, self.folder / name, np.float32)
        self._written.append((frame.time, name))
        entries = "\n".join(
            f'    <DataSet timestep="{float(time)!r}" file={quoteattr(file)}/>' for time, file in self._written
        )
        write_text(
            self.folder / "series.pvd",
            '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
            f"  <Collection>\n{entries}\n  </Collection>\n</VTKFile>\n",
        )

    def _write(self, frame: Frame, path: Path, real: type) -> None:
        import meshio

        points = {"displacement": frame.position - self._blank.node_position, "director": frame.director}
        cells = {name: values for name, values in frame.fields.items() if name != "shear_angle"}
        cells["shear_angle_deg"] = np.rad2deg(frame.fields["shear_angle"])
        cells["warp_direction"], cells["weft_direction"] = yarn_vectors(self._blank, frame.position)
        mesh = meshio.Mesh(
            frame.position.astype(real),
            [("quad", self._blank.quads)],
            point_data={name: values.astype(real) for name, values in points.items()},
            cell_data={name: [values.astype(real)] for name, values in cells.items()},
        )
        with replacing(path) as temporary:
            meshio.write(temporary, mesh, file_format="vtu", binary=True, compression="zlib")
