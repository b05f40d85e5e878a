"""Fabrics from a file: TOML or JSON, with the parameters' own names, and columns of test data read from tables."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

from ..checks import Parameters
from ..documents import Document, dotted, read_document
from ..errors import InputError, did_you_mean
from ..input_files import path_of, shown
from ..ranges import check_usual
from .columns import ColumnReader, is_reference, unit_of
from .construction import MISTAKES, chosen, constructed, without_python
from .fabric import Fabric
from .families import implied_kind, kinds_of_field, kinds_within
from .presets import PRESETS
from .presets.folder import SUFFIXES, check_no_shadow, fabric_folder, kept_file, kept_files
from .provenance import Origin, still_true, without

logger = logging.getLogger(__name__)

FABRIC_HELP = f"one of {', '.join(PRESETS)}, the name of a file in your own folder, or a .toml or .json file"
LONGEST_NAME = 100


def resolve_fabric(name_or_path: str, *, accept_unusual: bool = False) -> Fabric:
    """A preset or a file in the user's folder of fabrics by name, or the fabric of a file, see ``load_fabric``.

    Raises:
        InputError: no such preset or file, one name for both, or a file with mistakes.
    """
    if not isinstance(name_or_path, str):
        name_or_path = str(path_of(name_or_path, "fabric"))
    if name_or_path not in PRESETS and Path(name_or_path).suffix.lower() in SUFFIXES:
        return load_fabric(name_or_path, accept_unusual=accept_unusual)
    return _named(name_or_path, f"fabric {name_or_path!r} is unknown", accept_unusual, ())


def _named(name: str, unknown: str, accept_unusual: bool, readers: tuple[Path, ...]) -> Fabric:
    """A preset, or a file in the user's folder.

    Args:
        unknown: what to say if there is none of this name.
        readers: files that are being read, each based on the next.
    """
    if name in PRESETS:
        check_no_shadow(name)
        return PRESETS[name]()
    file = kept_file(name)
    if file is not None:
        return _load(file, accept_unusual, readers)
    known = [*PRESETS, *kept_files()]
    or_else = "" if readers else ", or give a .toml or .json file"
    raise InputError(
        f"{unknown}: choose one of {', '.join(known)}{or_else}{did_you_mean(name, known)}; your own folder of fabrics "
        f"is {shown(fabric_folder())}"
    )


def load_fabric(path: str | Path, *, accept_unusual: bool = False) -> Fabric:
    """Read a fabric from a TOML or JSON file.

    Keys are the names of the parameters of ``Fabric``, in SI units, as ``Fabric.to_json`` writes them; ``based_on``
    names a preset, or a file in the user's folder of fabrics, that supplies all values that the file does not give. A
    table chooses its law by ``kind``, such as "TwillWeave", or "MomentCurve.from_picture_frame" to call a constructor;
    tables may be nested. In place of a list of numbers, ``{csv = "test.csv", column = "force"}`` reads a column of a
    table in the folder of the file or below it, converted from the unit in its header; ``scale = 1000.0`` multiplies
    the numbers instead.

    ``accept_unusual`` takes values outside their plausible range as meant (docs/fabrics.md).

    Raises:
        InputError: a file that is missing or unreadable, an unknown kind, or values that are not allowed or
            unusual; with the key, and its line where that is known.
    """
    if isinstance(path, str) and path in PRESETS and not Path(path).exists():
        raise InputError(f"fabric file {path}: this is a preset, no file; take weavesim.resolve_fabric({path!r})")
    return _load(path, accept_unusual, ())


def _load(path: str | Path, accept_unusual: bool, readers: tuple[Path, ...]) -> Fabric:
    document = read_document(path, "fabric file")
    reader = _Reader(document, readers)
    try:
        fabric = reader.fabric(accept_unusual)
    except _Mistake as mistake:
        line = document.line_of(mistake.keys)
        place = f", line {line}" if line else ""
        raise InputError(f"fabric file {shown(path)}{place}: {mistake}") from None
    for note in reader.columns.notes:
        logger.info("fabric file %s: %s", shown(path), note)
    return fabric


def fabric_of_table(
    document: Document, values: dict[str, Any], keys: tuple[str, ...], *, accept_unusual: bool = False
) -> Fabric:
    """The fabric that a table within another document describes, as a fabric file does.

    Args:
        document: that contains it.
        values: of the table.
        keys: of the table in the document.
        accept_unusual: take unusual values as meant.

    Raises:
        InputError: see ``load_fabric``.
    """
    reader = _Reader(Document(document.path, values, document.text), ())
    try:
        return reader.fabric(accept_unusual)
    except _Mistake as mistake:
        line = document.line_of((*keys, *mistake.keys))
        place = f", line {line}" if line else ""
        text = str(mistake).removeprefix("Fabric: ")
        raise InputError(f"job {shown(document.path)}{place}, [{dotted(keys)}]: {text}") from None


class _Mistake(ValueError):
    """What is wrong, and the keys of the place."""

    def __init__(self, keys: tuple[str, ...], message: str) -> None:
        super().__init__(message)
        self.keys = keys


class _Reader:
    """Makes the fabric of a document."""

    def __init__(self, document: Document, readers: tuple[Path, ...]) -> None:
        self.path, self._values = document.path, document.values
        self._readers = (*readers, document.path.resolve())
        self.columns = ColumnReader(document.path.parent)

    def fabric(self, accept_unusual: bool) -> Fabric:
        base = self._base(accept_unusual)
        values = {
            name: self._converted(value, (name,), Fabric) for name, value in self._values.items() if name != "based_on"
        }
        if isinstance(values.get("provenance"), Origin):  # [provenance], of a single one
            values["provenance"] = (values["provenance"],)
        values.setdefault("name", shown(self.path.stem).strip()[:LONGEST_NAME] or "fabric")
        if base is not None:
            kind = "preset" if self._values["based_on"] in PRESETS else "fabric"
            values.setdefault("source", f"{shown(self.path.name)}, based on the {kind} {self._values['based_on']}")
        if self.columns.notes and isinstance(values.get("source", ""), str):
            values["source"] = "; ".join([*filter(None, [values.get("source")]), *self.columns.notes])
        try:
            fabric = Fabric(**values) if base is None else _changed(base, values)
            if not accept_unusual:
                check_usual(fabric)
            return fabric
        except MISTAKES as error:
            text = str(error) if isinstance(error, ValueError) else without_python(error)
            raise _Mistake(self._wrong_key(values, text), text) from None

    def _base(self, accept_unusual: bool) -> Fabric | None:
        """What ``based_on`` names."""
        if "based_on" not in self._values:
            return None
        name = self._values["based_on"]
        needed = f"based_on = {_short(name)}: a preset, or the name of a file in your own folder of fabrics, is needed"
        if not isinstance(name, str):
            raise _Mistake(("based_on",), f"{needed}; presets are {', '.join(PRESETS)}")
        try:
            if name not in PRESETS and (file := kept_file(name)) and file.resolve() in self._readers:
                chain = " is based on ".join(shown(path.stem) for path in (*self._readers, file))
                raise InputError(f"based_on = {name!r}: {chain}; no fabric can be based on itself")
            return _named(name, needed, accept_unusual, self._readers)
        except InputError as error:
            text = str(error)
            raise _Mistake(("based_on",), text if text.startswith("based_on") else f"based_on: {text}") from None

    def _converted(self, value: Any, keys: tuple[str, ...], owner: type[Parameters] | None) -> Any:
        """Convert tables to parameters or columns, lists to tuples; the last key is a field of ``owner`` if known."""
        if isinstance(value, list):
            return tuple(self._converted(item, keys, owner) for item in value)
        if not isinstance(value, dict):
            return value
        name = keys[-1]
        if is_reference(value):
            try:
                return self.columns.read(value, unit_of(owner, name))
            except InputError as error:
                raise _Mistake(keys, f"{dotted(keys)}: {error}") from None
        # arguments of constructors accept any kind
        field_of = owner if owner is not None and name in owner.model_fields else None
        allowed = kinds_of_field(field_of, name) if field_of else kinds_within(Fabric)
        if owner is Fabric and field_of is None:
            hint = did_you_mean(name, Fabric.model_fields)
            raise _Mistake(keys, f"[{dotted(keys)}] unknown name{hint or '; a fabric has no such table'}")
        if not allowed:
            raise _Mistake(keys, f"{dotted(keys)}: a value is needed, not a table")
        given = value.get("kind", implied_kind(field_of, name) if field_of else None)
        if given is None:
            raise _Mistake(keys, f"[{dotted(keys)}] has no kind; one of {', '.join(allowed)} is needed")
        try:
            kind, make = chosen(given, allowed)
        except InputError as error:
            raise _Mistake(keys, f"[{dotted(keys)}] {error}") from None
        values = {key: self._converted(item, (*keys, key), kind) for key, item in value.items() if key != "kind"}
        try:
            return constructed(kind, make, values)
        except InputError as error:
            raise _Mistake(self._wrong_key(values, str(error), keys), f"[{dotted(keys)}] {given}: {error}") from None

    @staticmethod
    def _wrong_key(values: dict[str, Any], message: str, table: tuple[str, ...] = ()) -> tuple[str, ...]:
        """The key that a message begins with, behind the name of a class; that of the table if it does not."""
        name = message.removeprefix("Fabric: ").split(" ")[0].rstrip(":")
        return (*table, name) if name in values else table


def _changed(base: Fabric, values: dict[str, Any]) -> Fabric:
    """``base`` with the values of a file, which says for itself where these come from."""
    own = values.get("provenance", ())
    if not isinstance(own, tuple) or not all(isinstance(origin, Origin) for origin in own):
        return base.model_copy(update=values)  # refused there
    said = [name for origin in own for name in origin.of]
    inherited = without(base.provenance, [*values, *said])
    fabric = base.model_copy(update={**values, "provenance": ()})
    still = still_true(base.model_copy(update={"provenance": inherited}), fabric)
    return fabric.model_copy(update={"provenance": (*still, *own)})


def _short(value: Any) -> str:
    text = repr(value) if isinstance(value, str | int | float | bool) else f"a {type(value).__name__}"
    return text[:80]
