"""Errors that a user can fix: what was given, what is allowed, what to do."""

from __future__ import annotations

from collections.abc import Iterable


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
