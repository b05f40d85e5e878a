"""The registry of laws: the kinds that each field of a fabric accepts, and their constructors.

A law is a kind of a family (``checks.Kinded``), registered when its class is defined. Fabric files, presets, the tables
of the documentation and the tests read the registry, so that a new law needs only its own file.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterable, Iterator
from typing import Any, get_args

from ..checks import Kinded, Parameters


def define_kinds(package: str, path: Iterable[str]) -> None:
    """Register the kinds of a package, given by its ``__name__`` and ``__path__``, by importing all its modules."""
    for module in pkgutil.iter_modules(path):
        importlib.import_module(f"{package}.{module.name}")


def kinds_of_field(owner: type[Parameters], field: str) -> dict[str, type[Parameters]]:
    """The kinds that a table for this field may have, by name; empty if the field does not accept a table."""
    result: dict[str, type[Parameters]] = {}
    for part in _classes(owner.model_fields[field].annotation):
        result |= part.kinds() if issubclass(part, Kinded) else {part.__name__: part}
    return result


def implied_kind(owner: type[Parameters], field: str) -> str | None:
    """The kind of a table for this field that does not give one."""
    for part in _classes(owner.model_fields[field].annotation):
        return part.implied_kind if issubclass(part, Kinded) else part.__name__
    return None


def kinds_within(owner: type[Parameters]) -> dict[str, type[Parameters]]:
    """All kinds that ``owner`` may contain, in the order of its fields, nested ones after their owners."""
    result: dict[str, type[Parameters]] = {}
    waiting = [owner]
    while waiting:
        parent = waiting.pop(0)
        for field in parent.model_fields:
            new = {name: kind for name, kind in kinds_of_field(parent, field).items() if name not in result}
            result |= new
            waiting += new.values()
    return result


def constructors(kind: type[Parameters]) -> dict[str, Callable[..., Parameters]]:
    """Class methods that construct a value of this kind, by name."""
    family = next((base for base in kind.__mro__ if Kinded in base.__bases__), Parameters)
    names = {name for base in kind.__mro__ for name, item in vars(base).items() if isinstance(item, classmethod)}
    general = {name for base in family.__mro__ for name in vars(base)}
    return {name: getattr(kind, name) for name in sorted(names - general) if not name.startswith("_")}


def _classes(annotation: Any) -> Iterator[type[Parameters]]:
    """The ``Parameters`` classes in a field's type."""
    if isinstance(annotation, type) and issubclass(annotation, Parameters):
        yield annotation
    for part in get_args(annotation):
        yield from _classes(part)
