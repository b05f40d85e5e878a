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
from .bending import BendingCurve, IsotropicBending, YarnBending
from .compaction import Compaction
from .fabric import Fabric, Stabilisation
from .membrane import LinearMembrane
from .presets import PRESETS
from .shear import LinearShear, MomentCurve, ShearFriction
from .tape import UnidirectionalTape
from .weaves import PlainWeave, SatinWeave, TwillWeave

FABRIC_HELP = f"one of {', '.join(PRESETS)}, or a .toml or .json file"
# What a table of the file may be, by the name in its ``kind``; "Kind.constructor" calls a class method.
KINDS: dict[str, type[Parameters]] = {
    kind.__name__: kind
    for kind in (
        PlainWeave, TwillWeave, SatinWeave, UnidirectionalTape, LinearMembrane, LinearShear, MomentCurve, ShearFriction,
        IsotropicBending, YarnBending, BendingCurve, Compaction, Stabilisation,
    )
}  # fmt: skip
# A table of these names needs no ``kind``.
IMPLIED = {"shear_friction": "ShearFriction", "compaction": "Compaction", "stabilisation": "Stabilisation"}
# What a constructor may raise on values that it cannot take.
_MISTAKES = (TypeError, ValueError, ArithmeticError)


def resolve_fabric(name_or_path: str) -> Fabric:
    """A preset by its name, or the fabric of a file ending in .toml or .json.

    Raises:
        InputError: no such preset or file, or a file with mistakes.
    """
    if name_or_path in PRESETS:
        return PRESETS[name_or_path]()
    if Path(name_or_path).suffix.lower() in (".toml", ".json"):
        return load_fabric(name_or_path)
    raise InputError(
        f"fabric {name_or_path!r} is unknown: choose one of {', '.join(PRESETS)}, or give a .toml or .json file"
    )


def load_fabric(path: str | Path) -> Fabric:
    """The fabric that a TOML or JSON file describes.

    Keys are the names of the parameters of ``Fabric``, in SI units; ``based_on`` names a preset whose values hold where
    the file is silent. A table chooses its law by ``kind``, such as "TwillWeave", or "MomentCurve.from_picture_frame"
    to call a constructor; tables may be within tables. In place of a list of numbers, ``{csv = "test.csv",
    column = "force", scale = 1000.0}`` takes a column of a CSV file with a header, beside the fabric's file, times the
    scale (by default 1).

    Raises:
        InputError: a file that is missing or unreadable, an unknown kind, or values that are not allowed.
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
        values = {name: _converted(value, name, path.parent) for name, value in values.items()}
        values.setdefault("name", path.stem)
        if based_on is None:
            return Fabric(**values)
        values.setdefault("source", f"{path.name}, based on the preset {based_on}")
        return PRESETS[based_on]().model_copy(update=values)
    except (InputError, *_MISTAKES) as error:
        raise InputError(f"fabric file {path}: {error}") from None


def _converted(value: Any, name: str, folder: Path) -> Any:
    """Tables as parameters or columns, lists as tuples."""
    if isinstance(value, list):
        return tuple(_converted(item, name, folder) for item in value)
    if not isinstance(value, dict):
        return value
    if "csv" in value:
        return _column(value, name, folder)
    values = {key: _converted(item, key, folder) for key, item in value.items() if key != "kind"}
    kind = value.get("kind", IMPLIED.get(name))
    if kind is None:
        raise InputError(f"[{name}] says no kind; one of {', '.join(KINDS)} is needed")
    kind = str(kind)
    make = _maker(kind, name)
    try:
        return make(**values)
    except (InputError, *_MISTAKES) as error:
        text = str(error).removeprefix(f"{kind.partition('.')[0]}: ")
        raise InputError(f"[{name}] {kind}: {text}") from None


def _maker(kind: str, name: str) -> Callable[..., Parameters]:
    class_name, _, constructor = kind.partition(".")
    if class_name not in KINDS:
        raise InputError(f"[{name}] kind = {kind!r}: one of {', '.join(KINDS)} is needed")
    cls = KINDS[class_name]
    if not constructor:
        return cls
    own = {key for base in cls.__mro__ for key, item in vars(base).items() if isinstance(item, classmethod)}
    allowed = sorted(own - {key for base in Parameters.__mro__ for key in vars(base)})
    if constructor not in allowed:
        raise InputError(f"[{name}] kind = {kind!r}: {class_name} has the constructors {', '.join(allowed) or 'none'}")
    return getattr(cls, constructor)


def _column(value: dict[str, Any], name: str, folder: Path) -> tuple[float, ...]:
    unknown = set(value) - {"csv", "column", "scale"}
    if unknown or "column" not in value:
        raise InputError(f"{name}: a CSV column needs csv and column, and may have scale; given are {sorted(value)}")
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
                f"{name}: {path}, line {line}: {row[value['column']]!r} is no number (use a point, not a comma)"
            ) from None
    return tuple(result)
