"""From the bytes of a table to its lines, as an editor counts them."""

from __future__ import annotations

import re

LARGEST_LINE_COUNT = 2_000_000
LONGEST_LINE = 100_000
# What a file begins with that is no text, and what to do with it.
_OTHER_FORMATS = (
    (b"PK\x03\x04", "an Excel workbook or another zip archive: save the sheet as CSV"),
    (b"\xd0\xcf\x11\xe0", "an old Excel workbook: save the sheet as CSV"),
    (b"\x1f\x8b", "compressed: unpack it"),
    (b"%PDF", "a PDF: export the table as CSV"),
    (b"{\\rtf", "a document with formats: save it as plain text"),
)
_MARKS = (
    (b"\xef\xbb\xbf", "utf-8-sig", ""),
    (b"\xff\xfe\x00\x00", "utf-32", "UTF-32"),
    (b"\x00\x00\xfe\xff", "utf-32", "UTF-32"),
    (b"\xff\xfe", "utf-16", "UTF-16"),
    (b"\xfe\xff", "utf-16", "UTF-16"),
)
_CONTROL = re.compile("[\x00-\x08\x0b\x0e-\x1f\x7f]")


class TableFault(ValueError):
    """What is wrong in a table; the reader adds the name of the file."""

    def __init__(self, reason: str, line: int = 0) -> None:
        super().__init__(reason)
        self.line = line


class MissingColumn(TableFault):
    """No header has a column that is wanted."""


def text_lines(content: bytes) -> tuple[list[str], tuple[str, ...]]:
    """Lines without their ends, and notes on how they were read; line k of an editor is entry k - 1.

    Raises:
        TableFault: no text, or too much of it.
    """
    for start, advice in _OTHER_FORMATS:
        if content.startswith(start):
            raise TableFault(f"it is no text but {advice}")
    if content.count(b"\n") + content.count(b"\r") > 2 * LARGEST_LINE_COUNT:
        raise TableFault(f"more than {LARGEST_LINE_COUNT} lines")
    text, note = _decoded(content)
    text = text.removesuffix("\x1a")  # the end of a file in old systems
    if wrong := _CONTROL.search(text):
        above = len(re.findall(r"\r\n|\n|\r", text[: wrong.start()]))
        raise TableFault("it contains characters that no text has: it is binary, or damaged", above + 1)
    # other characters, at which str.splitlines splits, are no ends of lines for an editor
    lines = re.split(r"\r\n|\n|\r", text)
    for number, line in enumerate(lines, start=1):
        if len(line) > LONGEST_LINE:
            raise TableFault(f"more than {LONGEST_LINE} characters in a line", number)
    return lines, (note,) if note else ()


def _decoded(content: bytes) -> tuple[str, str]:
    for mark, encoding, name in _MARKS:
        if content.startswith(mark):
            try:
                return content.decode(encoding), f"read as {name}" if name else ""
            except UnicodeDecodeError as error:
                raise TableFault(f"it begins like {name or 'UTF-8'} but is none (byte {error.start})") from None
    if b"\0" in content:
        raise TableFault("it is binary, or UTF-16 without a mark at its beginning: save it as UTF-8")
    try:
        return content.decode("utf-8"), ""
    except UnicodeDecodeError:
        # numbers are the same in all of these; only names and comments depend on the choice
        try:
            return content.decode("cp1252"), "read as Windows-1252"
        except UnicodeDecodeError:
            return content.decode("latin-1"), "read as Latin-1"
