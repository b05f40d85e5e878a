"""TOML and JSON files of parameters: bounded, checked for what no parameter can be, with the line of a key."""

from __future__ import annotations

import datetime
import json
import math
import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .errors import InputError
from .input_files import MEBIBYTE, path_of, read_bounded, shown

LARGEST_DOCUMENT = MEBIBYTE
DEEPEST_NESTING = 12
LONGEST_KEY = 60
# Beyond it a whole number is no number any more for what computes with it.
LARGEST_INTEGER = 2**53


@dataclass(frozen=True)
class Document:
    """Parameters from a file.

    Attributes:
        path: of the file.
        values: its content; texts, numbers, booleans, None, lists and tables of them.
        text: as read.
    """

    path: Path
    values: dict[str, Any]
    text: str

    def line_of(self, keys: Iterable[str]) -> int:
        """Line of a key of a TOML file, given with those of its tables, or of the nearest table above; 0 if unknown."""
        return _line_of(self.text, [str(key) for key in keys]) if self.path.suffix.lower() == ".toml" else 0


def read_document(path: str | Path, what: str) -> Document:
    """Read a TOML file, or JSON under any other suffix than .toml.

    Args:
        path: of the file.
        what: name of such a file in messages, such as "fabric file".

    Raises:
        InputError: a file that is missing, too large, damaged or nested too deeply; a key that occurs twice; a value
            that no parameter can have: a date, a number that is not finite or too large.
    """
    path = path_of(path, what)
    where = f"{what} {shown(path)}"
    content = read_bounded(path, what, LARGEST_DOCUMENT)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(f"{where}, line {line}: not in UTF-8; save it in this encoding") from None
    is_toml = path.suffix.lower() == ".toml"
    if is_toml and (line := _long_key(text)):
        raise InputError(f"{where}, line {line}: more than {LONGEST_KEY} points in a key or a value")
    try:
        values = tomllib.loads(text) if is_toml else parse_json(text)
    except RecursionError:
        raise InputError(f"{where}: nested too deeply") from None
    except ValueError as error:
        reason = "a number of thousands of digits" if "digits" in str(error) else _reason(error, text, path.suffix)
        raise InputError(f"{where}: {reason}") from None
    if not isinstance(values, dict):
        raise InputError(f"{where}: a table of parameters is needed, not {_kind(values)}")
    document = Document(path, values, text)
    for keys, value in _all_values(values):
        if problem := _problem(keys, value):
            line = document.line_of(keys)
            place = f"{where}, line {line}" if line else where
            raise InputError(f"{place}: {dotted(keys)}: {problem}")
    return document


# What people write in TOML that is none, and what to do.
_NO_TOML = (
    (re.compile(r"[=\[,\s][+-]?\.\d"), "a number needs a digit before its point, as in 0.5"),
    (re.compile(r"\d\.(?![\d_])"), "a number needs a digit after its point, as in 1.0"),
    (re.compile(r"=\s*[+-]?\d+,\d"), "write decimals with a point, as in 0.5"),
    (re.compile(r"(?i)=\s*[+-]?\d[\d.]*(?:e[+-]?\d+)?\s*(?!e[+-]?\d)[a-z%°µ]"), "a number stands without its unit"),
    (re.compile(r"=\s*(?:True|False|TRUE|FALSE)\b"), "write true or false"),
    (re.compile(r"=\s*(?!true\b|false\b|nan\b|inf\b)[A-Za-z]"), "a text needs quotation marks"),
    (re.compile(r"^\s*[\w.-]+\s*:"), 'TOML has "name = value"'),
)  # fmt: skip


def _reason(error: ValueError, text: str, suffix: str) -> str:
    """What is wrong in a text that is no TOML, or no JSON, and the likely slip."""
    if isinstance(error, json.JSONDecodeError):
        name = "" if suffix.lower() == ".json" else "; a file whose name does not end in .toml is read as JSON"
        return f"no valid JSON: {shown(error)}{name}"
    if suffix.lower() != ".toml":
        return shown(error)
    hint = ""
    place = re.search(r"at line (\d+)", str(error))
    if text.lstrip().startswith("{"):
        hint = "; it looks like JSON: let its name end in .json"
    elif place:
        line = text.split("\n")[int(place[1]) - 1][:10_000]
        if not str(error).startswith("Cannot"):
            hint = next((f"; {advice}" for pattern, advice in _NO_TOML if pattern.search(line)), "")
        elif match := _KEY.match(line) or _TABLE.match(line):  # it has a value already
            key = dotted(_parts(match["key"]))
            hint = f"; {key} is given twice, leave one of them out"
    return f"no valid TOML: {shown(error)}{hint}"


