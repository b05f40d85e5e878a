"""The lines of a deck, with those of the files that it includes in their places."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ...errors import InputError
from ...input_files import read_bounded, shown, within_folder
from ..kinds import is_text
from ..source import LARGEST_TEXT, Source

# Number of a line in the deck, or in words where it is one of an included file.
Line = int | str

_INCLUDE = re.compile(rb"(?i)\*\s*include\s*,\s*input\s*=\s*(.+?)\s*\Z")
_MOST_LEVELS = 10
_MOST_FILES = 1000


def lines_of_deck(source: Source) -> Iterator[tuple[Line, bytes]]:
    """Lines without blanks around them, comments and empty ones left out.

    Raises:
        InputError: an included file outside the folder of the deck, or too many or too large ones.
    """
    return _Lines(source).of(source.data, None, 0)


class _Lines:
    def __init__(self, source: Source) -> None:
        self.source = source
        self.folder = source.path.parent
        self.byte_count = len(source.data)
        self.file_count = 0

    def of(self, data: bytes, name: str | None, level: int) -> Iterator[tuple[Line, bytes]]:
        for number, text in enumerate(data.splitlines(), 1):
            text = text.strip()
            if not text or text.startswith(b"**"):
                continue
            line: Line = number if name is None else f"{number} of {name}"
            included = _INCLUDE.match(text) if text.startswith(b"*") else None
            if included is None:
                yield line, text
            else:
                yield from self._included(line, included.group(1).strip(b"\"'"), level + 1)

    def _included(self, line: Line, reference: bytes, level: int) -> Iterator[tuple[Line, bytes]]:
        self.file_count += 1
        if level > _MOST_LEVELS or self.file_count > _MOST_FILES:
            raise self.source.error(f"line {line}: too many files include each other", "copy them into one")
        what = f"{self.source.name}, line {line}: included file"
        try:
            name = reference.decode()
        except UnicodeDecodeError:
            name = reference.decode("latin-1")
        path = within_folder(self.folder, name, what)
        data = read_bounded(path, what, LARGEST_TEXT)
        self.byte_count += len(data)
        if self.byte_count > LARGEST_TEXT:
            raise InputError(f"{what}: more than {LARGEST_TEXT / 2**20:g} MiB in all files together")
        if not is_text(data):
            raise InputError(f"{what}: it is no text")
        yield from self.of(data, shown(path.name), level)
