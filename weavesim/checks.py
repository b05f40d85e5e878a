"""Checked, immutable values: the one system of checks for all user input.

``Parameters`` is a frozen record that is checked on construction and names the value that is wrong. ``Kinded`` is the
base class of families such as shapes or laws, whose members are identified by ``kind`` in JSON. Array fields use the
types of ``arrays.py``, and values that are not fields are checked by ``quantities.py``.
"""

from __future__ import annotations

import hashlib
import json
import re
import reprlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self, get_args, get_origin

import numpy as np
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    SerializationInfo,
    SerializerFunctionWrapHandler,
    ValidationError,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    field_validator,
    model_serializer,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema

from .arrays import frozen
from .documents import parse_json
from .errors import InputError, did_you_mean
from .input_files import shown

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]


if TYPE_CHECKING:

    class _Model:
        """The model that type checkers see: pydantic's own does not allow positional values."""

        model_config: ClassVar[ConfigDict]
        model_fields: ClassVar[dict[str, FieldInfo]]
        model_fields_set: set[str]

        def __init__(self, *arguments: Any, **values: Any) -> None: ...
        @classmethod
        def model_validate(cls, value: Any) -> Self: ...
        def model_dump(self, *, mode: str = "python", exclude: set[str] | None = None) -> dict[str, Any]: ...
        @classmethod
        def model_construct(cls, **values: Any) -> Self: ...
        @classmethod
        def model_json_schema(cls) -> dict[str, Any]: ...
        @classmethod
        def __pydantic_init_subclass__(cls, **settings: Any) -> None: ...
        def __getstate__(self) -> dict[str, Any]: ...
        def __setstate__(self, state: dict[str, Any]) -> None: ...
else:
    _Model = BaseModel


class Parameters(_Model):
    """Immutable, checked values; a bad one raises an InputError that names it.

    Equality and hash are by content, including arrays, bit by bit. ``positional`` lists the fields that may be given by
    position, in order.
    """

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        arbitrary_types_allowed=True,
        validate_default=True,
        ignored_types=(cached_property,),
    )

    positional: ClassVar[tuple[str, ...]] = ()

    @field_validator("*", mode="before")
    @classmethod
    def _true_is_no_number(cls, value: Any, info: ValidationInfo) -> Any:
        items = value if isinstance(value, tuple | list) else (value,)
        if info.field_name and any(isinstance(item, bool) for item in items):
            types = set(types_within(cls.model_fields[info.field_name].annotation))
            if types & {int, float} and bool not in types:
                raise ValueError("a number is needed, not true or false")
        return value

    @field_validator("*", mode="before")
    @classmethod
    def _text_is_no_number(cls, value: Any, info: ValidationInfo) -> Any:
        # Pydantic would take "0.6" for 0.6, and "1_0" for 10
        items = value if isinstance(value, tuple | list) else (value,)
        if info.field_name and any(isinstance(item, str | bytes) for item in items):
            parts = set(types_within(cls.model_fields[info.field_name].annotation))
            if parts & {int, float} and not any(isinstance(part, type) and issubclass(part, str) for part in parts):
                raise ValueError("a number is needed, not a text")
        return value

    @field_validator("*", mode="before")
    @classmethod
    def _one_is_no_list(cls, value: Any, info: ValidationInfo) -> Any:
        # Pydantic would take the fields of a lone value as the entries of the list
        field = cls.model_fields[info.field_name or ""]
        if isinstance(value, Parameters) and get_origin(field.annotation) is tuple:
            raise ValueError(_PLAIN["tuple_type"])
        return value

    def __init__(self, *arguments: Any, **values: Any) -> None:
        names = self.positional[: len(arguments)]
        if len(arguments) > len(names):
            own = [name for name in type(self).model_fields if name not in self.positional]
            by_name = f"; give others by name: {', '.join(own[:8])}{', ...' if own[8:] else ''}" if own else ""
            allowed = (", ".join(self.positional) or "none") + by_name
            raise InputError(
                f"{type(self).__name__}: {len(arguments)} values are given by position; allowed are {allowed}"
            )
        if twice := sorted(set(names) & set(values)):
            raise InputError(f"{type(self).__name__}: {', '.join(twice)} is given twice, by position and by name")
        try:
            super().__init__(**dict(zip(names, arguments, strict=True)), **values)
        except ValidationError as error:
            raise InputError(_of_class(type(self), _problems(error, type(self).model_fields))) from None

    def __setattr__(self, name: str, value: Any) -> None:
        if name in type(self).model_fields:
            raise InputError(
                f"{type(self).__name__}: {name} does not change once it is made; "
                f"model_copy(update={{{name!r}: ...}}) makes another value"
            )
        super().__setattr__(name, value)

    def _repr_html_(self) -> str:
        """A table for notebooks."""
        from .notebook import table_of

        return table_of(self)

    def disproportions(self) -> Iterator[str]:
        """Values that are hardly meant together, such as a tool a thousand times as large as the blank: sentences.

        A set-up that contains some is refused unless its user accepts unusual values (``ranges.py``).
        """
        yield from ()

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy with some values changed, checked like a new value.

        Raises:
            InputError: a value that is not allowed.
        """
        return type(self)(**{**{name: getattr(self, name) for name in type(self).model_fields}, **(update or {})})

    def to_json(self) -> str:
        """All values as JSON, with sorted keys; ``from_json`` restores an equal value, bit for bit."""
        return json.dumps(self.model_dump(mode="json"), sort_keys=True, allow_nan=False, ensure_ascii=False)

    @classmethod
    def from_json(cls, text: str | bytes) -> Self:
        """The value written by ``to_json``.

        Raises:
            InputError: text that is not JSON, or values that are not allowed, with their place.
        """
        try:
            content = parse_json(text)
        except (ValueError, RecursionError) as error:
            raise InputError(f"{cls.__name__}: not valid JSON ({shown(error)})") from None
        try:
            return cls.model_validate(content)
        except ValidationError as error:
            # nested values name their class in their messages, and this one may too
            problems, prefix = _problems(error, cls.model_fields), f"{cls.__name__}: "
            raise InputError(prefix + problems.removeprefix(prefix)) from None

    @cached_property
    def content_hash(self) -> str:
        """SHA-256 of the class and all values, 64 hexadecimal digits; the same in every process."""
        return hashlib.sha256(f"{type(self).__name__}\n{self.to_json()}".encode()).hexdigest()

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return all(_same(getattr(self, name), getattr(other, name)) for name in type(self).model_fields)

    def __hash__(self) -> int:
        return hash(self.content_hash)

    def __getstate__(self) -> dict[Any, Any]:
        # cached properties are computed again
        state = super().__getstate__()
        return {**state, "__dict__": {name: state["__dict__"][name] for name in type(self).model_fields}}

    def __setstate__(self, state: dict[Any, Any]) -> None:
        super().__setstate__(state)
        for name, value in self.__dict__.items():
            if isinstance(value, np.ndarray):  # those of a pickle are writable
                self.__dict__[name] = frozen(value)

    def __copy__(self) -> Self:
        return self  # it never changes

    def __deepcopy__(self, memo: dict[int, Any] | None = None) -> Self:
        return self


def _same(a: Any, b: Any) -> bool:
    """Whether two values have the same bits, as their hashes see them: 0.0 and -0.0 differ."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        alike = isinstance(a, np.ndarray) and isinstance(b, np.ndarray) and a.dtype == b.dtype and a.shape == b.shape
        return alike and a.tobytes() == b.tobytes()
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(_same, a, b))
    if isinstance(a, float) and isinstance(b, float):
        return a.hex() == b.hex()
    return type(a) is type(b) and bool(a == b)


