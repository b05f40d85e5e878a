"""Errors that a user can fix: what was given, what is allowed, what to do; and warnings that are not for the user."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator
from contextlib import contextmanager


class InputError(ValueError):
    """Bad input, found before a run starts. Scripts print it and exit with code 2."""


class RunError(RuntimeError):
    """A run that had to stop, for example because the state became non-finite."""


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """The end of a message about an unknown name: "; did you mean 'thickness'?", or nothing if none is near."""
    import difflib

    folded = {other.casefold(): other for other in known}
    near = difflib.get_close_matches(name[:80].casefold(), folded, n=1)
    return f"; did you mean {folded[near[0]]!r}?" if near else ""


@contextmanager
def logged_from(level: int, name: str = "weavesim") -> Iterator[None]:
    """Leave out what the logger ``name``, or one below it, says under ``level``; afterwards all is as before.

    Args:
        level: of ``logging``.
        name: of the logger.
    """
    logger = logging.getLogger(name)
    before = logger.level
    logger.setLevel(level)
    try:
        yield
    finally:
        logger.setLevel(before)
