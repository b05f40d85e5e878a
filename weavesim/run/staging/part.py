"""What is there of sheets that a stage has trimmed: sheets and frames without their waste."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..frame import SheetFrame, SheetInfo


def part_of(info: SheetInfo, frame: SheetFrame) -> tuple[SheetInfo, SheetFrame]:
    """A sheet and its frame without waste, on a blank of its own; both as they are where nothing is trimmed."""
    if not len(frame.kept):
        return info, frame
    return Part(info, frame.kept).of(frame)


class Part:
    """What is there of a sheet while no further trim comes.

    Args:
        info: of the whole sheet.
        kept: elements that are there, (element_count,) bool; empty for all.

    Attributes:
        info: of what is there.
        kept: as given.
        nodes: of the whole sheet that it has, (k,).
    """

    def __init__(self, info: SheetInfo, kept: np.ndarray) -> None:
        self.kept, self.info = kept, info
        self.nodes = np.arange(info.blank.node_count)
        if len(kept):
            blank, self.nodes = info.blank.part(kept)
            self.info = replace(info, blank=blank)

    def holds(self, frame: SheetFrame) -> bool:
        """Whether a frame has the same elements."""
        return np.array_equal(self.kept, frame.kept)

    def of(self, frame: SheetFrame) -> tuple[SheetInfo, SheetFrame]:
        """The sheet and ``frame`` of it, without waste."""
        if not len(self.kept):
            return self.info, frame
        kept, nodes = self.kept, self.nodes
        return self.info, replace(
            frame,
            position=frame.position[nodes],
            director=frame.director[nodes],
            fields={name: values[kept] for name, values in frame.fields.items()},
            resultants={name: values[kept] for name, values in frame.resultants.items()},
            kept=np.zeros(0, dtype=bool),
        )
