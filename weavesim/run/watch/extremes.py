"""Extremes of a run over all its steps, with their element or node, and about when they came."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ...engine.model import Model
from ...engine.sheet_model import SheetModel
from ...engine.state import SheetState, State
from ...kernels.rows import ExtremeRow, ToolWatchRow

# What is followed of a sheet.
EXTREMES = ("min_stretch", "max_stretch", "angle", "depth")


class Extreme(NamedTuple):
    """The furthest that anything of a sheet has gone.

    Attributes:
        value: in SI units.
        time: at which it was first seen, at most an eightieth of the run late [s].
        place: (x, y) on the flat blank [m].
        tool: index among the tools of the run, of a depth.
    """

    value: float
    time: float = 0.0
    place: tuple[float, float] | None = None
    tool: int | None = None


class SheetExtremes:
    """Extremes of one sheet.

    Attributes:
        min_stretch, max_stretch: of both yarn families, at the end of any block of steps.
        angle: absolute shear angle [rad].
        depth: of a node in a tool, half the thickness included, in any step [m]; 0 if none was ever touched.
        rows: of every element, by ``ExtremeRow``, (row, element_count).
        times: when the largest of each row was first seen, (row,) [s].
        touched: whether each tool of the world has touched a node, or a sample between nodes, (tool_count,) bool.
    """

    def __init__(self, model: SheetModel) -> None:
        self._model = model
        blank = model.blank
        self._nodes = blank.material_coordinates
        self._centres = self._nodes[blank.quads].mean(axis=1)
        self.min_stretch, self.max_stretch, self.angle, self.depth = (
            Extreme(1.0),
            Extreme(1.0),
            Extreme(0.0),
            Extreme(0.0),
        )
        self.rows = np.zeros((ExtremeRow.row_count(), model.blank.element_count))
        self.times = np.zeros(len(self.rows))
        self.touched = np.zeros(model.tool_count, dtype=bool)

    def begin_stage(self, model: SheetModel) -> None:
        """Read a stage from now on, whose constants are ``model``."""
        self._model = model

    def read(self, state: SheetState, time: float) -> None:
        """Read what the device has found by ``time`` [s]; waits for it."""
        rows = state.extremes.numpy()[:, : self._model.blank.element_count].astype(np.float64)
        self.times = np.where(rows.max(axis=1) > self.rows.max(axis=1), time, self.times)
        self.rows = rows
        smallest = -np.minimum(rows[ExtremeRow.min_warp], rows[ExtremeRow.min_weft])
        largest = np.maximum(rows[ExtremeRow.max_warp], rows[ExtremeRow.max_weft])
        self.min_stretch = self._further(self.min_stretch, 1.0, -1.0, smallest, time)
        self.max_stretch = self._further(self.max_stretch, 1.0, 1.0, largest, time)
        self.angle = self._further(self.angle, 0.0, 1.0, rows[ExtremeRow.angle], time)
        if self._model.tool_count:
            depth = state.depth.numpy()[:, : self._model.blank.node_count].astype(np.float64)
            depth[:, self._model.waste] = 0.0
            tool, node = np.unravel_index(int(np.argmax(depth)), depth.shape)
            if depth[tool, node] > self.depth.value:
                x, y = self._nodes[node]
                of_run = self._model.places.tools.start + int(tool)
                self.depth = Extreme(float(depth[tool, node]), time, (float(x), float(y)), of_run)
            self.touched |= depth.max(axis=1) > 0.0
            samples = self._model.samples
            if samples.count and not self.touched.all():
                own = state.sample_depth.numpy().reshape(len(depth), len(samples.places), -1)
                self.touched |= own[..., samples.slot[self._model.kept]].max(axis=(1, 2)) > 0.0

    def memory(self) -> dict[str, Any]:
        """All that was read so far, for a checkpoint."""
        own = {name: list(getattr(self, name)) for name in EXTREMES}
        return own | {"rows": self.rows, "times": self.times, "touched": self.touched}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Have read what ``memory`` tells."""
        for name in EXTREMES:
            value, time, place, tool = memory[name]
            setattr(self, name, Extreme(value, time, None if place is None else tuple(place), tool))
        self.rows, self.times, self.touched = memory["rows"], memory["times"], memory["touched"]

    def _further(self, last: Extreme, rest: float, sign: float, beyond: np.ndarray, time: float) -> Extreme:
        """The extreme, rest + sign * beyond, of the element that went furthest, if it went further than the last."""
        element = int(np.argmax(beyond))
        if not beyond[element] > sign * (last.value - rest):
            return last
        x, y = self._centres[element]
        return Extreme(rest + sign * float(beyond[element]), time, (float(x), float(y)))


class Extremes:
    """Extremes of all sheets and tools of a run.

    Attributes:
        sheets: in the order of the run.
        tools: by names of ``ToolWatchRow``, (tool_count,) each.
    """

    def __init__(self, model: Model) -> None:
        self.sheets = tuple(SheetExtremes(sheet) for sheet in model.sheets)
        self._places = tuple(sheet.places.tools for sheet in model.sheets)
        self._tool_count = model.tools.count
        self.tools = {name: np.zeros(self._tool_count) for name in ToolWatchRow.names()}

    @property
    def touched(self) -> np.ndarray:
        """Whether each tool has touched any sheet, at a node or where it is met between nodes, (tool_count,) bool."""
        touched = np.zeros(self._tool_count, dtype=bool)
        for places, sheet in zip(self._places, self.sheets, strict=True):
            touched[places.start : places.stop] |= sheet.touched
        return touched

    def begin_stage(self, model: Model) -> None:
        """Read a stage from now on, whose constants are ``model``."""
        for extremes, sheet in zip(self.sheets, model.sheets, strict=True):
            extremes.begin_stage(sheet)

    def read(self, state: State, time: float) -> None:
        """Read what the device has found by ``time`` [s]; waits for it."""
        for extremes, own in zip(self.sheets, state.sheets, strict=True):
            extremes.read(own, time)
        self.tools = dict(zip(ToolWatchRow.names(), state.tool_watch.numpy().copy(), strict=True))

    def memory(self) -> dict[str, Any]:
        """All that was read so far, for a checkpoint."""
        return {"sheets": [sheet.memory() for sheet in self.sheets], "tools": dict(self.tools)}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Have read what ``memory`` tells."""
        for sheet, own in zip(self.sheets, memory["sheets"], strict=True):
            sheet.recall(own)
        self.tools = dict(memory["tools"])
