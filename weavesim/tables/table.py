"""Columns of a table by name, in the wanted units; whatever has more than one reading is refused with its line."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..input_files import MEBIBYTE, read_bounded, shown
from .header import Header, find_header, fold
from .numbers import DecimalMark, number, quoted
from .rows import comment_of, is_blank, split_line, trimmed
from .text import MissingColumn, TableFault, text_lines
from .units import Unit, bare_name, parse_unit

LARGEST_TABLE = 50 * MEBIBYTE
LARGEST_ROW_COUNT = 1_000_000
# A scale that the user gives may be rounded: 0.01745 for a degree.
_ROUNDED = 1.0e-3


@dataclass(frozen=True)
class Wanted:
    """A column that is wanted.

    Attributes:
        column: its name, with or without a unit, in any case.
        unit: the unit in which its values are needed, such as "rad"; "" for the SI unit of whatever it is.
        scale: multiplies the numbers as they stand in the file, in place of a conversion; None for none.
        needs_unit: refuse a column whose unit the file does not say.
    """

    column: str
    unit: str = ""
    scale: float | None = None
    needs_unit: bool = False


@dataclass(frozen=True)
class Columns:
    """Columns as read.

    Attributes:
        values: one array (row_count,) per wanted column.
        lines: line of each row (row_count,), as an editor counts.
        notes: what was not obvious in reading them: conversions, where the header was found.
    """

    values: tuple[np.ndarray, ...]
    lines: np.ndarray
    notes: tuple[str, ...]


class Table:
    """The text of a table, from which columns are read by name.

    Attributes:
        path, what: of the file, and what it is called in messages.
        lines: of the text.
        notes: what was not obvious in reading it.
    """

    def __init__(self, path: Path, what: str, lines: list[str], notes: tuple[str, ...]) -> None:
        self.path, self.what = path, what
        self.lines, self.notes = lines, notes

    def columns(self, *wanted: Wanted) -> Columns:
        """The wanted columns, row by row.

        Raises:
            InputError: a column that is missing or occurs twice, a unit that does not fit, a cell that is no number,
                or numbers that can be read in two ways; with the line.
        """
        with faults_of(self.path, self.what):
            return self._read(wanted)

    def unit(self, column: str) -> Unit | None:
        """The unit that the header gives to a column; None if it gives none.

        Raises:
            InputError: a column that is missing or occurs twice.
        """
        with faults_of(self.path, self.what):
            header = find_header(self.lines, [column])
        return header.units[header.places[0]]

    def names_beside(self, column: str) -> tuple[str, ...]:
        """Names of all columns of the header of a column, without their units, in lower case with underscores.

        Raises:
            InputError: a column that is missing or occurs twice.
        """
        with faults_of(self.path, self.what):
            header = find_header(self.lines, [column])
        return tuple(fold(bare_name(name)).replace(" ", "_") for name in header.names if name)

    def has(self, column: str) -> bool:
        """Whether there is such a column.

        Raises:
            InputError: it occurs twice, or the table cannot be read.
        """
        with faults_of(self.path, self.what):
            try:
                find_header(self.lines, [column])
            except MissingColumn:
                return False
        return True

    def _read(self, wanted: Sequence[Wanted]) -> Columns:
        header = find_header(self.lines, [item.column for item in wanted])
        scales, notes = [], [*self.notes, *header.notes]
        for item, place in zip(wanted, header.places, strict=True):
            scale, note = _scale(item, header, place)
            scales.append(scale)
            notes += [note] if note else []
        cells, lines, mark = _cells(self.lines, header)
        if mark == ",":
            notes.append("decimal commas")
        values = []
        for place, scale, column in zip(header.places, scales, cells, strict=True):
            name = quoted(header.names[place])
            array = np.array([number(cell, mark, name, line) for cell, line in zip(column, lines, strict=True)])
            with np.errstate(over="ignore"):
                array = array if scale == 1.0 else scale * array
            if not np.all(np.isfinite(array)):
                raise TableFault(f"column {name}: out of the range of numbers after its conversion")
            values.append(array)
        return Columns(tuple(values), np.array(lines), tuple(notes))


def read_table(path: str | Path, what: str) -> Table:
    """Read the text of a table.

    Args:
        path: of the file.
        what: name of such a file in messages, such as "measured angles".

    Raises:
        InputError: a file that is missing, is not regular, is too large, or is no text.
    """
    content = read_bounded(path, what, LARGEST_TABLE)
    with faults_of(Path(path), what):
        lines, notes = text_lines(content)
    return Table(Path(path), what, lines, notes)


@contextmanager
def faults_of(path: Path, what: str) -> Iterator[None]:
    """Raise the faults of a table as an InputError with the name of its file."""
    try:
        yield
    except TableFault as fault:
        line = f", line {fault.line}" if fault.line else ""
        raise InputError(f"{what} {shown(path)}{line}: {fault}") from None


def _cells(lines: list[str], header: Header) -> tuple[list[list[str]], list[int], str]:
    """Cells of the wanted columns, the line of each row, and the decimal mark."""
    mark, separator, count = DecimalMark(header.separator), header.separator, len(header.names)
    result: list[list[str]] = [[] for _ in header.places]
    row_lines: list[int] = []
    for line_number in range(header.first_row, len(lines) + 1):
        line = lines[line_number - 1]
        if is_blank(line) or comment_of(line, separator) is not None:
            continue
        cells = trimmed(split_line(line, separator, line_number))
        if not cells:
            continue
        header.check_row(cells, line_number)
        for place in header.places:
            header.check_has(cells, place, line_number)
        for cell in cells[:count]:
            mark.see(cell, line_number)
        for column, place in zip(result, header.places, strict=True):
            column.append(cells[place])
        row_lines.append(line_number)
        if len(row_lines) > LARGEST_ROW_COUNT:
            raise TableFault(f"more than {LARGEST_ROW_COUNT} rows; thin them out", line_number)
    if not row_lines:
        raise TableFault("no rows below the header", header.line)
    return result, row_lines, mark.found()


def _scale(wanted: Wanted, header: Header, place: int) -> tuple[float, str]:
    """Factor from the numbers in a column to the wanted unit, and a note if that is a conversion."""
    name, unit = quoted(header.names[place]), header.units[place]
    target = parse_unit(wanted.unit) if wanted.unit else None
    if unit is None:
        if wanted.needs_unit:
            raise TableFault(
                f'column {name} does not say its unit; write it in the header, as in "{wanted.column} [{wanted.unit}]"',
                header.line,
            )
        return (1.0 if wanted.scale is None else wanted.scale), ""
    if wanted.scale is not None:
        return _checked_scale(wanted.scale, unit, target, name, header.line), ""
    in_unit = f" in {wanted.unit}" if wanted.unit else ""
    if not unit.is_known:
        raise TableFault(
            f"column {name}: {quoted(unit.text)} is not known as a unit; write a known one such as "
            f"[{wanted.unit or 'N'}], or give scale = the factor to the value{in_unit}",
            header.line,
        )
    if target and unit.dimension != target.dimension:
        raise TableFault(
            f"column {name} is in {unit.text}, which cannot be converted to {wanted.unit}; is it the right column?",
            header.line,
        )
    factor = 1.0 if target and unit.same_as(target) else unit.factor / (target.factor if target else 1.0)
    if factor == 1.0:
        return 1.0, ""
    return factor, f"column {name} converted from {unit.text} to {wanted.unit or 'SI'}"


def _checked_scale(scale: float, unit: Unit, target: Unit | None, name: str, line: int) -> float:
    """The user's scale, if it does not contradict the unit in the header."""
    if not unit.is_known or (target and unit.dimension != target.dimension):
        return scale  # a conversion that only the user knows, such as of a force to one per width
    factor = unit.factor / (target.factor if target else 1.0)
    if abs(abs(scale) - factor) > _ROUNDED * factor:
        raise TableFault(
            f"column {name} is in {unit.text}, so that its values times {factor:.9g} are wanted, but scale = {scale:g} "
            "is given; leave the scale out, or the unit in the header if it is wrong",
            line,
        )
    return scale
