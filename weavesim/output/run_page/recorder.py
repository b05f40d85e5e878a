"""Keeps what the page shows of every frame, in bounded memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...run.frame import Frame, RunInfo

# Of all frames in memory, in single precision; the page then has about a quarter of it. Of positions and main fields,
# and of all others.
LARGEST_BYTES = 64_000_000
LARGEST_OTHER_BYTES = 128_000_000
# From so many on, the page rounds other fields more, to a third of their bytes.
COARSE_BYTES = 40_000_000
# Fields that are there wherever the positions are.
MAIN_FIELDS = ("shear_angle", "thickness")
# Fields that tell a reader of a page nothing.
LEFT_OUT = ("unit_cell_iterations",)


@dataclass(frozen=True)
class KeptField:
    """A field of one sheet.

    Attributes:
        at: in which of the kept frames it is, ascending.
        values: (len(at), element_count), in SI units.
        coarse: there are so many values that the page has to round them more.
    """

    at: list[int]
    values: np.ndarray
    coarse: bool = False


class FrameRecorder:
    """Positions and fields of the frames of a run, in single precision, in bounded memory.

    Beyond ``limit`` every second frame is dropped, and from then on only every second, fourth, ... is kept, so that
    those that are kept are evenly spaced. Beyond ``other_limit`` so are the fields other than the main ones, of which
    each kept frame has its own. The last frame is always there, with all fields.

    Args:
        limit: of positions and ``MAIN_FIELDS`` [bytes].
        other_limit: of all other fields [bytes].

    Attributes:
        frame_count: of the run so far.
        stride: one of so many frames is kept.
        other_stride: one of so many frames is kept with all fields.
    """

    def __init__(self, limit: int = LARGEST_BYTES, other_limit: int = LARGEST_OTHER_BYTES) -> None:
        self._limit, self._other_limit = limit, other_limit
        self._forget()

    def _forget(self) -> None:
        self.frame_count, self.stride, self.other_stride = 0, 1, 1
        self._kept: list[_Kept] = []
        self._last: _Kept | None = None

    def start(self, info: RunInfo) -> None:
        """Forget everything."""
        self._forget()

    def frame(self, frame: Frame) -> None:
        """Take a frame."""
        if self._last is not None and self._last.place % self.other_stride:
            self._last.drop_others()
        self._last = _Kept(self.frame_count, frame)
        if self.frame_count % self.stride == 0:
            self._kept.append(self._last)
        self.frame_count += 1
        while len(self._kept) > 2 and sum(kept.byte_count for kept in self._kept) > self._limit:
            self.stride *= 2
            self._kept = [kept for kept in self._kept if kept.place % self.stride == 0]
        self.other_stride = max(self.other_stride, self.stride)
        while (
            sum(kept.has_others for kept in self._kept) > 2
            and sum(kept.other_byte_count for kept in self._kept) > self._other_limit
        ):
            self.other_stride *= 2
            for kept in self._kept:
                if kept.place % self.other_stride and kept is not self._last:
                    kept.drop_others()

    def thinned(self, count: int) -> FrameRecorder:
        """The same with at most about ``count`` frames; it is not to be gone on with."""
        fewer, ratio = FrameRecorder(self._limit, self._other_limit), self.other_stride // self.stride
        step = max(-(-len(self._kept) // count), 1)
        # one that hits the frames with all fields; their ratio is a power of two
        step = 1 << (step - 1).bit_length() if step < ratio else ratio * -(-step // ratio)
        fewer.frame_count, fewer.stride, fewer._last = self.frame_count, self.stride * step, self._last
        fewer.other_stride, fewer._kept = max(self.other_stride, fewer.stride), self._kept[::step]
        return fewer

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

    def fields(self, sheet: int) -> dict[str, KeptField]:
        """Fields of a sheet by name; those that every frame has had."""
        shown = self._shown
        names = shown[-1].fields[sheet] if shown else ()
        return {name: kept for name in names if (kept := self.field(sheet, name)) is not None}

    def field(self, sheet: int, name: str) -> KeptField | None:
        """One field of a sheet; None if not every frame has had it."""
        shown, is_main = self._shown, name in MAIN_FIELDS
        at = [k for k, kept in enumerate(shown) if is_main or kept.has_others]
        values = [shown[k].fields[sheet].get(name) for k in at]
        if not values or any(value is None for value in values):
            return None
        coarse = not is_main and sum(kept.other_byte_count for kept in shown) > COARSE_BYTES
        return KeptField(at, np.stack([value for value in values if value is not None]), coarse)

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
        self.has_others = True
        self.byte_count = sum(array.nbytes for array in self.positions) + self._bytes(main=True)
        self.other_byte_count = self._bytes(main=False)

    def _bytes(self, *, main: bool) -> int:
        return sum(
            array.nbytes for fields in self.fields for name, array in fields.items() if (name in MAIN_FIELDS) is main
        )

    def drop_others(self) -> None:
        """Keep nothing but the main fields."""
        self.has_others, self.other_byte_count = False, 0
        self.fields = [{name: fields[name] for name in MAIN_FIELDS if name in fields} for fields in self.fields]
