"""Lines of a table: comments, and cells between separators."""

from __future__ import annotations

import csv
import re

from .text import TableFault

SEPARATORS = ("\t", ";", ",", " ")
SEPARATOR_NAMES = {"\t": "tabs", ";": "semicolons", ",": "commas", " ": "blanks"}
_MARKS = ("#", "%", "/")
_COMMENT = re.compile(r"\s*(?P<mark>#+|%+|//)(?P<rest>.*)", re.DOTALL)
# What a spreadsheet writes in place of a value: "#N/A", "#DIV/0!", "#ZAHL!", "#####".
_SHEET_ERROR = re.compile(r"\s*#(?:(?:N/A|N/D|NV|[A-ZÄÖÜ0-9/]+[!?])(?:[\t;,\s]|$)|#+\s*[\t;,])")
_RULE = re.compile(r"[\s;,|+]*(?:-{3,}|={3,})[\s;,|+=-]*")
_TOKEN = re.compile(r'"((?:[^"]|"")*)"|(\S+)')


def comment_of(line: str, separator: str) -> str | None:
    """What a comment line contains after its mark; None if it is no comment.

    A mark that stands alone in its cell is a name or a unit ("#" for a number, "%" for a strain), not a comment.
    """
    match = _COMMENT.match(line) if line.lstrip()[:1] in _MARKS else None
    if match is None or _SHEET_ERROR.match(line):
        return None
    if separator != " " and match["mark"] in ("#", "%") and match["rest"].lstrip(" ").startswith(separator):
        return None
    return match["rest"]


def is_blank(line: str) -> bool:
    """True for a line without text, or with a rule of dashes only."""
    text = line.strip(" \t\ufeff")
    return not text or ("--" in text or "==" in text) and bool(_RULE.fullmatch(text))


def split_line(line: str, separator: str, number: int) -> list[str]:
    """Cells of a line, without the blanks around them and without their quotation marks.

    Raises:
        TableFault: quotation marks that do not match.
    """
    if separator == " ":
        return [match[1] if match[1] is not None else match[2] for match in _TOKEN.finditer(line)]
    if '"' not in line:
        return [cell.strip() for cell in line.split(separator)]
    # blanks between a quotation mark and a separator
    tight = re.sub(rf'"[ ]+(?={re.escape(separator)}|$)', '"', line.strip(" "))
    try:
        (row,) = csv.reader([tight], delimiter=separator, skipinitialspace=True, strict=True)
    except (csv.Error, ValueError):
        raise TableFault("a quotation mark that is not closed, or with text after it", number) from None
    return [cell.strip() for cell in row]


def trimmed(cells: list[str]) -> list[str]:
    """Cells without empty ones at the end."""
    count = len(cells)
    while count and not cells[count - 1]:
        count -= 1
    return cells[:count]


def split_names(line: str, separator: str, number: int, cell_count: int) -> list[str]:
    """Names of the columns in a header; ``cell_count`` is that of the values below it.

    Between blanks a name may contain blanks itself, if two or more stand between the names.
    """
    if separator != " ":
        return split_line(line, separator, number)
    wide = [name.strip('"') for name in re.split(r"\s{2,}", line.strip())]
    joined = split_line(re.sub(r"\s+(?=[\[({<])", "", line), separator, number)
    return wide if 1 < len(wide) == cell_count else joined
