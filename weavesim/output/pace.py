"""How often results are saved during a run, so that a killed run leaves them."""

from __future__ import annotations

import time

# Time between two saves [s], unless saving would then take more than this share of the run.
INTERVAL = 5.0
LARGEST_SHARE = 0.02


class Pace:
    """Says when to save: at frames 0, 1, 2, 4, 8, ..., and whenever the last save is five seconds old.

    Saves that take long become rarer, so that they take less than a fiftieth of the run.
    """

    def __init__(self) -> None:
        self._frame_count = 0
        self._following = 0
        self._next_time = 0.0
        self._started = 0.0

    def due(self) -> bool:
        """Called for every frame: whether to save now. ``done`` has to follow."""
        index, now = self._frame_count, time.monotonic()
        self._frame_count += 1
        if index < self._following and now < self._next_time:
            return False
        self._following = max(1, 2 * index)
        self._started = now
        return True

    def done(self) -> None:
        """The save has been made."""
        now = time.monotonic()
        self._next_time = now + max(INTERVAL, (now - self._started) / LARGEST_SHARE)
