"""Work that a copy of this process shares with it, where a system copies processes cheaply: on Linux."""

from __future__ import annotations

import gc
import logging
import os
import select
import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import NoReturn

from ..engine.threads import anyone_beside
from ..run.interruption import SIGNALS

# A copy that says nothing for so many times as long as this process has worked, and for so long at least [s], is ended.
PATIENCE, LEAST_PATIENCE = 3.0, 5.0
# Of the number of a piece in a pipe [bytes]: one is written, and read, as a whole.
_SIZE = 2


def can_share() -> bool:
    """Whether this system copies processes, and has a core for the copy; no thread may be within an import."""
    return sys.platform == "linux" and len(os.sched_getaffinity(0)) > 1 and not anyone_beside()


class Sharing:
    """Pieces of work 0, 1, ..., ``count`` - 1 that a copy of this process, if there can be one, has begun to do.

    A context: whatever happens in it, no copy is left after it.

    Args:
        count: of the pieces.
        there: does one in the copy, where it must leave nothing but files, print nothing, and use no device.
    """

    def __init__(self, count: int, there: Callable[[int], object]) -> None:
        self._count, self._started = count, time.monotonic()
        self._copy = _copied(count, there) if count > 1 and can_share() else None

    def __enter__(self) -> Sharing:
        return self

    def __exit__(self, *reason: object) -> None:
        self._end()

    def finish(self, here: Callable[[int], object]) -> set[int]:
        """Do what nobody has taken, each piece by whoever is free, and return when all are done.

        What fails in the copy, or is lost with it, is done here.

        Args:
            here: does one in this process.

        Returns:
            Which pieces the copy has done.
        """
        own, found = set[int](), set[int]()
        if self._copy is not None:
            for number in self._copy.turns():
                own.add(number)
                here(number)
            found = self._copy.done(max(LEAST_PATIENCE, PATIENCE * (time.monotonic() - self._started)))
            # before its pieces are done again: a copy that is only slow would write the same files
            self._end()
        for number in range(self._count):
            if number not in own | found:
                here(number)
        return found

    def _end(self) -> None:
        copy, self._copy = self._copy, None
        if copy is not None:
            copy.end()


def share(count: int, here: Callable[[int], object], there: Callable[[int], object]) -> set[int]:
    """Begin and finish pieces of work; arguments and result as in ``Sharing``."""
    with Sharing(count, there) as begun:
        return begun.finish(here)


def _copied(count: int, do: Callable[[int], object]) -> _Copy | None:
    """The copy; None where the system has no room for one."""
    try:
        return _Copy(count, do)
    except OSError:
        return None


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
        # the copy never handles a signal: this process ends it
        handled = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
        try:
            with warnings.catch_warnings():
                # of Python 3.12, that locks of other threads stay locked: the copy takes none of them
                warnings.simplefilter("ignore", DeprecationWarning)
                self._process = os.fork()
            if self._process == 0:
                self._work(tell)
        except OSError:
            os.close(self._queue)
            os.close(self._said)
            raise
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, handled)
            os.close(tell)

    def end(self) -> None:
        """Whatever it still does."""
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
        found, said = set(), select.poll()
        said.register(self._said, select.POLLIN)
        while said.poll(1.0e3 * patience) and (number := os.read(self._said, _SIZE)):
            found.add(int.from_bytes(number, "big"))
        return found

    def _work(self, tell: int) -> NoReturn:
        """The life of the copy: it has the memory of this process, and neither its files nor its terminal."""
        try:
            gc.disable()  # what this process holds on a device is not freed by others
            logging.disable()
            # a lock on a file lasts as long as anyone has it open; the numbers stay taken: objects still hold them
            silent = os.open(os.devnull, os.O_WRONLY)
            for number in map(int, os.listdir("/proc/self/fd")):
                if number not in (0, self._queue, tell, silent):
                    with suppress(OSError):  # that of the listing is closed by now
                        os.dup2(silent, number)
            for piece in self.turns():
                try:
                    self._do(piece)
                except Exception:
                    continue
                os.write(tell, piece.to_bytes(_SIZE, "big"))  # fails where the other process has been killed
        finally:
            os._exit(0)
