"""Values given beside a job file: ``--set tools.ring.force=600``."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from copy import deepcopy
from typing import Any

from ..errors import InputError, did_you_mean
from ..input_files import shown

# Tables of which there may be several, each with a name; their plural will do.
LISTS = ("ply", "tool", "spring", "gripper", "pressure", "stage")
PLURALS = {
    "plies": "ply", "tools": "tool", "fabrics": "fabric", "springs": "spring", "grippers": "gripper",
    "stages": "stage",
}  # fmt: skip
FORM = "give --set TABLE.NAME.KEY=VALUE, such as --set tools.ring.force=600, or --set process.hold=5ms"


def overridden(values: Mapping[str, Any], settings: Iterable[str]) -> tuple[dict[str, Any], dict[tuple[str, ...], str]]:
    """The content of a job with ``settings``, and the setting of each key that one of them gives.

    The keys are those of the content, with the place of an entry in a list as text: ("tool", "1", "force").

    Raises:
        InputError: a setting that has no value, or names a table or an entry that is not there.
    """
    result: dict[str, Any] = deepcopy(dict(values))
    places: dict[tuple[str, ...], str] = {}
    for setting in settings:
        name, equals, text = setting.partition("=")
        parts = [part.strip() for part in name.split(".")]
        if not equals or not all(parts) or not text.strip():
            raise InputError(f"--set {shown(setting)}: {FORM}")
        parts[0] = PLURALS.get(parts[0], parts[0])
        keys = _keys(result, parts, setting)
        _put(result, keys, _value(text), setting)
        places[tuple(keys)] = f"--set {shown(setting)}"
    return result, places


def _keys(values: Mapping[str, Any], parts: list[str], setting: str) -> list[str]:
    """``parts`` with the name of an entry in a list replaced by its place."""
    if parts[0] not in LISTS or len(parts) == 1:
        return parts
    entries = values.get(parts[0])
    if not isinstance(entries, list) or not entries:
        raise InputError(f"--set {shown(setting)}: the job has no [[{parts[0]}]]")
    if len(parts) == 2 and len(entries) == 1:  # the only one needs no name
        return [parts[0], "0", parts[1]]
    names = [str(entry.get("name", parts[0])) if isinstance(entry, dict) else "" for entry in entries]
    if len(parts) == 2:
        raise InputError(
            f"--set {shown(setting)}: there are several [[{parts[0]}]]; name one of {', '.join(names)}: {FORM}"
        )
    if parts[1] not in names:
        raise InputError(
            f"--set {shown(setting)}: no [[{parts[0]}]] is named {parts[1]!r}; there are {', '.join(names)}"
            f"{did_you_mean(parts[1], names)}"
        )
    index = names.index(parts[1])
    return [parts[0], str(index), *_below(entries[index], parts[2:])]


def _below(entry: Any, parts: list[str]) -> list[str]:
    """``parts`` below an entry: those of a list of tables in it are named by their names, or their places, too."""
    inner = entry.get(parts[0]) if isinstance(entry, dict) and parts else None
    if not isinstance(inner, list) or len(parts) < 3:
        return parts
    names = [str(each.get("name", "")) if isinstance(each, dict) else "" for each in inner]
    return [parts[0], str(names.index(parts[1])) if parts[1] in names else parts[1], *parts[2:]]


def _put(values: dict[str, Any], keys: list[str], value: Any, setting: str) -> None:
    place: Any = values
    for key in keys[:-1]:
        if isinstance(place, list) and not (key.isdecimal() and int(key) < len(place)):
            raise InputError(f"--set {shown(setting)}: there is no {key!r}: {FORM}")
        place = place[int(key)] if isinstance(place, list) else place.setdefault(key, {})
        if not isinstance(place, dict | list):
            raise InputError(f"--set {shown(setting)}: {key} is a value, no table")
    if isinstance(place, list):
        raise InputError(f"--set {shown(setting)}: {FORM}")
    place[keys[-1]] = value


def _value(text: str) -> Any:
    """What TOML says to ``text``, or the text itself: quotation marks are for shells."""
    try:
        return tomllib.loads(f"value = {text.strip()}")["value"]
    except (tomllib.TOMLDecodeError, RecursionError):
        return text.strip()