# These replace Pydantic's own messages.
_PLAIN = {
    "greater_than": "a number above {gt:g} is needed", "greater_than_equal": "at least {ge:g} is needed",
    "less_than": "a number below {lt:g} is needed", "less_than_equal": "at most {le:g} is allowed",
    "float_type": "a number is needed", "float_parsing": "a number is needed",
    "finite_number": "a finite number is needed", "int_from_float": "a whole number is needed",
    "string_type": "a text is needed", "tuple_type": "give a list", "literal_error": "one of {expected} is needed",
    "model_type": "a {class_name} is needed", "extra_forbidden": "unknown name",
    "too_long": "at most {max_length} values are allowed, here are {actual_length}",
    "dict_type": "a table of names and values is needed", "bool_parsing": "true or false is needed",
}  # fmt: skip


# Names of fields as a user typed them, while ``typed_as`` is in force.
_typed: ContextVar[Mapping[str, str] | None] = ContextVar("typed", default=None)


@contextmanager
def typed_as(names: Mapping[str, str]) -> Iterator[None]:
    """Have messages name fields as the user typed them: "--mesh-size" for ``mesh_size``."""
    token = _typed.set(names)
    try:
        yield
    finally:
        _typed.reset(token)


def as_typed(text: str) -> str:
    """``text`` with the names of fields as the user typed them."""
    for name, typed in (_typed.get() or {}).items():
        text = re.sub(rf"\b{name}\b", typed, text)
    return text


def _of_class(cls: type, problems: str) -> str:
    # who typed options knows nothing of classes
    return problems if problems.startswith("--") else f"{cls.__name__}: {problems}"


