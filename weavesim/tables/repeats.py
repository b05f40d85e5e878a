"""Repeats of one test side by side in a table: columns are found by what they are called, and grouped by specimen."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import did_you_mean
from ..input_files import shown
from .header import LISTED_COUNT, Header, find_header, fold
from .numbers import DecimalMark, is_number, number, quoted
from .rows import comment_of, is_blank, split_line, trimmed
from .table import LARGEST_ROW_COUNT, Table, faults_of
from .text import TableFault
from .units import Unit, bare_name, parse_unit, split_header

LARGEST_REPEAT_COUNT = 100
_SPECIMEN = (
    r"(?:specimen|sample|test|repeat|repetition|run|probe|prüfling|versuch|messung|essai|éprouvette|no|nr|n°)\.?"
)
_NUMBER_LAST = re.compile(rf"(?P<name>.*?[^\W\d_][)\]]?)[\s.,:;#(]*(?:{_SPECIMEN})?[\s#(]*(?P<label>\d{{1,3}})\)?")
_NUMBER_FIRST = re.compile(rf"{_SPECIMEN}?[\s#(]*(?P<label>\d{{1,3}})[)\s.,:;-]*(?P<name>[^\W\d_].*)")
# "force [N] 2"
_NUMBER_BEHIND_UNIT = re.compile(r"(?P<head>.*[\])])\s*[#(]?(?P<label>\d{1,3})\)?")


@dataclass(frozen=True)
class Role:
    """What a column may be.

    Attributes:
        name: in messages and results, such as "angle".
        names: ways to write it in a header, without unit and number of the specimen.
        units: SI units of which its own must be one, such as ("N", "N/m").
        is_required: refuse a table without it.
    """

    name: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    is_required: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "names", tuple(fold(name) for name in (self.name, *self.names)))


@dataclass(frozen=True)
class Repeat:
    """One test of several in a table.

    Attributes:
        label: number of the specimen as in the header, "" for the only one.
        columns: values by role in SI units, (n,) each.
        units: unit of each, one of those of its role.
        headers: name of each column as written.
        lines: line of each row, (n,), as an editor counts.
    """

    label: str
    columns: Mapping[str, np.ndarray]
    units: Mapping[str, str]
    headers: Mapping[str, str]
    lines: np.ndarray


@dataclass(frozen=True)
class Repeats:
    """All tests of a table, and what was not obvious in reading it."""

    tests: tuple[Repeat, ...]
    notes: tuple[str, ...]


def read_repeats(table: Table, roles: Sequence[Role], one_of: Sequence[str] = ()) -> Repeats:
    """All repeats in a table.

    Columns of one specimen have the same number in their names, or the same order among equal names. A single column
    without a number belongs to all of them. A shorter test ends with empty cells.

    Args:
        table: as read.
        roles: of the columns; others are ignored.
        one_of: names of roles of which a table must have at least one.

    Raises:
        InputError: a column that is missing, without a unit or in a wrong one, a cell that is no number, a gap, or
            numbers that can be read in two ways; with line and column.
    """
    with faults_of(table.path, table.what):
        return _read(table, roles, one_of)


def _read(table: Table, roles: Sequence[Role], one_of: Sequence[str]) -> Repeats:
    def choose(columns: Sequence[tuple[str, Unit | None]]) -> tuple[int, ...] | None:
        found = [(place, _role_of(name, roles)) for place, (name, _) in enumerate(columns)]
        names = {role.name for _, match in found if match for role in match[:1]}
        if not all(role.name in names for role in roles if role.is_required) or (one_of and not names & set(one_of)):
            return None
        return tuple(place for place, match in found if match)

    needed = [role.name for role in roles if role.is_required] or list(one_of)
    try:
        header = find_header(table.lines, needed, choose)
    except TableFault as fault:
        if not str(fault).startswith(("no column", "no table")):
            raise
        raise _missing(table.lines, roles, one_of) from None
    groups = _groups(header, roles)
    cells, mark = _cells(table.lines, header, groups)
    notes = [*table.notes, *header.notes]
    if mark == ",":
        notes.append("decimal commas")
    if len(groups) > 1:
        notes.append(f"{len(groups)} repeats in columns")
    tests = []
    for label, places in groups.items():
        rows = cells[label]
        if not rows:
            raise TableFault(f"no rows of specimen {label or 1}", header.line)
        columns, units, headers = {}, {}, {}
        for index, (role, place) in enumerate(places.items()):
            name = quoted(header.names[place])
            unit, scale, note = _unit(next(r for r in roles if r.name == role), header, place)
            if note and note not in notes:
                notes.append(note)
            values = np.array([number(row[index], mark, name, line) for line, row in rows])
            columns[role] = values if scale == 1.0 else scale * values
            units[role], headers[role] = unit, header.names[place]
        tests.append(Repeat(label, columns, units, headers, np.array([line for line, _ in rows])))
    return Repeats(tuple(tests), tuple(notes))


def _role_of(name: str, roles: Sequence[Role]) -> tuple[Role, str] | None:
    """Role and number of the specimen of a column; None for a column of another kind."""
    texts = [fold(name)]
    if match := _NUMBER_BEHIND_UNIT.fullmatch(name.strip()):
        texts.append(fold(f"{split_header(match['head'])[0]} {match['label']}"))
    for text in texts:
        for role in roles:
            if text in role.names:
                return role, ""
        for pattern in (_NUMBER_LAST, _NUMBER_FIRST):
            if match := pattern.fullmatch(text):
                for role in roles:
                    if match["name"].strip(" .,:;-#(") in role.names:
                        return role, str(int(match["label"]))
    return None


def _groups(header: Header, roles: Sequence[Role]) -> dict[str, dict[str, int]]:
    """Place of each role, by specimen."""
    found: dict[str, dict[str, list[int]]] = {}
    for place in header.places:
        match = _role_of(split_header(header.names[place])[0], roles)
        assert match is not None
        found.setdefault(match[0].name, {}).setdefault(match[1], []).append(place)
    by_label: dict[str, dict[str, int]] = {}
    for role, labels in found.items():
        places: dict[str, int] = {}
        for label, several in labels.items():
            if len(several) > 1 and label:
                name = shown(split_header(header.names[several[0]])[0])
                raise TableFault(
                    f"column {name} occurs twice, as columns {', '.join(str(k + 1) for k in several)}; give every "
                    "specimen its own number",
                    header.line,
                )
            for k, place in enumerate(several):
                places[label if len(several) == 1 else str(k + 1)] = place
        by_label[role] = places
    numbers = dict.fromkeys(label for places in by_label.values() if len(places) > 1 for label in places)
    groups: dict[str, dict[str, int]] = {label: {} for label in numbers or dict.fromkeys(next(iter(by_label.values())))}
    if len(groups) > LARGEST_REPEAT_COUNT:
        raise TableFault(f"{len(groups)} specimens; at most {LARGEST_REPEAT_COUNT} are read", header.line)
    for role, places in by_label.items():
        if len(places) == 1:  # of all specimens
            (place,) = places.values()
            places = {label: place for label in groups}
        for label in groups:
            if label not in places:
                other = next(header.names[place] for place in groups[label].values()) if groups[label] else label
                raise TableFault(
                    f"column {quoted(other)} has no column {role!r} of the same specimen {label}; number the columns "
                    "of each specimen alike, or give one without a number for all",
                    header.line,
                )
            groups[label][role] = places[label]
    return groups


def _cells(
    lines: list[str], header: Header, groups: Mapping[str, Mapping[str, int]]
) -> tuple[dict[str, list[tuple[int, list[str]]]], str]:
    """Line and cells of every row of each specimen, in the order of its roles, and the decimal mark."""
    mark = DecimalMark(header.separator)
    result: dict[str, list[tuple[int, list[str]]]] = {label: [] for label in groups}
    shared = {place for places in groups.values() for place in places.values()} if len(groups) > 1 else set()
    shared = {place for place in shared if all(place in places.values() for places in groups.values())}
    wanted = {place for places in groups.values() for place in places.values()}
    ended: dict[str, int] = {}
    row_count = 0
    for line_number in range(header.first_row, len(lines) + 1):
        line = lines[line_number - 1]
        if is_blank(line) or comment_of(line, header.separator) is not None:
            continue
        row = split_line(line, header.separator, line_number)
        if not (cells := trimmed(row)):
            continue
        header.check_row(cells, line_number)
        cells += [""] * (len(header.names) - len(cells))
        for cell in cells[: len(header.names)]:
            mark.see(cell, line_number)
        row_count += 1
        if row_count > LARGEST_ROW_COUNT:
            raise TableFault(f"more than {LARGEST_ROW_COUNT} rows; thin them out", line_number)
        for label, places in groups.items():
            values = [cells[place] for place in places.values()]
            own = [cells[place] for place in places.values() if place not in shared]
            if len(groups) > 1 and not any(own) or not all(values) and _has_others(cells, wanted):
                ended.setdefault(label, line_number)
                continue
            for place, value in zip(places.values(), values, strict=True):
                if not value:
                    header.check_has(cells, place, line_number)
            if label in ended:
                place = next((p for p in places.values() if p not in shared), next(iter(places.values())))
                name = quoted(header.names[place])
                raise TableFault(f"no value in column {name}: a gap, after which it goes on", ended[label])
            result[label].append((line_number, values))
    if not row_count:
        raise TableFault("no rows below the header", header.line)
    return result, mark.found()


def _has_others(cells: Sequence[str], wanted: set[int]) -> bool:
    """True for a row with values of other tests, which may be longer than the wanted one."""
    return any(cell and is_number(cell) for place, cell in enumerate(cells) if place not in wanted)


def _unit(role: Role, header: Header, place: int) -> tuple[str, float, str]:
    """The unit of a role that a column is in, the factor to it, and a note on a conversion."""
    name, unit, line = quoted(header.names[place]), header.units[place], header.line
    if unit is None and (match := _NUMBER_BEHIND_UNIT.fullmatch(header.names[place].strip())):
        unit = split_header(match["head"])[1]
    allowed = " or ".join(role.units)
    if unit is None:
        example = f'"{role.name} [{_usual(role.units[0])}]"'
        raise TableFault(f"column {name} does not say its unit; write it in the header, as in {example}", line)
    if not unit.is_known:
        raise TableFault(
            f"column {name}: {quoted(unit.text)} is not known as a unit; write one of {role.name}, such as "
            f"[{_usual(role.units[0])}]",
            line,
        )
    for text in role.units:
        target = parse_unit(text) or Unit(text)
        if unit.dimension == target.dimension:
            if unit.same_as(target):
                return text, 1.0, ""
            return text, unit.factor / target.factor, f"{role.name} converted from {unit.text} to {text}"
    raise TableFault(
        f"column {name} is in {unit.text}, which cannot be converted to {allowed}; is it the right column?", line
    )


def _usual(unit: str) -> str:
    return {"rad": "deg", "m": "mm", "1": "%"}.get(unit, unit)


def _missing(lines: list[str], roles: Sequence[Role], one_of: Sequence[str]) -> TableFault:
    """Why no line is the header: the line that is nearest to one, and what it lacks."""
    required = [role for role in roles if role.is_required]
    either = [role for role in roles if role.name in one_of]
    best: tuple[int, int, list[str]] | None = None
    for line_number, line in enumerate(lines[:1000], start=1):
        if is_blank(line):
            continue
        for separator in ("\t", ";", ","):
            if separator not in line:
                continue
            names = [name for name in split_line(line, separator, line_number) if name]
            count = sum(_role_of(split_header(name)[0], roles) is not None for name in names)
            if count and (best is None or count > best[0]):
                best = (count, line_number, names)
            break
    needed = ", ".join(f"{role.name} [{_usual(role.units[0])}]" for role in required)
    if either:
        needed += " and " + " or ".join(f"{role.name} [{_usual(role.units[0])}]" for role in either)
    if best is None:
        return TableFault(f"no table with the columns {needed}: no line has such names, with numbers below")
    _, line_number, names = best
    matched = {match[0].name for name in names if (match := _role_of(split_header(name)[0], roles))}
    missing = [role.name for role in required if role.name not in matched]
    if either and not matched & {role.name for role in either}:
        missing.append(" or ".join(role.name for role in either))
    for name in names:  # the unit may be what is wrong
        match = _role_of(bare_name(name), roles)
        if match and match[0].name in " ".join(missing):
            return TableFault(
                f"column {quoted(name)}: its unit is not known; write one of {match[0].name}, such as "
                f"[{_usual(match[0].units[0])}]",
                line_number,
            )
    listed = ", ".join(map(quoted, names[:LISTED_COUNT])) + (", ..." if len(names) > LISTED_COUNT else "")
    hint = did_you_mean(missing[0], [bare_name(name) for name in names]) if missing else ""
    return TableFault(f"no column {', '.join(missing)} among {listed}{hint}; needed are {needed}", line_number)
