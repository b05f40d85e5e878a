"""The frames of a run for ParaView."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np

from ..errors import InputError
from ..measures.angles import yarn_angles, yarn_components, yarn_vectors
from ..measures.stresses import stress_fields
from ..run.fields import in_files
from ..run.frame import Frame, Outcome, RunInfo, SheetFrame, SheetInfo
from .files import file_endings, replacing, write_text

_VTK_QUAD = 9
_VTK_TYPES = {"float32": "Float32", "float64": "Float64", "int32": "Int32", "uint8": "UInt8"}
_BYTE_ORDER = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
# Between the sheets of an exploded view, over the largest blank.
_GAP_TO_SIZE = 0.15
# A tolerance for the rounding of frame times.
_TIME_SLACK = 1.0e-9


class ParaViewSeries:
    """Observer that writes ``frame_0000.vtu`` ..., ``series.pvd`` with their times, and ``final_state.vtu``.

    With several sheets, each has its own files, ``frame_0000_NAME.vtu`` ..., which are the named blocks of
    ``frame_0000.vtm`` ... and ``final_state.vtm``; the series consists of these. Two more fields serve to tell sheets
    apart: cell data ``sheet``, their number, and point data ``exploded`` [m], from which Warp By Vector makes an
    exploded view.

    Point data: ``displacement`` [m] and ``director``. Cell data: every field of the frame, with its name and unit in
    files (``weavesim.run.fields``), and the yarn directions ``warp_direction`` and ``weft_direction``. Frames are in
    single precision; the final state is in double, and has stresses (``STRESS_FIELDS``) and the angles of the yarns in
    each element's own frame. Only the computed part is written (ParaView's Reflect filter mirrors
    it).

    Args:
        folder: created if necessary; numbered frames of a previous run are removed at the start.
        every: write every ``every``-th frame; by default about 30 frames, evenly over the duration.

    Raises:
        InputError: ``every`` below 1.
    """

    def __init__(self, folder: str | Path, every: int | None = None) -> None:
        if every is not None and every < 1:
            raise InputError(f"ParaView series: every = {every}; give 1 or more")
        self.folder = Path(folder)
        self._every = every
        self._last: Frame | None = None

    def start(self, info: RunInfo) -> None:
        names = file_endings(info)
        gap = _GAP_TO_SIZE * max(sheet.blank.size for sheet in info.sheets)
        shifts = [gap * level for level in info.levels]
        parts = zip(range(len(names)), names, info.sheets, shifts, strict=True)
        self._run_id = info.run_id
        self._sheets = [_SheetFiles(self.folder, info.run_id, *part) for part in parts]
        self._interval = info.duration / 30.0
        self._next_time = 0.0
        self._written: list[tuple[float, int]] = []
        self.folder.mkdir(parents=True, exist_ok=True)
        for ending in ("vtu", "vtm"):
            for old in self.folder.glob(f"frame_[0-9][0-9][0-9][0-9]*.{ending}"):
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
        for sheet, state in zip(self._sheets, self._last.sheets, strict=True):
            sheet.write_final(state)
        self._join("final_state")

    def _add(self, frame: Frame) -> None:
        self._write(frame, f"frame_{frame.index:04d}", np.float32)
        self._written.append((frame.time, frame.index))
        entries = "\n".join(
            f'    <DataSet timestep="{float(time)!r}" file={quoteattr(self._file(f"frame_{index:04d}"))}/>'
            for time, index in self._written
        )
        write_text(
            self.folder / "series.pvd",
            f'<?xml version="1.0"?>\n{run_comment(self._run_id)}\n'
            '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
            f"  <Collection>\n{entries}\n  </Collection>\n</VTKFile>\n",
        )

    def _file(self, stem: str) -> str:
        """Name of the file with all sheets."""
        return f"{stem}.vtu" if len(self._sheets) == 1 else f"{stem}.vtm"

    def _write(self, frame: Frame, stem: str, real: type) -> None:
        for sheet, state in zip(self._sheets, frame.sheets, strict=True):
            sheet.write(state, stem, real)
        self._join(stem)

    def _join(self, stem: str) -> None:
        """Write the file that names the files of all sheets, if there are several."""
        if len(self._sheets) > 1:
            blocks = [(sheet.name, sheet.file(stem)) for sheet in self._sheets]
            write_text(self.folder / self._file(stem), blocks_text(blocks, self._run_id))


class _SheetFiles:
    """Files of one sheet.

    Attributes:
        name: of the sheet.
    """

    def __init__(self, folder: Path, run_id: str, place: int, ending: str, info: SheetInfo, shift: float) -> None:
        self._folder, self._run_id, self._ending, self._blank = folder, run_id, ending, info.blank
        self._fabric = info.fabric
        self.name, self._place, self._shift = info.name, place, shift
        self._yarn_components = yarn_components(info.blank)

    def file(self, stem: str) -> str:
        """Name of a file."""
        return f"{stem}{self._ending}.vtu"

    def write_final(self, frame: SheetFrame) -> None:
        """Write the last state: in double precision, with stresses and with angles in the elements' own frames."""
        cells = dict(
            zip(("warp_angle_deg", "weft_angle_deg"), np.rad2deg(yarn_angles(self._blank, frame.position)), strict=True)
        )
        if frame.resultants:
            cells |= stress_fields(
                self._blank, self._fabric, frame.position, frame.director, frame.fields, frame.resultants
            )
        self.write(frame, "final_state", np.float64, cells)

    def write(self, frame: SheetFrame, stem: str, real: type, further: Mapping[str, np.ndarray] | None = None) -> None:
        """Write the state of a frame, and ``further`` values of its elements, with numbers of type ``real``."""
        points = {"displacement": frame.position - self._blank.node_position, "director": frame.director}
        cells = in_files(frame.fields)
        cells["warp_direction"], cells["weft_direction"] = yarn_vectors(
            self._blank, frame.position, self._yarn_components
        )
        cells |= further or {}
        point_data: dict[str, np.ndarray] = {name: values.astype(real) for name, values in points.items()}
        cell_data: dict[str, np.ndarray] = {name: values.astype(real) for name, values in cells.items()}
        if self._ending:
            point_data["exploded"] = np.tile(np.array([0.0, 0.0, self._shift], dtype=real), (len(frame.position), 1))
            cell_data["sheet"] = np.full(self._blank.element_count, self._place, dtype=np.int32)
        write_quads(
            self._folder / self.file(stem), frame.position.astype(real), self._blank.quads, point_data, cell_data,
            self._run_id,
        )  # fmt: skip


