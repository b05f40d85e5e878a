"""How often the page is written during a run."""

from __future__ import annotations

import time

# A page takes a few tenths of a second: short runs have none before their end.
FIRST = 10.0
INTERVAL = 10.0
LARGEST_SHARE = 0.02


class PagePace:
    """Says when to write: ten seconds after the first frame, and then so rarely that it takes a fiftieth of the run."""

    def __init__(self) -> None:
        self._next: float | None = None
        self._started = 0.0

    def due(self) -> bool:
        """Called for every frame: whether to write now. ``done`` has to follow."""
        now = time.monotonic()
        if self._next is None:
            self._next = now + FIRST
        self._started = now
        return now >= self._next

    def done(self) -> None:
        """The page has been written."""
        now = time.monotonic()
        self._next = now + max(INTERVAL, (now - self._started) / LARGEST_SHARE)
