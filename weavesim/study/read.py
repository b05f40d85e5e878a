"""Read a study file, or make one of options; a mistake is told with file, line, table and value."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..checks import Parameters
from ..documents import Document, read_document
from ..errors import InputError, did_you_mean
from ..input_files import shown, within_folder
from .factors import Factor, factor_of, parsed_vary
from .schema import MeasureTable, NoiseTable, StudyTable, VaryTable

SEVERAL: dict[str, type[Parameters]] = {"vary": VaryTable, "scatter": VaryTable, "measure": MeasureTable}


@dataclass(frozen=True)
class Study:
    """A study as read.

    Attributes:
        table: what its file says.
        factors: its parameters, those that nobody controls at the end.
        job: path of the job file.
        places: of each factor for messages, such as "study.toml, line 4, [[vary]] tools.ring.force: ".
    """

    table: StudyTable
    factors: tuple[Factor, ...]
    job: Path
    places: tuple[str, ...]

    def with_si_units(self, unit_of: Callable[[str], str]) -> Study:
        """The same, whose numbers without a unit have that of the job's key."""
        return replace(self, factors=tuple(factor.with_si_unit(unit_of) for factor in self.factors))

    @property
    def controlled(self) -> tuple[Factor, ...]:
        """Those that somebody chooses."""
        return tuple(factor for factor in self.factors if not factor.scattered)

    @property
    def uncontrolled(self) -> tuple[Factor, ...]:
        """Those that nobody chooses."""
        return tuple(factor for factor in self.factors if factor.scattered)


def read_study(path: str | Path) -> Study:
    """Read a study file, TOML or JSON.

    Raises:
        InputError: a file that cannot be read; a table, a key or a value that is not allowed.
    """
    document = read_document(path, "study")
    values = dict(document.values)
    for key in values:
        if key not in StudyTable.model_fields:
            raise InputError(f"{_where(document, key)}unknown name{did_you_mean(key, StudyTable.model_fields)}")
    places: list[str] = []
    factors: list[Factor] = []
    for key, kind in SEVERAL.items():
        entries = values.get(key, [])
        if not isinstance(entries, list):
            raise InputError(f"{_where(document, key)}write [[{key}]], since there may be several")
        tables = [_checked(document, kind, key, index, entry) for index, entry in enumerate(entries)]
        values[key] = tuple(tables)
        for index, table in enumerate(tables):
            if isinstance(table, VaryTable):
                places.append(_place(document, key, index, entries[index]))
                factors.append(_factor(table, places[-1], scattered=key == "scatter"))
    if isinstance(values.get("noise"), Mapping):
        values["noise"] = _checked(document, NoiseTable, "noise", None, values["noise"])
    try:
        table = StudyTable(**{key: _tuples(value) for key, value in values.items()})
    except InputError as error:
        raise InputError(f"study {shown(document.path)}: {str(error).removeprefix('StudyTable: ')}") from None
    _check_names(factors, places)
    job = within_folder(document.path.parent, table.job, f"study {shown(document.path)}, job")
    if not job.exists():
        raise InputError(f"{_where(document, 'job')}job = {table.job!r}: there is no such file in the study's folder")
    return Study(table, tuple(factors), job, tuple(places))


def study_of_options(
    job: Path, vary: Iterable[str], measure: Iterable[str], least: Iterable[str] = (), most: Iterable[str] = (),
    **given: Any,
) -> Study:  # fmt: skip
    """The study of a job and options: --vary, --measure, --least, --most, and fields of ``StudyTable``.

    Raises:
        InputError: options that are not allowed.
    """
    tables = tuple(parsed_vary(text) for text in vary)
    places = [f"--vary {shown(text)}: " for text in vary]
    factors = [_factor(table, place) for table, place in zip(tables, places, strict=True)]
    measures = [
        *(MeasureTable(name=name) for name in measure),
        *(MeasureTable(name=name, goal="least") for name in least),
        *(MeasureTable(name=name, goal="most") for name in most),
    ]
    _check_names(factors, places)
    try:
        table = StudyTable(name=job.stem, job=job.name, vary=tables, measure=tuple(measures), **given)
    except InputError as error:
        text = str(error).removeprefix("StudyTable: ")
        raise InputError(text.replace("[[vary]]", "--vary").replace("[[measure]]", "--measure")) from None
    return Study(table, tuple(factors), job, tuple(places))


def _factor(table: VaryTable, place: str, *, scattered: bool = False) -> Factor:
    try:
        return factor_of(table, scattered=scattered)
    except InputError as error:
        raise InputError(f"{place}{error}") from None


def _check_names(factors: list[Factor], places: list[str]) -> None:
    for index, (factor, place) in enumerate(zip(factors, places, strict=True)):
        for other in factors[:index]:
            if factor.name == other.name:
                raise InputError(f"{place}another parameter has this name; give each its own name")
            if both := set(factor.keys) & set(other.keys):
                raise InputError(f"{place}{min(both)} is varied by {other.name} already")


def _checked(document: Document, kind: type[Parameters], key: str, index: int | None, entry: Any) -> Any:
    place = _place(document, key, index, entry)
    if not isinstance(entry, Mapping):
        raise InputError(f"{place}a table is needed")
    for name in entry:
        if not str(name).isidentifier():
            raise InputError(f"{place}{name!r}: unknown name{did_you_mean(str(name), kind.model_fields)}")
    try:
        return kind(**{name: _tuples(value) for name, value in entry.items()})
    except InputError as error:
        raise InputError(f"{place}{str(error).removeprefix(f'{kind.__name__}: ')}") from None


def _place(document: Document, key: str, index: int | None, entry: Any) -> str:
    line = document.line_of([key]) if index is None else _line_of(document, key, index)
    name = entry.get("key", entry.get("name", "")) if isinstance(entry, Mapping) else ""
    table = f"[{key}]" if index is None else f"[[{key}]]{f' {shown(name)[:60]}' if isinstance(name, str) else ''}"
    return f"study {shown(document.path)}{f', line {line}' if line else ''}, {table.strip()}: "


def _line_of(document: Document, key: str, index: int) -> int:
    if document.path.suffix.lower() != ".toml":
        return 0
    heads = [
        number
        for number, line in enumerate(document.text.split("\n"), start=1)
        if re.match(rf"\s*\[\[\s*{key}\s*\]\]", line[:200])
    ]
    return heads[index] if index < len(heads) else document.line_of([key])


def _where(document: Document, key: str) -> str:
    line = document.line_of([key])
    return f"study {shown(document.path)}{f', line {line}' if line else ''}, {shown(key)}: "


def _tuples(value: Any) -> Any:
    return tuple(_tuples(item) for item in value) if isinstance(value, list) else value
