"""Laws from the values of a file, by a class or one of its constructors, with arguments checked by name and kind."""

from __future__ import annotations

import inspect
import reprlib
import types
import typing
from collections.abc import Callable, Mapping
from typing import Any

from ..checks import Parameters
from ..errors import InputError, did_you_mean
from ..input_files import shown
from .families import constructors

# What computing with absurd values may raise.
MISTAKES = (TypeError, ValueError, ArithmeticError, RecursionError, MemoryError)


def chosen(given: object, allowed: Mapping[str, type[Parameters]]) -> tuple[type[Parameters], Callable[..., Any]]:
    """The class of a ``kind`` such as "MomentCurve.from_picture_frame", and what makes a value of it.

    Raises:
        InputError: no such kind or constructor.
    """
    if not isinstance(given, str):
        raise InputError(f"kind = {reprlib.repr(given)}: one of {', '.join(allowed)} is needed")
    kind, _, constructor = given.partition(".")
    if kind not in allowed:
        hint = did_you_mean(kind, allowed)
        raise InputError(f"kind = {given[:80]!r}: one of {', '.join(allowed)} is needed{hint}")
    if not constructor:
        return allowed[kind], allowed[kind]
    known = constructors(allowed[kind])
    if constructor not in known:
        hint = did_you_mean(constructor, known)
        raise InputError(f"kind = {given[:80]!r}: {kind} has the constructors {', '.join(known) or 'none'}{hint}")
    return allowed[kind], known[constructor]


def constructed(kind: type[Parameters], make: Callable[..., Any], values: Mapping[str, Any]) -> Any:
    """The value that ``make`` returns for these arguments.

    Raises:
        InputError: unknown, missing or bad arguments; the message does not name the kind.
    """
    if make is not kind:
        _check_arguments(kind, make, values)
    try:
        return make(**values)
    except MISTAKES as error:
        text = str(error).removeprefix(f"{kind.__name__}: ")
        raise InputError(text if isinstance(error, ValueError) else without_python(error)) from None


def without_python(error: BaseException) -> str:
    """What to say of an error that no check foresaw."""
    if isinstance(error, ArithmeticError | MemoryError | RecursionError):
        return "numbers that are too large, too small or too many to compute with"
    return "a value of a wrong kind: compare numbers, lists, texts and tables with those in docs/fabrics.md"


def _check_arguments(kind: type[Parameters], make: Callable[..., Any], values: Mapping[str, Any]) -> None:
    parameters = dict(inspect.signature(make).parameters)
    try:
        hints = typing.get_type_hints(make)
    except (NameError, AttributeError, TypeError):  # names that only a type checker knows
        hints = {}
    rest = [p.name for p in parameters.values() if p.kind is inspect.Parameter.VAR_KEYWORD]
    named = {name: p for name, p in parameters.items() if name not in rest}
    known = [*named, *(name for name in kind.model_fields if rest and name not in named)]
    for name, value in values.items():
        if name not in known:
            raise InputError(f"{_short(shown(name), value)}: unknown name{did_you_mean(name, known)}")
        if name in named and name in hints and (needed := _needed(hints[name], value)):
            raise InputError(f"{_short(name, value)}: {needed} is needed")
    missing = [name for name, p in named.items() if p.default is p.empty and name not in values]
    if missing:
        raise InputError("; ".join(f"{name}: is required" for name in missing))


def _short(name: str, value: Any) -> str:
    return f"{name} = {reprlib.repr(value)}" if isinstance(value, str | int | float | bool) else name


def _needed(hint: Any, value: Any) -> str:
    """What an argument of this type has to be, "" if it is that or cannot be told."""
    parts = set(_parts(hint))
    numbers = bool(parts & {int, float})
    if not parts & {int, float, str} and not any(isinstance(part, str) for part in parts):
        return ""  # a class, or anything
    if isinstance(value, str):
        return "" if not numbers or str in parts or any(isinstance(part, str) for part in parts) else _name(parts)
    if isinstance(value, bool):
        return "" if bool in parts or not numbers else _name(parts)
    if isinstance(value, int | float):
        return "" if {int, float} & set(_top(hint)) or not parts else _name(parts)
    if isinstance(value, tuple):
        if not any(typing.get_origin(part) for part in _top(hint)):
            return _name(parts)
        is_number = [isinstance(item, int | float) and not isinstance(item, bool) for item in value]
        return "" if all(is_number) or not numbers else "a list of finite numbers"
    if value is None:
        return "" if type(None) in parts else _name(parts)
    return ""


def _top(hint: Any) -> list[Any]:
    """The alternatives of a union."""
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        return [part for item in typing.get_args(hint) for part in _top(item)]
    return [hint]


def _parts(hint: Any) -> list[Any]:
    """A type and all its parts; the texts of a literal."""
    return [hint, *(part for item in typing.get_args(hint) for part in _parts(item))]


def _name(parts: set[Any]) -> str:
    is_list = any(
        typing.get_origin(part) not in (None, typing.Literal, typing.Union, types.UnionType) for part in parts
    )
    if is_list and parts & {int, float}:
        return "a list of finite numbers"
    if parts & {int, float}:
        return "a number"
    return "a text"
