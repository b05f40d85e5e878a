"""Text for the terminal, which may be closed, a broken pipe or a full disk: then a run goes on in silence."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from typing import Any, TextIO


class SteadyStream:
    """Hands text on to a stream until that fails, then keeps silent.

    Args:
        stream: the stream; None if there is none.
    """

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        if self._stream is not None:
            try:
                return self._stream.write(text)
            except (OSError, ValueError):  # ValueError: it is closed
                self._stream = None
        return len(text)

    def flush(self) -> None:
        if self._stream is not None:
            try:
                self._stream.flush()
            except (OSError, ValueError):
                self._stream = None

    def isatty(self) -> bool:
        try:
            return self._stream is not None and self._stream.isatty()
        except (OSError, ValueError):
            return False

    def fileno(self) -> int:
        if self._stream is None:
            raise OSError("there is no stream")
        return self._stream.fileno()

    @property
    def encoding(self) -> str:
        return getattr(self._stream, "encoding", None) or "utf-8"


def say(text: str, *, error: bool = False) -> None:
    """Print a line to standard output, or to standard error."""
    stream: Any = sys.stderr if error else sys.stdout
    encoding = getattr(stream, "encoding", None) or "utf-8"
    steady = SteadyStream(stream)
    steady.write(text.encode(encoding, "backslashreplace").decode(encoding) + "\n")
    steady.flush()


def hold_standard_streams() -> None:
    """Open what is closed of standard input, output and error: a file of results would get its number otherwise."""
    for number, flags in ((0, os.O_RDONLY), (1, os.O_WRONLY), (2, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            with suppress(OSError):
                nowhere = os.open(os.devnull, flags)
                if nowhere != number:
                    os.dup2(nowhere, number)
                    os.close(nowhere)


def let_go_of_standard_streams() -> None:
    """Flush them; what cannot be flushed goes nowhere, since Python would end with exit code 120 for it."""
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except (OSError, ValueError):
            with suppress(OSError, ValueError):
                nowhere = os.open(os.devnull, os.O_WRONLY)
                os.dup2(nowhere, stream.fileno())
                os.close(nowhere)