def dotted(keys: Iterable[object]) -> str:
    """A key in a message: "shear.angle"."""
    return shown(".".join(str(key) for key in keys))[:120]


def parse_json(text: str | bytes) -> Any:
    """What a JSON text says, if it says it once and in finite numbers.

    Raises:
        ValueError: no text, no JSON, a key that occurs twice in one table, NaN or infinity.
        RecursionError: nested too deeply.
    """

    if not isinstance(text, str | bytes):
        raise ValueError(f"a text is needed, not {_kind(text)}")

    def table(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        result: dict[str, Any] = {}
        for key, value in pairs:
            if key in result:
                raise ValueError(f"{key[:40]!r} occurs twice in one table")
            result[key] = value
        return result

    def constant(name: str) -> float:
        raise ValueError(f"{name}: a finite number is needed")

    return json.loads(text, object_pairs_hook=table, parse_constant=constant)


def _long_key(text: str) -> int:
    """Line of a key of too many parts, 0 without one: the time to read one grows with the square of their number."""
    if text.count(".") <= LONGEST_KEY:
        return 0
    for number, line in enumerate(text.split("\n"), start=1):
        if line.count(".") > LONGEST_KEY and any(part.count(".") > LONGEST_KEY for part in re.split(r"[=,{}#]", line)):
            return number
    return 0


def _all_values(values: dict[str, Any]) -> Iterable[tuple[tuple[str, ...], Any]]:
    """All keys and values, without recursion; the keys of an entry in a list are those of the list."""
    waiting: list[tuple[tuple[str, ...], int, Any]] = [((key,), 1, value) for key, value in values.items()]
    while waiting:
        keys, depth, value = waiting.pop()
        yield keys, value if depth <= DEEPEST_NESTING else _TOO_DEEP
        if depth > DEEPEST_NESTING:
            continue
        if isinstance(value, dict):
            waiting += [((*keys, key), depth + 1, item) for key, item in value.items()]
        elif isinstance(value, list):
            waiting += [(keys, depth + 1, item) for item in value]


_TOO_DEEP = object()


def _problem(keys: tuple[str, ...], value: Any) -> str:
    """Why a value can be none of a parameter, "" if it can."""
    if value is _TOO_DEEP:
        return "nested too deeply"
    if not keys[-1].isprintable():
        return "a key may contain printable characters only"
    if isinstance(value, datetime.date | datetime.time):
        return f"{value} is a date or a time; a number or a text is needed"
    if isinstance(value, float) and not math.isfinite(value):
        return f"{value} is given; a finite number is needed"
    if isinstance(value, int) and abs(value) > LARGEST_INTEGER:
        return "the whole number is too large"
    if isinstance(value, str) and not value.replace("\n", "").replace("\t", "").isprintable():
        return "a text may contain printable characters only"
    return ""


def _kind(value: Any) -> str:
    names = {list: "a list", str: "a text", bool: "true or false", int: "a number", float: "a number"}
    return names.get(type(value), "nothing")


_BARE = r"""(?:[A-Za-z0-9_-]+|"[^"\n]*"|'[^'\n]*')"""
_KEY = re.compile(rf"\s*(?P<key>{_BARE}(?:\s*\.\s*{_BARE})*)\s*=")
_TABLE = re.compile(rf"\s*\[\[?\s*(?P<key>{_BARE}(?:\s*\.\s*{_BARE})*)\s*\]\]?\s*(?:#.*)?")


def _line_of(text: str, keys: list[str]) -> int:
    best, length, table = 0, 0, []
    for number, line in enumerate(text.split("\n"), start=1):
        if len(line) > 10_000:
            continue
        if match := _TABLE.fullmatch(line.rstrip("\r")):
            found = table = _parts(match["key"])
        elif match := _KEY.match(line):
            found = table + _parts(match["key"])
        else:
            continue
        if length < len(found) <= len(keys) and found == keys[: len(found)]:
            best, length = number, len(found)
    return best


def _parts(key: str) -> list[str]:
    return [part.strip("\"'") for part in re.findall(_BARE, key)]
