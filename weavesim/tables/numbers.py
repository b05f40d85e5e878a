"""Numbers in the cells of a table: one decimal mark for all of them, or a refusal."""

from __future__ import annotations

import math
import re

from ..input_files import shown
from .text import TableFault

_EXPONENT = r"(?:[eEdD][+-]?[0-9]{1,5})?"
_PLAIN = re.compile(rf"[+-]?(?:[0-9]+(?:[.,][0-9]*)?|[.,][0-9]+){_EXPONENT}")
# Digits in groups of three: of thousands, or one group after a decimal mark.
_ONE_GROUP = re.compile(r"[+-]?[1-9][0-9]{0,2}[.,][0-9]{3}")
_GROUPS = re.compile(rf"[+-]?[0-9]{{1,3}}(?:([.,'’\s\u00a0\u202f\u2009])[0-9]{{3}})+(?:[.,][0-9]*)?{_EXPONENT}")
_NUMBER_AND_UNIT = re.compile(r"[+-]?[0-9.,]+(?:[eE][+-]?[0-9]+)?\s*(?:[^\W\d_]+(?:[/·* ][^\W\d_]+)*[²³]?|[°º%\"'])")
_NO_VALUE = {"nan", "-nan", "+nan", "inf", "-inf", "+inf", "infinity", "-infinity", "na", "n/a", "null", "none", "-"}
LONGEST_SHOWN = 30


def plain(cell: str) -> str:
    """A cell without what does not matter: blanks around it, and a minus sign from a word processor."""
    return cell.strip().replace("\u2212", "-")


def is_number(cell: str) -> bool:
    """True for what is meant as a number, even if it has separators of thousands."""
    text = plain(cell)
    return bool(_PLAIN.fullmatch(text) or _GROUPS.fullmatch(text))


def quoted(cell: str) -> str:
    """A cell in a message."""
    text = cell.strip()
    return f"'{shown(text[:LONGEST_SHOWN])}{'...' if len(text) > LONGEST_SHOWN else ''}'"


class DecimalMark:
    """Finds the one decimal mark of a table from all its numbers.

    Args:
        separator: of its columns. With semicolons commas are decimal; with anything else a number such as 1,234 has
            two readings, unless another number of the table shows what a comma means in it.
    """

    def __init__(self, separator: str) -> None:
        self._separator = separator
        self._first: dict[str, tuple[str, int]] = {}
        self._clear: set[str] = set()
        self._leading_zero: tuple[str, int] | None = None

    def see(self, cell: str, line: int) -> None:
        """Take a cell into account.

        Raises:
            TableFault: it shows another mark than the cells before.
        """
        mark = "," if "," in cell else "." if "." in cell else ""
        if not mark:
            if self._leading_zero is None and "0" in cell[:2] and re.fullmatch(r"[+-]?0[0-9]+", cell):
                self._leading_zero = (cell, line)
            return
        if mark in self._clear:  # then only its first occurrence matters
            return
        text = plain(cell)
        if not _PLAIN.fullmatch(text):
            return
        self._first.setdefault(mark, (cell, line))
        if not _ONE_GROUP.fullmatch(text):
            self._clear.add(mark)
        if len(self._first) > 1:
            (comma, comma_line), (point, point_line) = self._first[","], self._first["."]
            raise TableFault(
                f"a number with a comma ({quoted(comma)}, line {comma_line}) and one with a point ({quoted(point)}, "
                f"line {point_line}) in one table; write points, and no separators of thousands",
                max(comma_line, point_line),
            )

    def found(self) -> str:
        """The mark, after all cells were seen: a point if there is none.

        Raises:
            TableFault: the numbers have two readings.
        """
        if not self._first and self._leading_zero and self._separator == ",":
            cell, line = self._leading_zero
            raise TableFault(
                f"{quoted(cell)} looks like the end of a number that has a comma, and commas separate the columns; "
                "write a point, not a comma, in numbers",
                line,
            )
        if not self._first:
            return "."
        ((mark, (cell, line)),) = self._first.items()
        if mark in self._clear or mark == self._usual:
            return mark
        digits = plain(cell)
        raise TableFault(
            f"{quoted(cell)} has two readings, {digits.replace(mark, '.')} and {re.sub('[.,]', '', digits)}, and no "
            "other number of the table tells which; write a point in every number, such as "
            f"{digits.replace(mark, '.')}0, and no separators of thousands",
            line,
        )

    @property
    def _usual(self) -> str:
        return {";": ",", ",": ".", " ": "."}.get(self._separator, "")


def number(cell: str, mark: str, column: str, line: int) -> float:
    """The finite number in a cell.

    Raises:
        TableFault: there is none.
    """
    text = plain(cell)
    if _PLAIN.fullmatch(text) and ("," not in text or mark == ","):
        value = float(text.replace(",", ".").replace("d", "e").replace("D", "e"))
        if math.isfinite(value) and (value != 0.0 or not re.search("[1-9]", re.split("[eEdD]", text)[0])):
            return value
        raise TableFault(f"column {column}: {quoted(cell)} is out of the range of numbers", line)
    raise not_a_number(cell, column, line)


def not_a_number(cell: str, column: str, line: int) -> TableFault:
    """The fault of a cell that is no number."""
    return TableFault(f"column {column}: {_what_is_wrong(cell, plain(cell))}", line)


def _what_is_wrong(cell: str, text: str) -> str:
    if not text:
        return "no value"
    if text.casefold() in _NO_VALUE:
        return f"{quoted(cell)} is not a finite number"
    if _GROUPS.fullmatch(text):
        return f"{quoted(cell)} has separators of thousands, which are not read: write digits and a point"
    if _NUMBER_AND_UNIT.fullmatch(text):
        return f'{quoted(cell)} is not a number: write its unit in the header, as in "force [N]"'
    return f"{quoted(cell)} is not a number"
