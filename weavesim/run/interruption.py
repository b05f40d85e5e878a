"""Orderly end of a run on Ctrl-C, on SIGTERM, and when its terminal closes (SIGHUP)."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
# A Ctrl-C this long after the first signal [s], or the third Ctrl-C, stops even the writing of results.
PATIENCE = 10.0
LAST_PRESS = 3


class Interrupted(KeyboardInterrupt):
    """A signal came while there was nothing to lose.

    Attributes:
        signal: which.
    """

    def __init__(self, number: signal.Signals) -> None:
        super().__init__(number.name)
        self.signal = number


class Interruption:
    """The signals that a run has received.

    While it is ``held``, a signal is only noted, so that the run can end and write its results. Otherwise it raises
    ``Interrupted`` at once.

    Attributes:
        signal: the first one; None before.
    """

    def __init__(self) -> None:
        self.signal: signal.Signals | None = None
        self._holds = 0
        self._presses = 0
        self._since = 0.0

    def is_set(self) -> bool:
        """Whether there was a signal."""
        return self.signal is not None

    @contextmanager
    def held(self) -> Iterator[None]:
        """Inside this context signals are noted and raise nothing, but for an impatient Ctrl-C."""
        self._holds += 1
        try:
            yield
        finally:
            self._holds -= 1

    def handle(self, number: int, stack: object) -> None:
        """The handler of all signals."""
        first = self.signal is None
        if first:
            self.signal, self._since = signal.Signals(number), time.monotonic()
        if not self._holds:
            raise Interrupted(signal.Signals(number))
        if number == signal.SIGINT:
            self._presses += 1
            if self._presses >= LAST_PRESS or (not first and time.monotonic() - self._since > PATIENCE):
                raise KeyboardInterrupt


@contextmanager
def _signals_taken(handler: Callable[[int, object], object]) -> Iterator[None]:
    """Inside this context ``handler`` gets all signals that the process does not ignore; only in the main thread.

    SIGINT is taken even if it is ignored, as in the background of a script.
    """
    before = {number: signal.getsignal(number) for number in SIGNALS}
    taken = [number for number in SIGNALS if number == signal.SIGINT or before[number] is not signal.SIG_IGN]
    try:
        for number in taken:
            signal.signal(number, handler)
        yield
    finally:
        for number in taken:
            # None: installed outside Python, which cannot restore it
            signal.signal(number, before[number] or signal.SIG_DFL)


@contextmanager
def leaving_at_once() -> Iterator[None]:
    """Inside this context a signal ends the process at once, with 128 plus its number, where ``interruption`` does not
    take it: an exception in the middle of an import would come out as something else.

    Only the main thread can do it.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    with _signals_taken(lambda number, stack: os._exit(128 + number)):
        yield


_current: Interruption | None = None
_of_thread = threading.local()  # interruption: what another thread notes signals in, for this one


@contextmanager
def interrupted_by(interruption: Interruption) -> Iterator[None]:
    """Inside this context, runs of this thread end with the signals that the main thread notes."""
    _of_thread.interruption = interruption
    try:
        yield
    finally:
        del _of_thread.interruption


@contextmanager
def interruption() -> Iterator[Interruption]:
    """Take the signals of this process, and yield what notes them; within another such context, the one of that.

    Only the main thread can: elsewhere what is yielded is that of ``interrupted_by``, or is never set. A process that
    ignores SIGHUP, as ``nohup`` makes it, goes on ignoring it.
    """
    global _current
    if threading.current_thread() is not threading.main_thread():
        yield getattr(_of_thread, "interruption", None) or Interruption()
        return
    if _current is not None:
        yield _current
        return
    _current = Interruption()
    try:
        with _signals_taken(_current.handle):
            yield _current
    finally:
        _current = None
