"""Work that a copy of this process shares with it, where a system copies processes cheaply: on Linux."""

from __future__ import annotations

import gc
import os
import select
import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import NoReturn

from ..run.interruption import SIGNALS

# A copy that says nothing for so many times as long as this process has worked, and for so long at least [s], is ended.
PATIENCE, LEAST_PATIENCE = 3.0, 5.0
# Of the number of a piece in a pipe [bytes]: one is written, and read, as a whole.
_SIZE = 2


def can_share() -> bool:
    """Whether this system copies processes, and has a core for the copy."""
    return sys.platform == "linux" and len(os.sched_getaffinity(0)) > 1


def share(count: int, here: Callable[[int], object], there: Callable[[int], object]) -> set[int]:
    """Do pieces of work 0, 1, ..., ``count`` - 1, each by whoever is free: this process, or a copy of it.

    What fails in the copy, or is lost with it, is done here.

    Args:
        count: of the pieces.
        here: does one in this process.
        there: does one in the copy, where it must leave nothing but files, print nothing, and use no device.

    Returns:
        Which pieces the copy has done.
    """
    if count < 2 or not can_share():
        for number in range(count):
            here(number)
        return set()
    started = time.monotonic()
    with _Copy(count, there) as copy:
        own = set()
        for number in copy.turns():
            own.add(number)
            here(number)
        found = copy.done(max(LEAST_PATIENCE, PATIENCE * (time.monotonic() - started)))
    for number in range(count):
        if number not in own | found:
            here(number)
    return found


class _Copy:
    """A copy of this process, which takes pieces from the same queue: a pipe with their numbers.

    Args:
        count: of the pieces.
        do: does one of them.
    """

    def __init__(self, count: int, do: Callable[[int], object]) -> None:
        self._do = do
        self._queue, feed = os.pipe()
        os.write(feed, b"".join(number.to_bytes(_SIZE, "big") for number in range(count)))
        os.close(feed)
        self._said, tell = os.pipe()
        with warnings.catch_warnings():
            # of Python 3.12, that locks of other threads stay locked: the copy takes none of them
            warnings.simplefilter("ignore", DeprecationWarning)
            self._process = os.fork()
        if self._process == 0:
            self._work(tell)
        os.close(tell)

    def __enter__(self) -> _Copy:
        return self

    def __exit__(self, *reason: object) -> None:
        """Whatever happened here, no copy is left."""
        with suppress(OSError):
            os.kill(self._process, signal.SIGKILL)
        with suppress(OSError):
            os.waitpid(self._process, 0)
        os.close(self._queue)
        os.close(self._said)

    def turns(self) -> Iterator[int]:
        """Pieces that nobody has taken yet."""
        while number := os.read(self._queue, _SIZE):
            yield int.from_bytes(number, "big")

    def done(self, patience: float) -> set[int]:
        """Pieces that the copy has done; waits until it has ended, or said nothing for so long [s]."""
        found = set()
        while select.select([self._said], [], [], patience)[0] and (number := os.read(self._said, _SIZE)):
            found.add(int.from_bytes(number, "big"))
        return found

    def _work(self, tell: int) -> NoReturn:
        """The life of the copy: it has the memory of this process, and neither its files nor its terminal."""
        try:
            for number in SIGNALS:
                signal.signal(number, signal.SIG_IGN)  # it is ended by this process
            gc.disable()  # what this process holds on a device is not freed by others
            silent = os.open(os.devnull, os.O_WRONLY)
            for stream in (1, 2):
                os.dup2(silent, stream)
            # a lock on a file lasts as long as anyone has it open
            first, second = sorted((self._queue, tell))
            for begin, end in ((3, first), (first + 1, second), (second + 1, os.sysconf("SC_OPEN_MAX"))):
                os.closerange(begin, end)
            for piece in self.turns():
                with suppress(Exception):
                    self._do(piece)
                    os.write(tell, piece.to_bytes(_SIZE, "big"))
        finally:
            os._exit(0)
