"""Fabrics from a file: TOML or JSON, with the parameters' own names, and columns of test data read from CSV."""

from __future__ import annotations

import csv
import json
import math
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..checks import Parameters
from ..errors import InputError
from ..ranges import check_usual
from .fabric import Fabric
from .families import constructors, implied_kind, kinds_of_field, kinds_within
from .presets import PRESETS

FABRIC_HELP = f"one of {', '.join(PRESETS)}, or a .toml or .json file"
# Exceptions that a constructor may raise for bad values.
_MISTAKES = (TypeError, ValueError, ArithmeticError)


def resolve_fabric(name_or_path: str, *, accept_unusual: bool = False) -> Fabric:
    """A preset by name, or the fabric of a .toml or .json file, see ``load_fabric``.

    Raises:
        InputError: no such preset or file, or a file with mistakes.
    """
    if name_or_path in PRESETS:
        return PRESETS[name_or_path]()
    if Path(name_or_path).suffix.lower() in (".toml", ".json"):
        return load_fabric(name_or_path, accept_unusual=accept_unusual)
    raise InputError(
        f"fabric {name_or_path!r} is unknown: choose one of {', '.join(PRESETS)}, or give a .toml or .json file"
    )


def load_fabric(path: str | Path, *, accept_unusual: bool = False) -> Fabric:
    """Read a fabric from a TOML or JSON file.

    Keys are the names of the parameters of ``Fabric``, in SI units, as ``Fabric.to_json`` writes them; ``based_on``
    names a preset that supplies all values that the file does not give. A table chooses its law by ``kind``, such as
    "TwillWeave", or "MomentCurve.from_picture_frame" to call a constructor; tables may be nested. In place of a
    list of numbers, ``{csv = "test.csv", column = "force", scale = 1000.0}`` reads a column of a CSV file with a
    header, relative to the fabric's file, and multiplies it by the scale (default 1).

    ``accept_unusual`` takes values outside their plausible range as meant (docs/fabrics.md).

    Raises:
        InputError: a file that is missing or unreadable, an unknown kind, or values that are not allowed or unusual.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
        values = tomllib.loads(text) if path.suffix.lower() == ".toml" else json.loads(text)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"fabric file {path}: cannot be read ({error})") from None
    except (tomllib.TOMLDecodeError, json.JSONDecodeError) as error:
        raise InputError(f"fabric file {path}: {error}") from None
    if not isinstance(values, dict):
        raise InputError(f"fabric file {path}: a table of parameters is needed, not {type(values).__name__}")
    based_on = values.pop("based_on", None)
    if based_on is not None and based_on not in PRESETS:
        raise InputError(f"fabric file {path}: based_on = {based_on!r}: one of {', '.join(PRESETS)} is needed")
    try:
        values = {name: _converted(value, name, Fabric, path.parent) for name, value in values.items()}
        values.setdefault("name", path.stem)
        if based_on is None:
            fabric = Fabric(**values)
        else:
            values.setdefault("source", f"{path.name}, based on the preset {based_on}")
            fabric = PRESETS[based_on]().model_copy(update=values)
        if not accept_unusual:
            check_usual(fabric)
        return fabric
    except (InputError, *_MISTAKES) as error:
        raise InputError(f"fabric file {path}: {error}") from None


def _converted(value: Any, name: str, owner: type[Parameters] | None, folder: Path) -> Any:
    """Convert tables to parameters or columns, lists to tuples; ``name`` is a field of ``owner``, if that is known."""
    if isinstance(value, list):
        return tuple(_converted(item, name, owner, folder) for item in value)
    if not isinstance(value, dict):
        return value
    if "csv" in value:
        return _column(value, name, folder)
    # arguments of constructors accept any kind
    field_of = owner if owner is not None and name in owner.model_fields else None
    allowed = kinds_of_field(field_of, name) if field_of else kinds_within(Fabric)
    if not allowed:
        raise InputError(f"{name}: a value is needed, not a table")
    given = value.get("kind", implied_kind(field_of, name) if field_of else None)
    if given is None:
        raise InputError(f"[{name}] has no kind; one of {', '.join(allowed)} is needed")
    kind, _, constructor = str(given).partition(".")
    if kind not in allowed:
        raise InputError(f"[{name}] kind = {given!r}: one of {', '.join(allowed)} is needed")
    make: Callable[..., Parameters] = allowed[kind]
    if constructor:
        known = constructors(allowed[kind])
        if constructor not in known:
            raise InputError(f"[{name}] kind = {given!r}: {kind} has the constructors {', '.join(known) or 'none'}")
        make = known[constructor]
    values = {key: _converted(item, key, allowed[kind], folder) for key, item in value.items() if key != "kind"}
    try:
        return make(**values)
    except (InputError, *_MISTAKES) as error:
        text = str(error).removeprefix(f"{kind}: ")
        raise InputError(f"[{name}] {given}: {text}") from None


def _column(value: dict[str, Any], name: str, folder: Path) -> tuple[float, ...]:
    unknown = set(value) - {"csv", "column", "scale"}
    if unknown or "column" not in value:
        raise InputError(f"{name}: a CSV column needs csv and column, optionally scale; got {sorted(value)}")
    path = folder / str(value["csv"])
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{name}: {path} cannot be read ({error})") from None
    if not rows or value["column"] not in rows[0]:
        raise InputError(f"{name}: {path} has the columns {sorted(rows[0]) if rows else []}, not {value['column']!r}")
    scale = value.get("scale", 1.0)
    if isinstance(scale, bool) or not isinstance(scale, int | float) or not math.isfinite(scale):
        raise InputError(f"{name}: scale = {scale!r}: a finite number is needed")
    result = []
    for line, row in enumerate(rows, start=2):
        try:
            result.append(scale * float(row[value["column"]]))
        except (TypeError, ValueError):
            raise InputError(
                f"{name}: {path}, line {line}: {row[value['column']]!r} is not a number (use a point, not a comma)"
            ) from None
    return tuple(result)
