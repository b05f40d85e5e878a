"""What a run looks at of itself, at times that do not depend on its frames."""

from __future__ import annotations

import math

from ..engine.model import Model
from ..engine.state import State
from .extremes import Extremes
from .frame import Frame
from .guards import Guards
from .ledger import Ledger
from .sheet_ledger import NO_PENETRATION, Penetration

# States that are looked at in a run, evenly spaced in time.
WATCH_COUNT = 100


class Watch:
    """Shows the guards about ``WATCH_COUNT`` states of a run, and keeps their numbers.

    A run with one frame looks at the same states as a run with a thousand: each ends the first block of steps at or
    after its time.

    Args:
        duration: of the run [s].
        model, state: of the run; the state is read.
        ledger: of the run.
        guards: of the run.

    Attributes:
        history: time, stroke and every entry of the energy ledger of all states so far.
        penetration: the deepest of all states so far.
        extremes: over all steps so far, kept on the device.
    """

    def __init__(self, duration: float, model: Model, state: State, ledger: Ledger, guards: Guards) -> None:
        self._duration, self._state, self._ledger, self._guards = duration, state, ledger, guards
        self.extremes = Extremes(model)
        self.history: list[dict[str, float]] = []
        self.penetration: Penetration = NO_PENETRATION
        self._last_step = -1
        self._next = 1

    @property
    def next_time(self) -> float:
        """When to look again [s]."""
        return self._duration * self._next / WATCH_COUNT

    def look(self, frame: Frame) -> None:
        """Look at a frame that the ledger has just taken; the same state is looked at once."""
        if frame.step_count == self._last_step:
            return
        self._last_step = frame.step_count
        self._next = max(self._next, math.floor(WATCH_COUNT * frame.time / self._duration) + 1)
        self.history.append({"time": frame.time, "stroke": frame.stroke, **frame.energies})
        self.penetration = self.penetration.deeper(self._ledger.penetration(frame))
        self.extremes.read(self._state, frame.time)
        self._guards.watch(frame, self._ledger)
