"""Read a job file: every table checked by its own model; a mistake is told with file, line, table, key and value."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from ..checks import Parameters
from ..documents import Document, read_document
from ..errors import InputError, did_you_mean
from ..input_files import shown, within_folder
from ..names import file_name
from ..ranges import ACCEPTING_IN_JOB, question_of, unusual_values
from .overrides import LISTS, overridden
from .schema import (
    GripperTable,
    InterfaceTable,
    Job,
    OutputTable,
    PlyTable,
    PressureTable,
    ProcessTable,
    SolverTable,
    SpringTable,
    StageTable,
    ToolTable,
)
from .tables import table_within, unusual_keys

# Tables of their own, and those of which there may be several.
SINGLE: dict[str, type[Parameters]] = {
    "interface": InterfaceTable, "process": ProcessTable, "solver": SolverTable, "output": OutputTable,
}  # fmt: skip
SEVERAL: dict[str, type[Parameters]] = {
    "ply": PlyTable, "tool": ToolTable, "spring": SpringTable, "gripper": GripperTable, "pressure": PressureTable,
    "stage": StageTable,
}  # fmt: skip


@dataclass(frozen=True)
class JobFile:
    """A job as read.

    Attributes:
        job: its tables.
        path: of the file.
        folders: from which it may read files: its own first.
        values: content with all settings, as given.
        places: settings from the command line, by their keys.
        document: the file.
    """

    job: Job
    path: Path
    folders: tuple[Path, ...]
    values: Mapping[str, Any]
    places: Mapping[tuple[str, ...], str]
    document: Document

    def refuse(self, keys: Iterable[object], problem: object) -> NoReturn:
        """Refuse what stands under some keys.

        Raises:
            InputError: always.
        """
        raise InputError(f"{self.where(keys)}{problem}")

    def where(self, keys: Iterable[object]) -> str:
        """Place of some keys for a message: file and line, or the setting of the command line, and the table."""
        return _where(self.document, self.values, self.places, [str(key) for key in keys])

    def ask(self, keys: Iterable[object], made: Parameters) -> None:
        """Ask about unusual numbers in what was made of some keys, such as a law, unless the job means them.

        Raises:
            InputError: there are some.
        """
        if not self.job.accept_unusual and (found := list(unusual_values(made))):
            self.refuse(keys, question_of(found, ACCEPTING_IN_JOB))

    def file(self, reference: str, keys: Iterable[object]) -> Path:
        """A file that the job names, in its folder or one that the user named.

        Raises:
            InputError: it is not there, or leads out of these folders.
        """
        place = [str(key) for key in keys]
        problem = ""
        for folder in self.folders:
            try:
                path = within_folder(folder, reference, place[-1])
            except InputError as error:
                problem = problem or str(error)
                continue
            if path.exists():
                return path
            problem = f"{place[-1]} = {reference!r}: there is no such file in the folder of the job"
        for folder in self.folders[1:]:
            path = Path(reference)
            if path.is_absolute() and path.resolve().is_relative_to(folder.resolve()) and path.exists():
                return path
        named = "" if len(self.folders) > 1 else ", or name its folder with --files-from"
        self.refuse(place, f"{problem}{named}")


def read_job(path: str | Path, settings: Iterable[str] = (), files_from: Iterable[str | Path] = ()) -> JobFile:
    """Read a job file, TOML or JSON.

    Args:
        path: of the file.
        settings: values given beside it, see ``overrides.py``.
        files_from: folders from which it may read files, besides its own.

    Raises:
        InputError: a file that cannot be read; a table, a key or a value that is not allowed; a number that is not
            usual, unless the job says ``accept_unusual``.
    """
    document = read_document(path, "job")
    values, places = overridden(document.values, settings)
    folders = (document.path.parent, *map(Path, files_from))
    for folder in folders[1:]:
        if not folder.is_dir():
            raise InputError(f"--files-from {shown(folder)}: there is no such folder")

    def checked(cls: type[Parameters], given: Any, keys: list[str]) -> Any:
        if not isinstance(given, Mapping):
            _refuse(document, values, places, keys, "a table is needed")
        for key in given:
            if not str(key).isidentifier():
                _refuse(document, values, places, [*keys, key], f"{key!r}: unknown name")
        inner = {key: _as_tuples(within(cls, key, value, keys)) for key, value in given.items()}
        try:
            return cls(**inner)
        except InputError as error:
            text = str(error).removeprefix(f"{cls.__name__}: ")
            name = re.split(r"[ .:=,]", text, maxsplit=1)[0]
            _refuse(document, values, places, [*keys, name] if name in given else keys, text)

    def within(cls: type[Parameters], key: str, value: Any, keys: list[str]) -> Any:
        """Tables in a table, each checked by its own model; anything else as it is."""
        inner = table_within(cls.model_fields[key]) if keys and key in cls.model_fields else None
        if inner is None:
            return value
        if "tuple" not in str(cls.model_fields[key].annotation):
            return checked(inner, value, [*keys, key])
        if not isinstance(value, list):
            name = keys[0]
            _refuse(document, values, places, [*keys, key], f"write [[{name}.{key}]], since there may be several")
        return [checked(inner, entry, [*keys, key, str(index)]) for index, entry in enumerate(value)]

    rest: dict[str, Any] = {}
    for key, value in values.items():
        if key not in Job.model_fields:
            singular = "tool" if key == "tools" else "ply" if key == "plies" else None
            near = f"; write [[{singular}]]" if singular else did_you_mean(key, Job.model_fields)
            _refuse(document, values, places, [key], f"{key}: unknown name{near}")
        if key in SEVERAL:
            if not isinstance(value, list):
                _refuse(document, values, places, [key], f"write [[{key}]], since there may be several")
            rest[key] = tuple(checked(SEVERAL[key], entry, [key, str(index)]) for index, entry in enumerate(value))
        elif key in SINGLE:
            rest[key] = checked(SINGLE[key], value, [key])
        else:
            rest[key] = value
    if "name" not in rest:
        rest["name"] = file_name("job", document.path.stem)
    result = JobFile(checked(Job, rest, []), document.path, folders, values, places, document)
    _check_whole(result)
    found = [f"{result.where(keys)}{sentence}" for keys, sentence in unusual_keys(result.job)]
    if found and not result.job.accept_unusual:
        raise InputError(question_of(found, ACCEPTING_IN_JOB))
    return result


def _check_whole(file: JobFile) -> None:
    """What no table can see alone."""
    job = file.job
    if job.scene is not None:
        for key in (*SEVERAL, "process", "interface", "fabric"):
            if key in file.values:
                file.refuse([key], f"[scene] brings its own; leave [{key}] out, or [scene]")
        return
    if not job.ply:
        file.refuse([], "[[ply]]: at least one is needed, or a [scene]")
    for kind in LISTS:
        names = [entry.name for entry in getattr(job, kind) if hasattr(entry, "name")]
        for index, name in enumerate(names):
            if name in names[:index]:
                file.refuse(
                    [kind, index, "name"],
                    f"name = {name!r}: another [[{kind}]] has it; results tell them apart by it, give each its own",
                )
    for key in ("duration", "hold"):
        if job.stage and key in job.process.model_fields_set and getattr(job.process, key) is not None:
            file.refuse(
                ["process", key], f"{key}: has no effect with [[stage]], each of which has its own; leave it out"
            )
    if (
        "interface" in file.values
        and len(job.ply) < 2
        and all(ply.layup is None and not ply.self_contact for ply in job.ply)
    ):
        file.refuse(["interface"], "has no effect with a single ply that does not touch itself; leave it out")
    names = [tool.name for tool in job.tool]
    for index, tool in enumerate(job.tool):
        for key in ("offset_of", "ring_of"):
            other = getattr(tool, key)
            if other is None:
                continue
            others = [name for name in names if name != tool.name]
            if other not in others:
                file.refuse(
                    ["tool", index, key],
                    f"{key} = {other!r}: there is no such [[tool]]{did_you_mean(other, others)}; "
                    f"there are {', '.join(others) or 'no others'}",
                )
            if job.tool[names.index(other)].file is None:
                file.refuse(["tool", index, key], f"{key} = {other!r}: that tool needs a file as its surface")


def _as_tuples(value: Any) -> Any:
    return tuple(_as_tuples(item) for item in value) if isinstance(value, list) else value


def _refuse(
    document: Document, values: Mapping[str, Any], places: Mapping[tuple[str, ...], str], keys: list[str], problem: str
) -> NoReturn:
    raise InputError(f"{_where(document, values, places, keys)}{problem}")


def _where(
    document: Document, values: Mapping[str, Any], places: Mapping[tuple[str, ...], str], keys: list[str]
) -> str:
    """ "job tray.toml, line 12, [[tool]] ring: "."""
    setting = places.get(tuple(keys))
    line = _line_of(document, keys)
    place = setting or f"job {shown(document.path)}" + (f", line {line}" if line else "")
    table = _table(values, keys)
    return f"{place}, {table}: " if table else f"{place}: "


def _table(values: Mapping[str, Any], keys: list[str]) -> str:
    """The table that some keys are in, as it stands in the file, with the name of an entry."""
    if not keys:
        return ""
    if keys[0] in LISTS:
        entries = values.get(keys[0])
        entry = entries[int(keys[1])] if len(keys) > 1 and isinstance(entries, list) else None
        text = _named(keys[0], entry)
        if len(keys) > 3 and isinstance(entry, dict):  # a table in a table
            inner = entry.get(keys[2])
            if isinstance(inner, list) and keys[3].isdecimal() and int(keys[3]) < len(inner):
                text += f", {_named(f'{keys[0]}.{keys[2]}', inner[int(keys[3])])}"
            elif isinstance(inner, dict):
                text += f", {keys[2]}"
        return text
    if keys[0] in SINGLE or keys[0] in ("scene", "fabric"):
        return f"[{shown('.'.join(keys[:2] if keys[0] == 'fabric' else keys[:1]))}]"
    return ""


def _named(title: str, entry: Any) -> str:
    name = entry.get("name") if isinstance(entry, dict) else None
    return f"[[{title}]] {shown(name)[:60]}" if isinstance(name, str) else f"[[{title}]]"


def _line_of(document: Document, keys: list[str]) -> int:
    """Line of some keys in a TOML file; of an entry of a list, that of its own table; 0 if unknown."""
    if not keys or keys[0] not in LISTS or len(keys) < 2:
        return document.line_of(keys)
    lines = [line[:200] for line in document.text.split("\n")]
    heads = [k for k, line in enumerate(lines) if re.match(rf"\s*\[\[\s*{keys[0]}\s*\]\]", line)]
    if document.path.suffix.lower() != ".toml" or int(keys[1]) >= len(heads):
        return 0
    place, prefix, rest = heads[int(keys[1])], keys[0], keys[2:]
    end = next((k for k in heads if k > place), len(lines))
    while rest:
        key, *rest = rest
        prefix = rf"{prefix}\s*\.\s*{re.escape(key)}"
        inner = [k for k in range(place + 1, end) if re.match(rf"\s*\[\[?\s*{prefix}\s*\]", lines[k])]
        which = int(rest[0]) if rest and rest[0].isdecimal() else 0
        if which < len(inner):
            place, end = inner[which], ([*inner, end])[which + 1]
            rest = rest[1:] if rest and rest[0].isdecimal() else rest
            continue
        for k in range(place + 1, end):
            if re.match(r"\s*\[", lines[k]):
                break
            if re.match(rf"\s*{re.escape(key)}\s*=", lines[k]):
                return k + 1
        break
    return place + 1
