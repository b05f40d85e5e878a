"""What a run looks at of itself, at times that do not depend on its frames."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import astuple
from typing import Any

from ...engine.model import Model
from ...errors import InputError
from ..frame import Frame
from ..ledger import Ledger
from ..sheet_ledger import NO_PENETRATION, Penetration
from ..start import Prepared
from .condition import Condition, StackCondition
from .extremes import Extremes

# States that are looked at in a run, evenly spaced in time, whatever its frames. The states of 80 frames, or of 40, 20,
# 16 or 10, are among them: one state then serves both.
WATCH_COUNT = 80
# Of each stage of a run that has some: one that ends at rest does so at a look.
STAGE_WATCH_COUNT = 100
# At about so many of them the sheets are searched for parts that pass through each other, which takes longer; of few
# states, at every third one.
CONDITION_COUNT, LEAST_CONDITION_INTERVAL = 27, 3
# More looks than steps of a coarse run would only cost time.
LARGEST_WATCH_COUNT = 10_000


def check_watch_count(count: int | None) -> None:
    """Raise ``InputError`` if there cannot be so many looks; None is the usual number."""
    if count is not None and not 1 <= count <= LARGEST_WATCH_COUNT:
        raise InputError(f"watch_count = {count}: 1 to {LARGEST_WATCH_COUNT} are allowed")


class Watch:
    """Shows the guards about eighty states of a run, or a hundred of each stage, and keeps their numbers.

    A run with one frame looks at the same states as a run with a thousand: each ends the first block of steps at or
    after its time.

    Args:
        prepared: the run; its state is read.
        count: states to look at in a run, or in each of its stages.

    Attributes:
        history: time, stroke and every entry of the energy ledger of all states so far.
        penetration: the deepest of all states so far.
        extremes: over all steps so far, kept on the device.
        conditions: of every sheet, at every third or fourth of these states and at the end.
        stacks: conditions of the sheets of every world that has several, at the same times.
    """

    def __init__(self, prepared: Prepared, count: int = WATCH_COUNT) -> None:
        self._count = count
        self._begin, self._duration, self._state = 0.0, prepared.info.duration, prepared.state
        self._ledger, self._guards = prepared.ledger, prepared.guards
        self.extremes = Extremes(prepared.model)
        self.conditions = tuple(Condition(sheet) for sheet in prepared.info.sheets)
        self.stacks = tuple(StackCondition(sheets) for sheets in prepared.info.worlds if len(sheets) > 1)
        self.history: list[dict[str, float]] = []
        self.penetration: Penetration = NO_PENETRATION
        self._last_step = -1
        self._next = 1

    @property
    def _condition_interval(self) -> int:
        return max(LEAST_CONDITION_INTERVAL, math.ceil(self._count / CONDITION_COUNT))

    @property
    def next_time(self) -> float:
        """When to look again [s]."""
        return self._begin + self._duration * self._next / self._count

    def begin_stage(self, model: Model, ledger: Ledger, begin: float, duration: float) -> None:
        """Look at a stage of a run that begins now, with a state that has been looked at.

        Args:
            model, ledger: of the stage.
            begin: from which its times count [s].
            duration: of it [s].
        """
        self._ledger, self._begin, self._duration = ledger, begin, duration
        self.extremes.begin_stage(model)
        self._next = self._following(self._state.time)

    def _following(self, time: float) -> int:
        """Number of the first look after ``time`` [s]."""
        return math.floor(self._count * (time - self._begin) / self._duration) + 1

    def look(self, frame: Frame, last: bool = False) -> None:
        """Look at a frame that the ledger has just taken; the same state is looked at once.

        Args:
            frame: of the current state.
            last: whether the run ends here.
        """
        new = frame.step_count != self._last_step
        following = max(self._next, self._following(frame.time))
        if last or (new and following // self._condition_interval > self._next // self._condition_interval):
            for condition, sheet in zip(self.conditions, frame.sheets, strict=True):
                condition.look(sheet, frame.time)
            for stack in self.stacks:
                stack.look(frame.sheets, frame.time)
        self._next = following
        if not new:
            return
        self._last_step = frame.step_count
        self.history.append({"time": frame.time, "stroke": frame.stroke, **frame.energies})
        self.penetration = self.penetration.deeper(self._ledger.penetration(frame))
        self.extremes.read(self._state, frame.time)
        self._guards.watch(frame, self._ledger)

    def memory(self) -> dict[str, Any]:
        """All that was seen so far, for a checkpoint: plain values, lists, and arrays."""
        return {
            "history": self.history,
            "penetration": list(astuple(self.penetration)),
            "extremes": self.extremes.memory(),
            "conditions": [condition.memory() for condition in self.conditions],
            "stacks": [stack.memory() for stack in self.stacks],
            "last_step": self._last_step,
            "count": self._count,
            "next": self._next,
            "begin": self._begin,
            "duration": self._duration,
        }

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Have seen what ``memory`` tells, and nothing else."""
        self.history[:] = [dict(entry) for entry in memory["history"]]
        at_nodes, at_surface, at_element_centres, sheet, place, time = memory["penetration"]
        self.penetration = Penetration(at_nodes, at_surface, at_element_centres, sheet, (place[0], place[1]), time)
        self.extremes.recall(memory["extremes"])
        for condition, own in zip(self.conditions, memory["conditions"], strict=True):
            condition.recall(own)
        for stack, own in zip(self.stacks, memory["stacks"], strict=True):
            stack.recall(own)
        # a run that goes on has the looks that it began with
        self._count, self._next, self._last_step = memory["count"], memory["next"], memory["last_step"]
        self._begin, self._duration = memory["begin"], memory["duration"]
