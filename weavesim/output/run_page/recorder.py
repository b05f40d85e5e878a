"""Keeps what the page shows of every frame, in bounded memory."""

from __future__ import annotations

import numpy as np

from ...run.frame import Frame, RunInfo

# Of all frames in memory, in single precision; the page then has about a quarter of it.
LARGEST_BYTES = 64_000_000
# Fields that tell a reader of a page nothing.
LEFT_OUT = ("unit_cell_iterations",)


class FrameRecorder:
    """Positions and fields of the frames of a run, in single precision, at most ``limit`` bytes of them.

    Beyond the limit every second frame is dropped, and from then on only every second, fourth, ... is kept, so that
    those that are kept are evenly spaced. The last frame is always there.

    Attributes:
        frame_count: of the run so far.
        stride: one of so many frames is kept.
    """

    def __init__(self, limit: int = LARGEST_BYTES) -> None:
        self._limit = limit
        self.frame_count, self.stride = 0, 1
        self._kept: list[_Kept] = []
        self._last: _Kept | None = None

    def start(self, info: RunInfo) -> None:
        """Forget everything."""
        self.frame_count, self.stride = 0, 1
        self._kept, self._last = [], None

    def frame(self, frame: Frame) -> None:
        """Take a frame."""
        self._last = _Kept(self.frame_count, frame)
        if self.frame_count % self.stride == 0:
            self._kept.append(self._last)
        self.frame_count += 1
        while len(self._kept) > 2 and sum(kept.byte_count for kept in self._kept) > self._limit:
            self.stride *= 2
            self._kept = [kept for kept in self._kept if kept.place % self.stride == 0]

    @property
    def places(self) -> list[int]:
        """Which frames of the run are kept, by their place among all."""
        return [kept.place for kept in self._shown]

    @property
    def stages(self) -> list[str]:
        """Names of their stages, "" without."""
        return [kept.stage for kept in self._shown]

    @property
    def tool_displacement(self) -> np.ndarray:
        """Of the kept frames, (kept_count, tool_count) [m]."""
        return np.array([kept.tool_displacement for kept in self._shown])

    @property
    def tool_pose(self) -> np.ndarray:
        """Of the kept frames, (kept_count, tool_count, 12), see ``Frame``; (kept_count, 0, 12) without any."""
        return np.array([kept.tool_pose for kept in self._shown])

    @property
    def tool_acts(self) -> list[list[bool]]:
        """Whether each tool acts in the kept frames, by frame."""
        return [kept.acts for kept in self._shown]

    def elements(self, sheet: int) -> np.ndarray | None:
        """Which elements of a sheet are there, (kept_count, element_count) bool; None if all are in all frames."""
        kept = [kept.kept[sheet] for kept in self._shown]
        count = max((len(each) for each in kept), default=0)
        return np.stack([each if len(each) else np.ones(count, dtype=bool) for each in kept]) if count else None

    def positions(self, sheet: int) -> np.ndarray:
        """Nodes of a sheet, (kept_count, node_count, 3) [m]."""
        return np.stack([kept.positions[sheet] for kept in self._shown])

    def fields(self, sheet: int) -> dict[str, np.ndarray]:
        """Fields of a sheet by name, (kept_count, element_count), in SI units; those that every frame has."""
        shown = [kept.fields[sheet] for kept in self._shown]
        names = [name for name in shown[-1] if all(name in fields for fields in shown)] if shown else []
        return {name: np.stack([fields[name] for fields in shown]) for name in names}

    @property
    def _shown(self) -> list[_Kept]:
        if self._last is None or (self._kept and self._kept[-1] is self._last):
            return self._kept
        return [*self._kept, self._last]


class _Kept:
    """What is kept of one frame."""

    def __init__(self, place: int, frame: Frame) -> None:
        self.place, self.stage = place, frame.stage
        self.acts = [frame.acts(k) for k in range(len(frame.tool_displacement))]
        self.kept = [sheet.kept for sheet in frame.sheets]
        self.tool_displacement = np.array(frame.tool_displacement, dtype=float)
        self.tool_pose = np.array(frame.tool_pose, dtype=float)
        self.positions = [sheet.position.astype(np.float32) for sheet in frame.sheets]
        self.fields = [
            {name: values.astype(np.float32) for name, values in sheet.fields.items() if name not in LEFT_OUT}
            for sheet in frame.sheets
        ]
        self.byte_count = sum(array.nbytes for array in self.positions) + sum(
            array.nbytes for fields in self.fields for array in fields.values()
        )
