"""What surrounds the work of a command: signals, and what takes seconds before a run."""

from __future__ import annotations

import atexit
import gc
import logging
import signal
from collections.abc import Iterator
from contextlib import contextmanager

import typer

from ..errors import InputError, RunError
from ..run.interruption import Interrupted, Interruption, interruption
from .ending import interrupted_code
from .terminal import say

logger = logging.getLogger(__name__)

# New objects after which a run searches for garbage; usually 700, and libraries that it loads make a hundred thousand.
OBJECTS_BETWEEN_SEARCHES = 10_000


@contextmanager
def interruptible() -> Iterator[Interruption]:
    """Take the signals of the process; one with nothing to lose ends the command at once, with its exit code."""
    try:
        with interruption() as interrupted:
            yield interrupted
    except KeyboardInterrupt as error:
        # before the run, or while its results were written for somebody who did not wait
        raise _interrupted(error.signal if isinstance(error, Interrupted) else signal.SIGINT) from None
    except (InputError, RunError, typer.Exit):
        raise
    except Exception:
        if interrupted.signal is None:
            raise
        # code that the signal met in the middle may raise what it likes
        logger.debug("a signal ended this", exc_info=True)
        raise _interrupted(interrupted.signal) from None


def _interrupted(number: int) -> typer.Exit:
    say(f"Interrupted by {signal.Signals(number).name}.")
    return typer.Exit(interrupted_code(number))


def announce_compilation(name: str, kernel_count: int) -> None:
    """Tell the user on standard error that kernels are compiled, and how long that may take."""
    kernels = "1 kernel" if kernel_count == 1 else f"{kernel_count} kernels"
    text = f"{name}: compiling {kernels}, up to a minute; later runs with the same laws and tools start at once"
    say(text, error=True)


# Of this process: whether ``uncollected`` rests the search for garbage, and whether a run has begun.
_rests = False
_has_run = False


@contextmanager
def uncollected() -> Iterator[None]:
    """Leave out the search for garbage in cycles: what is imported and prepared stays, and is searched in vain."""
    global _rests
    rested = _rests
    was_enabled = gc.isenabled()
    gc.disable()
    _rests = rested or was_enabled
    try:
        yield
    finally:
        _rests = rested
        if was_enabled:
            gc.enable()


@contextmanager
def collected_alone() -> Iterator[None]:
    """For a run: search for garbage, also within ``uncollected``, but only in what the run makes.

    What was imported and prepared for it, some 400,000 objects, stays; it is left out in the first run of a process,
    since later ones would keep what is left of those before.
    """
    global _has_run
    first, _has_run = not _has_run, True
    rests = _rests and not gc.isenabled()
    thresholds = gc.get_threshold()
    gc.set_threshold(max(thresholds[0], OBJECTS_BETWEEN_SEARCHES) if thresholds[0] else 0, *thresholds[1:])
    if first:
        gc.freeze()
    if rests:
        gc.enable()
    try:
        yield
    finally:
        gc.set_threshold(*thresholds)
        if rests:
            gc.disable()
        if first:
            gc.unfreeze()


def ends_uncollected() -> None:
    """Have this process end without a last search for garbage, which takes as long as drawing the pictures of a run.

    Modules and what they hold are taken apart as ever; what only garbage holds, the system frees.
    """
    atexit.unregister(gc.freeze)
    atexit.register(gc.freeze)


class _Announcements(logging.Handler):
    """Shows what takes seconds or minutes before a run: log records with ``announced``."""

    def emit(self, record: logging.LogRecord) -> None:
        if getattr(record, "announced", False):
            say(record.getMessage(), error=True)


@contextmanager
def announced() -> Iterator[None]:
    """Show which large meshes are being prepared, and what a search for a mass scaling tries."""
    handler = _Announcements(logging.INFO)
    loggers = [logging.getLogger(f"weavesim.{name}") for name in ("tools", "run.scaling")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.INFO)
        logger.addHandler(handler)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.removeHandler(handler)
            logger.setLevel(level)