def _problems(error: ValidationError, known: Iterable[str]) -> str:
    lines: dict[str, str] = {}
    # unknown names first: the one that is missing is often among them, misspelt
    for problem in sorted(error.errors(), key=lambda problem: problem["type"] != "extra_forbidden"):
        # a field that allows several types has one problem per type: the first is enough
        field, *rest = problem["loc"] or ("",)
        field = (_typed.get() or {}).get(str(field), field)
        name = shown(".".join([str(field), *(str(part) for part in rest if isinstance(part, int))]))
        message = _PLAIN.get(problem["type"], problem["msg"].removeprefix("Value error, "))
        message = message.format(**problem["ctx"]) if problem["type"] in _PLAIN and "ctx" in problem else message
        if problem["type"] == "extra_forbidden":
            message += did_you_mean(str(field), known)
        if problem["type"] == "missing":
            lines.setdefault(name, f"{name}: is required")
        elif isinstance(problem["input"], dict | np.ndarray):  # too long to show
            lines.setdefault(name, f"{name}: {message}" if name else message)
        else:
            lines.setdefault(name, f"{name} = {_shown(problem['input'])}: {message}" if name else message)
    return "; ".join(lines.values())


def _shown(value: Any) -> str:
    return f"{type(value).__name__}(...)" if isinstance(value, Parameters) else reprlib.repr(value)


def types_within(annotation: Any) -> Iterator[Any]:
    """``annotation`` and all its parts."""
    yield annotation
    for part in get_args(annotation):
        yield from types_within(part)


class Kinded(Parameters):
    """Base class of families of values of several kinds, such as shapes: a direct subclass is a family.

    In JSON a member is identified by ``kind``, the name of its class. Every subclass of a family is registered when
    its class is defined, so a user-defined kind needs nothing else. ``is_kind = False`` in a class body excludes
    a class that only serves as a base. ``implied_kind`` of a family is the kind of a table without ``kind``.
    """

    is_kind: ClassVar[bool] = True
    implied_kind: ClassVar[str | None] = None
    _family: ClassVar[dict[str, type[Any]]]

    @classmethod
    def __pydantic_init_subclass__(cls, **settings: Any) -> None:
        super().__pydantic_init_subclass__(**settings)
        if Kinded in cls.__bases__:
            cls._family = {}
        elif cls.__dict__.get("is_kind", True):
            cls._family[cls.__name__] = _kinds_by_name[cls.__name__] = cls

    @classmethod
    def kinds(cls) -> dict[str, type[Self]]:
        """Kinds of the family by name: ``cls`` and its subclasses."""
        return {name: kind for name, kind in cls._family.items() if issubclass(kind, cls)}

    @model_validator(mode="wrap")
    @classmethod
    def _made_of_its_kind(cls, value: Any, handler: ValidatorFunctionWrapHandler) -> Any:
        if isinstance(value, cls):
            return handler(value)
        if not isinstance(value, Mapping):
            raise ValueError(f"one of {', '.join(cls.kinds())} is needed")
        implied = cls.implied_kind if Kinded in cls.__bases__ else None
        name = value.get("kind", implied or cls.__name__)
        if not isinstance(name, str) or name not in cls.kinds():
            raise ValueError(
                f"kind = {name!r}: one of {', '.join(cls.kinds())} is needed; import the module that defines your own "
                "kind before reading it"
            )
        kind, rest = cls.kinds()[name], {key: item for key, item in value.items() if key != "kind"}
        return handler(rest) if kind is cls else kind(**rest)

    @model_serializer(mode="wrap")
    def _with_its_kind(self, handler: SerializerFunctionWrapHandler, info: SerializationInfo) -> dict[str, Any]:
        return {"kind": type(self).__name__, **handler(self)} if info.mode == "json" else handler(self)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        if _described.get() is not cls:
            return {_KINDS: list(cls.kinds())}  # families may contain themselves: ``json_schema`` puts references here
        _described.set(None)
        own = handler.resolve_ref_schema(handler(schema))
        own["properties"] = {"kind": {"const": cls.__name__, "type": "string"}, **own.get("properties", {})}
        own["required"] = ["kind", *own.get("required", [])]
        return own


# Placeholder in a schema, to be replaced by references to the kinds of these names.
_KINDS = "x-kinds"
# The kind whose own schema is being generated.
_described: ContextVar[type[Kinded] | None] = ContextVar("described", default=None)
_kinds_by_name: dict[str, type[Kinded]] = {}


def json_schema(cls: type[Parameters]) -> dict[str, Any]:
    """JSON schema of the output of a class's ``to_json``, including every kind of every family in it."""
    definitions: dict[str, Any] = {}

    def described(kind: type[Parameters]) -> dict[str, Any]:
        _described.set(kind if issubclass(kind, Kinded) else None)
        schema = kind.model_json_schema()
        for name, definition in schema.pop("$defs", {}).items():
            definitions.setdefault(name, linked(definition))
        return linked(schema)

    def linked(part: Any) -> Any:
        if isinstance(part, list):
            return [linked(item) for item in part]
        if not isinstance(part, dict):
            return part
        if _KINDS not in part:
            return {key: linked(item) for key, item in part.items()}
        for name in part[_KINDS]:
            if name not in definitions:
                definitions[name] = {}  # a kind may contain itself
                definitions[name] = described(_kinds_by_name[name])
        return {"anyOf": [{"$ref": f"#/$defs/{name}"} for name in part[_KINDS]]}

    schema = described(cls)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "$defs": definitions}