def run_comment(run_id: str) -> str:
    """A comment in XML that tells the run."""
    return f"<!-- weavesim run {run_id} -->"


def blocks_text(blocks: Iterable[tuple[str, str]], run_id: str) -> str:
    """Text of a VTM file: named blocks in other files.

    Args:
        blocks: (name, file) of each.
        run_id: goes into a comment.
    """
    entries = "\n".join(
        f'    <DataSet index="{index}" name={quoteattr(name)} file={quoteattr(file)}/>'
        for index, (name, file) in enumerate(blocks)
    )
    return (
        f'<?xml version="1.0"?>\n{run_comment(run_id)}\n'
        '<VTKFile type="vtkMultiBlockDataSet" version="1.0" byte_order="LittleEndian">\n'
        f"  <vtkMultiBlockDataSet>\n{entries}\n  </vtkMultiBlockDataSet>\n</VTKFile>\n"
    )


def write_quads(
    path: Path,
    points: np.ndarray,
    quads: np.ndarray,
    point_data: Mapping[str, np.ndarray],
    cell_data: Mapping[str, np.ndarray],
    run_id: str = "",
) -> None:
    """Write quadrilaterals as VTU, with all numbers as raw binary data after the XML.

    That takes as much space as compressed text, and a twentieth of the time.

    Args:
        path: of the file.
        points: (node_count, 3).
        quads: (element_count, 4).
        point_data, cell_data: by name, (count,) or (count, component_count); float32, float64 or int32.
        run_id: goes into a comment, which every reader of XML skips.
    """
    count = len(quads)
    cells: dict[str, np.ndarray] = {
        "connectivity": quads.astype(np.int32),
        "offsets": np.arange(4, 4 * count + 1, 4, dtype=np.int32),
        "types": np.full(count, _VTK_QUAD, dtype=np.uint8),
    }
    sections = (("Points", {"Points": points}), ("Cells", cells), ("PointData", point_data), ("CellData", cell_data))
    declarations, blocks = _appended(sections)
    lines = [
        '<?xml version="1.0"?>',
        *([run_comment(run_id)] if run_id else []),
        f'<VTKFile type="UnstructuredGrid" version="1.0" byte_order="{_BYTE_ORDER}" header_type="UInt64">',
        f'<UnstructuredGrid><Piece NumberOfPoints="{len(points)}" NumberOfCells="{count}">',
        *declarations,
    ]
    lines += ["</Piece></UnstructuredGrid>", '<AppendedData encoding="raw">', "_"]
    with replacing(path) as temporary, open(temporary, "wb") as file:
        file.write("\n".join(lines).encode())
        file.writelines(blocks)
        file.write(b"\n</AppendedData>\n</VTKFile>\n")


def _appended(sections: Iterable[tuple[str, Mapping[str, np.ndarray]]]) -> tuple[list[str], list[bytes]]:
    """Lines of XML that declare all arrays, and the blocks of bytes after the XML that they refer to."""
    lines: list[str] = []
    blocks: list[bytes] = []
    offset = 0
    for section, arrays in sections:
        lines.append(f"<{section}>")
        for name, values in arrays.items():
            shape = "" if values.ndim == 1 or section == "Cells" else f' NumberOfComponents="{values.shape[1]}"'
            lines.append(
                f"<DataArray type={quoteattr(_VTK_TYPES[values.dtype.name])} Name={quoteattr(name)}{shape} "
                f'format="appended" offset="{offset}"/>'
            )
            blocks += [np.uint64(values.nbytes).tobytes(), values.tobytes()]
            offset += 8 + values.nbytes
        lines.append(f"</{section}>")
    return lines, blocks
