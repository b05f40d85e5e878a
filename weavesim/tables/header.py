"""The header of a table: found below whatever a machine writes above it, with units in it or in the line below."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from ..errors import did_you_mean
from ..input_files import shown
from .numbers import is_number, not_a_number, quoted
from .rows import SEPARATOR_NAMES, SEPARATORS, comment_of, is_blank, split_line, split_names, trimmed
from .text import MissingColumn, TableFault
from .units import Unit, bare_name, split_header, unit_cell

# Lines above a header, and between it and the first row; lines of one header; columns that a message lists.
LONGEST_PREAMBLE = 1000
LONGEST_GAP = 100
LONGEST_HEADER = 5
LISTED_COUNT = 12
LARGEST_COLUMN_COUNT = 2000
# Given name and unit of every column of a line, the places of those that are wanted; None if it is not their header.
Chooser = Callable[[Sequence[tuple[str, Unit | None]]], tuple[int, ...] | None]
_INVISIBLE = re.compile("[\u00ad\u200b-\u200f\u202a-\u202e\u2060-\u2064\ufeff]")


@dataclass(frozen=True)
class Header:
    """Where the columns are.

    Attributes:
        names: of all columns, as written, without empty ones at the end.
        units: of all columns; None for one without.
        places: index of each wanted column.
        separator: between cells.
        line: of the header.
        first_row: line of the first row.
        notes: what was not obvious.
    """

    names: tuple[str, ...]
    units: tuple[Unit | None, ...]
    places: tuple[int, ...]
    separator: str
    line: int
    first_row: int
    notes: tuple[str, ...] = ()

    def check_row(self, cells: Sequence[str], line: int) -> None:
        """Raise TableFault for a row that does not belong under this header; ``cells`` has no empty ones at its end."""
        if len(cells) > len(self.names):
            raise TableFault(self._count_fault(len(cells)), line)
        for place in self._unnamed:
            # an index, as data frames write it, comes first; a value elsewhere may be the decimals of the one before
            if place < len(cells) and cells[place] and not (place == 0 and cells[0].isdecimal()):
                raise TableFault(self._count_fault(len([cell for cell in cells if cell])), line)
        if cells[-1] == self.names[len(cells) - 1] and [fold(cell) for cell in cells] == [fold(n) for n in self.names]:
            raise TableFault("the header occurs again: more than one table; give each its own file", line)

    @cached_property
    def _unnamed(self) -> tuple[int, ...]:
        return tuple(place for place, name in enumerate(self.names) if not name)

    def check_has(self, cells: Sequence[str], place: int, line: int) -> None:
        """Raise TableFault for a row without a value in a column."""
        if place < len(cells) and cells[place]:
            return
        reason = f"no value in column {quoted(self.names[place])}"
        if len(cells) == 1 and len(self.names) > 1 and any(other in cells[0] for other in SEPARATORS):
            separators = SEPARATOR_NAMES[self.separator]
            reason += f": 1 value under {len(self.names)} names, whose separators are {separators}"
        raise TableFault(reason, line)

    def _count_fault(self, value_count: int) -> str:
        name_count = len(self.names) - len(self._unnamed)
        values = "1 value" if value_count == 1 else f"{value_count} values"
        names = "1 name" if name_count == 1 else f"{name_count} names"
        advice = ""
        if self.separator == ",":
            advice = ": commas separate the columns, so write a point, not a comma, in numbers"
        return f"{values} under {names}{advice}"


def fold(name: str) -> str:
    """A name without what does not tell names apart: case, blanks, underscores."""
    visible = _INVISIBLE.sub("", unicodedata.normalize("NFKC", name))
    return re.sub(r"[\s_-]+", " ", visible.casefold()).strip()


def find_header(lines: list[str], wanted: Sequence[str], choose: Chooser | None = None) -> Header:
    """The header that has all wanted columns.

    It is the first line with their names that has values below it. A line of units may stand between; a comment is
    taken for the header only if nothing else can be.

    Args:
        lines: of the table.
        wanted: names of the columns; only for messages if ``choose`` is given.
        choose: finds the columns by another rule, and a header may then have a name twice.

    Raises:
        TableFault: no such header, a column that occurs twice, or no values below it.
    """
    fault: TableFault | None = None
    declared = _declared_separator(lines)
    for in_comment in (False, True):
        for candidate in _candidates(lines, () if choose else wanted, declared, in_comment, choose):
            try:
                header = candidate.header(lines, wanted)
            except TableFault as error:
                fault = error
                continue
            if header:
                return header
        if fault:
            raise fault
    raise _missing(lines, wanted, declared)


@dataclass(frozen=True)
class _Candidate:
    """A line that may be the header: its text, its number, the last line that belongs to it."""

    text: str
    line: int
    last: int
    separator: str
    in_comment: bool
    has_more_above: bool
    choose: Chooser | None = None

    def header(self, lines: list[str], wanted: Sequence[str]) -> Header | None:
        """The header in this line; None if a wanted column is missing.

        Raises:
            TableFault: what is below are no values, or a wanted column occurs twice.
        """
        units: list[str] = []
        for number in range(self.last + 1, min(self.last + LONGEST_GAP, len(lines)) + 1):
            line = lines[number - 1]
            if is_blank(line):
                continue
            comment = comment_of(line, self.separator)
            if comment is not None:
                units = units or self._units_in_comment(line, comment, number)
                continue
            cells = trimmed(split_line(line, self.separator, number))
            if not cells:
                continue
            if not units and _are_units(cells):
                units = cells
                continue
            return self._above(cells, number, units or self._units_above(lines), wanted)
        if self._places(wanted, self._names(0), [])[0] is None:
            return None
        raise TableFault("no rows below the header", self.line)

    def _above(self, cells: list[str], number: int, units: list[str], wanted: Sequence[str]) -> Header | None:
        """The header, given the first row below it."""
        names = self._names(len(cells))
        places, merged = self._places(wanted, names, units)
        if places is None or all(map(is_number, names)):
            return None
        notes = []
        if self.in_comment:
            notes.append(f"header taken from the comment in line {self.line}")
        elif self.has_more_above:
            notes.append(f"header found in line {self.line}")
        header = Header(tuple(names), tuple(merged), places, self.separator, self.line, number, tuple(notes))
        header.check_row(cells, number)
        for place in places:
            header.check_has(cells, place, number)
            if not is_number(cells[place]):
                raise not_a_number(cells[place], quoted(names[place]), number)
        return header

    def _units_above(self, lines: list[str]) -> list[str]:
        """The cells of a line of units directly above the header; [] if there is none."""
        line = lines[self.line - 2] if self.line > 1 else ""
        if not line or is_blank(line) or '"' in self.text or comment_of(line, self.separator) is not None:
            return []
        cells = trimmed(split_line(line, self.separator, self.line - 1))
        return cells if all(map(is_unit, cells)) and len(cells) == len(self._names(len(cells))) else []

    def _names(self, cell_count: int) -> list[str]:
        names = trimmed(split_names(self.text, self.separator, self.line, cell_count))
        if len(names) > LARGEST_COLUMN_COUNT:
            raise TableFault(f"more than {LARGEST_COLUMN_COUNT} columns", self.line)
        return names

    def _places(
        self, wanted: Sequence[str], names: list[str], units: list[str]
    ) -> tuple[tuple[int, ...] | None, list[Unit | None]]:
        """Index of each wanted column, None if one is missing; and the units of all columns."""
        split = [split_header(name) for name in names]
        merged: list[Unit | None] = []
        for index, (_, unit) in enumerate(split):
            cell = units[index] if index < len(units) else ""
            below = (unit_cell(cell) or Unit(cell, is_known=False)) if cell else None
            if unit and unit.is_known and below and not unit.same_as(below):
                raise TableFault(
                    f"column {quoted(names[index])} has another unit in the line of units, {quoted(units[index])}",
                    self.line,
                )
            merged.append(below or unit)
        if self.choose is not None:
            return self.choose([(name, unit) for (name, _), unit in zip(split, merged, strict=True)]), merged
        places, doubled = [], []
        for item in wanted:
            name, unit = split_header(item)
            found = [
                index
                for index, (other, _) in enumerate(split)
                if fold(other) == fold(name) and (unit is None or not unit.is_known or _same_unit(merged[index], unit))
            ]
            if not found:  # a unit that is not known may be one
                alike = [index for index, other in enumerate(names) if fold(bare_name(other)) == fold(name)]
                found = alike if len(alike) == 1 and unit is None else []
            if not found:
                return None, merged
            places += found
            doubled += [item] if len(found) > 1 else []
        if doubled:
            raise TableFault(self._twice(split), self.line)
        return tuple(places), merged

    def _twice(self, split: Sequence[tuple[str, Unit | None]]) -> str:
        """The reason of a fault: every column that occurs more than once."""
        where: dict[str, list[int]] = {}
        for index, (name, _) in enumerate(split):
            if name:
                where.setdefault(fold(name), []).append(index)
        doubled = [
            f"column {shown(split[found[0]][0])} occurs twice, as columns {', '.join(str(k + 1) for k in found)}"
            for found in where.values()
            if len(found) > 1
        ]
        return f"{'; '.join(doubled[:LISTED_COUNT])}; give every column its own name, or each test its own file"

    def _units_in_comment(self, line: str, comment: str, number: int) -> list[str]:
        """The cells of a comment that is a line of units; [] if it is none."""
        for text in (line, comment):
            cells = [cell for cell in split_line(text, self.separator, number) if cell] if '"' not in text else []
            if len(cells) == len(self._names(len(cells))) and all(map(is_unit, cells)):
                return cells
        return []


def _same_unit(unit: Unit | None, other: Unit) -> bool:
    return unit is not None and unit.same_as(other)


def is_unit(cell: str) -> bool:
    """True for a unit that is known."""
    unit = unit_cell(cell)
    return unit is not None and unit.is_known


def _are_units(cells: list[str]) -> bool:
    """True for a line of units: no number, and at least one unit; texts may stand under other columns."""
    return not any(map(is_number, cells)) and any(map(is_unit, cells))


def _candidates(
    lines: list[str], wanted: Sequence[str], declared: str | None, in_comment: bool, choose: Chooser | None = None
) -> Iterator[_Candidate]:
    """Lines in which all wanted names occur."""
    folded = [fold(split_header(name)[0]) for name in wanted]
    has_more_above = False
    for number, line in enumerate(lines[:LONGEST_PREAMBLE], start=1):
        comment = comment_of(line, declared or _separator(line))
        text = comment if in_comment else (line if comment is None else None)
        if text is None or is_blank(text):
            continue
        last = number
        while text.count('"') % 2 and last - number < LONGEST_HEADER and last < len(lines):  # a break within a name
            text += " " + lines[last]
            last += 1
        text = text.strip(" \ufeff")
        whole = fold(text)
        if all(name in whole for name in folded):
            separator = declared or _separator(text)
            yield _Candidate(text, number, last, separator, in_comment, has_more_above, choose)
        has_more_above |= not (number == 1 and declared)


def _separator(line: str) -> str:
    """The strongest separator that occurs outside quotation marks."""
    outside = re.sub(r'"[^"]*"', "", line.strip())
    return next((separator for separator in SEPARATORS if separator in outside), " ")


def _declared_separator(lines: list[str]) -> str | None:
    """The separator that the first line declares for spreadsheets, as in "sep=;"; None without such a line."""
    match = re.fullmatch(r'"?sep=(.)"?[\t;,]*', lines[0].strip(" \ufeff"), re.IGNORECASE) if lines else None
    if match is None:
        return None
    if match[1] not in SEPARATORS:
        raise TableFault(f"sep={quoted(match[1])}: columns must be separated by commas, semicolons, tabs or blanks", 1)
    return match[1]


def _missing(lines: list[str], wanted: Sequence[str], declared: str | None) -> MissingColumn:
    """Why no header has the wanted columns; what the file contains is shown only if it is a table."""
    what = "column" if len(wanted) == 1 else "columns"
    needed = f"the {what} {', '.join(shown(name) for name in wanted)}"
    above: tuple[int, str] | None = None
    for number, line in enumerate(lines[:LONGEST_PREAMBLE], start=1):
        separator = declared or _separator(line)
        comment = comment_of(line, separator)
        if is_blank(line):
            continue
        cells = [] if comment is not None else [cell for cell in split_line(line, separator, 0) if cell]
        if cells and all(map(is_number, cells)):
            if above is None:
                return MissingColumn(
                    f"no header: write the names of the columns above the numbers; needed is {needed}", number
                )
            return _not_among(above, wanted, declared, len(cells))
        if comment is not None or not _are_units(cells):
            above = (number, line if comment is None else comment)
    if all(map(is_blank, lines)):
        return MissingColumn(f"it is empty; needed is {needed}")
    return MissingColumn(f"no table with {needed}: no line has these names, with numbers below")


def _not_among(above: tuple[int, str], wanted: Sequence[str], declared: str | None, cell_count: int) -> MissingColumn:
    """A fault that lists the columns of the header in ``above``."""
    number, line = above
    names = [name for name in split_names(line, declared or _separator(line), number, cell_count) if name]
    folded = {fold(split_header(name)[0]) for name in names}
    missing = [name for name in wanted if fold(split_header(name)[0]) not in folded] or list(wanted)
    text = f"no column {', '.join(shown(name) for name in missing)}"
    if len(names) < 2 and cell_count < 2:
        return MissingColumn(text, number)
    listed = ", ".join(map(quoted, names[:LISTED_COUNT])) + (", ..." if len(names) > LISTED_COUNT else "")
    hint = did_you_mean(missing[0], [*names, *map(bare_name, names)])
    if fold(f"{missing[0]}_m") in map(fold, names):
        hint = f'; a column in metres is called "{missing[0]} [m]"'
    return MissingColumn(f"{text} among {listed}{hint}", number)
