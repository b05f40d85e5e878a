"""The frames of a run for ParaView."""

from __future__ import annotations

from pathlib import Path

from ...errors import InputError
from ...run.frame import Frame, Outcome, RunInfo, unique_names
from ..files import file_endings, in_file_name, write_text
from ..pace import Pace
from .files import blocks_text, times_text
from .sheets import SheetFiles
from .tools import ToolFiles

# Between the sheets of an exploded view, over the largest blank.
_GAP_TO_SIZE = 0.15
# The block with the tools; a sheet of this name is another one.
TOOLS = "tools"


class ParaViewSeries:
    """Observer that writes ``series.pvd``, which ParaView and PyVista open: every frame with its time, as the blocks of
    ``frame_0000.vtm`` ...; and ``final_state.vtu``.

    Each sheet is a block by its name, whole: mirrored copies belong to it (cell data ``mirrored``), as mirror images,
    whose values are those of the original. What a stage trims away is not there from its frame on. The block "tools"
    has one for each tool that acts, where it is in that frame; tools of very many triangles are coarser there than in
    the run.

    Names of data end in their unit, as those of all numbers do; without one it is a pure number. Point data:
    ``displacement_m`` and ``flat_coordinates_m``, where the node was on the flat blank. Cell data: the fields of the
    frame (``weavesim.run.fields``; those of the solver only if wanted), and the yarn directions ``warp_direction`` and
    ``weft_direction``. With several sheets also cell data ``sheet``, their number, and point data ``exploded_m``, from
    which Warp By Vector makes an exploded view.

    The final state is the computed part in double precision with all fields, stresses (``STRESS_FIELDS``), directors
    and the angles of the yarns in each element's own frame; with several sheets, ``final_state_NAME.vtu`` are the
    blocks of ``final_state.vtm``. The shear angle has one sign everywhere: it is 90 degrees less the angle from warp to
    weft.

    Args:
        folder: created if necessary; numbered frames of a previous run are removed at the start.
        every: write every ``every``-th frame, and the last.
        diagnostics: whether frames have the fields of the solver too.

    Raises:
        InputError: ``every`` below 1.
    """

    def __init__(self, folder: str | Path, every: int = 1, *, diagnostics: bool = False) -> None:
        if every < 1:
            raise InputError(f"ParaView series: every = {every}; give 1 or more")
        self.folder = Path(folder)
        self._every, self._diagnostics = every, diagnostics
        self._last: Frame | None = None

    def start(self, info: RunInfo) -> None:
        self._run_id = info.run_id
        self._endings = file_endings(info)
        several = len(info.sheets) > 1
        gap = _GAP_TO_SIZE * max(sheet.blank.size for sheet in info.sheets)
        file_names = unique_names(in_file_name(sheet.name) for sheet in info.sheets)
        self._sheets = [
            SheetFiles(self.folder, info.run_id, place, name, sheet, gap * level, several, self._diagnostics)
            for place, (name, sheet, level) in enumerate(zip(file_names, info.sheets, info.levels, strict=True))
        ]
        tool_files = unique_names(in_file_name(name) for name in info.tool_names)
        self._tools = {
            name: ToolFiles(self.folder, info.run_id, file_name, tool)
            for name, file_name, tool in zip(info.tool_names, tool_files, info.tools, strict=True)
        }
        self._blocks = unique_names([*(sheet.name for sheet in self._sheets), TOOLS])
        self._written: list[tuple[float, str]] = []
        self._pace = Pace()
        self.folder.mkdir(parents=True, exist_ok=True)
        for ending in ("vtu", "vtm"):
            for old in self.folder.glob(f"frame_[0-9][0-9][0-9][0-9]*.{ending}"):
                old.unlink()

    def frame(self, frame: Frame) -> None:
        self._last = frame
        if frame.index % self._every == 0:
            self._add(frame)

    def finish(self, outcome: Outcome) -> None:
        if self._last is None:
            return
        if not self._written or self._written[-1][0] < self._last.time:
            self._add(self._last)
        self._list()
        files = [f"final_state{ending}.vtu" for ending in self._endings]
        for sheet, state, file in zip(self._sheets, self._last.sheets, files, strict=True):
            sheet.write_final(state, file)
        if len(files) > 1:
            blocks = dict(zip((sheet.name for sheet in self._sheets), files, strict=True))
            write_text(self.folder / "final_state.vtm", blocks_text(blocks, self._run_id))

    def _add(self, frame: Frame) -> None:
        stem = f"frame_{frame.index:04d}"
        self._write(frame, stem)
        self._written.append((float(frame.time), f"{stem}.vtm"))
        if self._pace.due():
            self._list()
            self._pace.done()

    def _list(self) -> None:
        """List the frames so far with their times: not at each of them, since replacing a file makes disks write it."""
        write_text(self.folder / "series.pvd", times_text(self._written, self._run_id))

    def _write(self, frame: Frame, stem: str) -> None:
        files = [sheet.write(state, stem) for sheet, state in zip(self._sheets, frame.sheets, strict=True)]
        blocks: dict[str, str | dict[str, str]] = dict(zip(self._blocks[:-1], files, strict=True))
        if self._tools:
            blocks[self._blocks[-1]] = {
                name: tool.write(frame.place(k), stem)
                for k, (name, tool) in enumerate(self._tools.items())
                if frame.acts(k)
            }
        write_text(self.folder / f"{stem}.vtm", blocks_text(blocks, self._run_id))
