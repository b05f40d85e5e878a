"""The content of a mesh file while it is read, and the words for what is wrong with it."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import InputError
from ..input_files import path_of, read_bounded, shown
from .kinds import looks_like

# Bytes of a file that are still read: 40 million triangles of a binary STL. Text that is taken apart word by word, and
# what meshio reads, needs ten to twenty times its size in memory.
LARGEST_FILE = 2**31
LARGEST_TEXT = 2**29
# A mesh of more vertices or cells than this cannot be meant: it is refused before memory is taken for it.
LARGEST_COUNT = 10**8


@dataclass(frozen=True)
class Source:
    """A file that was opened.

    Attributes:
        path: as given.
        what: what it is to be, for messages: "tool mesh" or "blank mesh".
        data: the whole content, without the mark of UTF-8 at its start.
    """

    path: Path
    what: str
    data: bytes

    @property
    def name(self) -> str:
        """What it is and where, for messages."""
        return f"{self.what} {shown(self.path)}"

    @property
    def suffix(self) -> str:
        """In lower case, with its dot."""
        return self.path.suffix.lower()

    def error(self, problem: str, advice: str = "export the mesh again") -> InputError:
        """The reason why this file is refused. Never quotes the file: it may be somebody else's secret."""
        return InputError(f"{self.name} cannot be read: {problem}; {advice}.")

    def misnamed(self, expected: str, otherwise: str = "something else") -> InputError:
        """The reason why a file is refused that is not in the format that its name says, in words.

        Args:
            expected: the format that it should be in.
            otherwise: what it looks like if nothing is recognised.
        """
        return self.error(f"it looks like {looks_like(self.data) or otherwise}, not like {expected}")

    def line_of(self, position: int) -> int:
        """Number of the line, from 1, that contains the byte at ``position``."""
        return self.data.count(b"\n", 0, position) + 1


def opened(path: str | os.PathLike[str], what: str, large: tuple[str, ...] = ()) -> Source:
    """The file at ``path``; its name ends in one of ``large`` where ``LARGEST_FILE`` is its limit.

    Raises:
        InputError: missing, empty, not a regular file, or too large.
    """
    path = path_of(path, what)
    try:
        missing = not path.exists() and not path.is_symlink()
    except (OSError, ValueError):
        missing = False  # and why it cannot be looked at is said when it is opened
    if missing:
        raise InputError(f"{what} {shown(path)} does not exist, so it cannot be read; give the path of a mesh file.")
    data = read_bounded(path, what, LARGEST_FILE if path.suffix.lower() in large else LARGEST_TEXT)
    if not data.strip(b"\0 \t\r\n"):
        raise InputError(f"{what} {shown(path)} cannot be read: it is empty; export the mesh again.")
    return Source(path, what, data.removeprefix(b"\xef\xbb\xbf"))


def number(token: bytes) -> float:
    """A finite number, in Fortran's notation too.

    Raises:
        ValueError: anything else, such as NaN, or the digits with underscores that Python would take.
    """
    try:
        value = float(token)
    except ValueError:
        value = float(token.lower().replace(b"d", b"e"))
    if b"_" in token or not math.isfinite(value):
        raise ValueError
    return value


def numbers(tokens: Sequence[bytes]) -> list[float]:
    """``number`` of each token, for many of them.

    Raises:
        ValueError: one is not a finite number.
    """
    try:
        values = list(map(float, tokens))
    except ValueError:
        return [number(token) for token in tokens]
    if not all(map(math.isfinite, values)) or any(b"_" in token for token in tokens):
        raise ValueError
    return values


def whole(token: bytes) -> int:
    """A whole number of 64 bits.

    Raises:
        ValueError: anything else.
    """
    if b"_" in token or len(token) > 20:
        raise ValueError
    value = int(token)
    if abs(value) >= 2**62:
        raise ValueError
    return value


def listed(items: Sequence[object], most: int = 5) -> str:
    """The first few of ``items`` for a message."""
    text = ", ".join(map(str, items[:most]))
    return f"{text}, ..." if len(items) > most else text


def counted(count: int, word: str) -> str:
    """``count`` and a word, in the plural where it belongs: "1 line", "2 lines"."""
    return f"{count} {word}" if count == 1 else f"{count} {word}s"
