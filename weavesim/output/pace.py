"""How often results are saved during a run, so that a killed run leaves them."""

from __future__ import annotations

import time

# Time between two saves [s]: at the beginning that since the first one, and always so much that saving takes no more
# than this share of the run.
FIRST_INTERVAL, INTERVAL = 0.5, 5.0
LARGEST_SHARE = 0.02


class Pace:
    """Says when to save: at the first frame, about 0.5, 1, 2, 4 and 8 seconds after it, then every five seconds.

    Saves that take long become rarer, so that they take less than a fiftieth of the run.

    Args:
        first_interval: between the first two saves [s].
    """

    def __init__(self, first_interval: float = FIRST_INTERVAL) -> None:
        self._first: float | None = None
        self._first_interval = first_interval
        self._next_time = 0.0
        self._started = 0.0

    def due(self) -> bool:
        """Called for every frame: whether to save now. ``done`` has to follow."""
        now = time.monotonic()
        if self._first is None:
            self._first = self._next_time = now
        self._started = now
        return now >= self._next_time

    def done(self) -> None:
        """The save has been made."""
        now = time.monotonic()
        age = now - (now if self._first is None else self._first)
        interval = min(max(age, self._first_interval), INTERVAL)
        self._next_time = now + max(interval, (now - self._started) / LARGEST_SHARE)
