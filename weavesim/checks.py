"""Immutable physical parameters, checked when they are made."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Self, get_args

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, ValidationInfo, field_validator

from .errors import InputError

if TYPE_CHECKING:
    pass

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]


def at_most(largest: float, hint: str) -> AfterValidator:
    """An upper bound far above what makes sense, against values in a wrong unit: the ``hint`` says which is meant."""

    def check(value: float) -> float:
        if value > largest:
            raise ValueError(f"at most {largest:.4g} is allowed: {hint}")
        return value

    return AfterValidator(check)


def positive_number(name: str, value: Any, *, largest: float = float("inf"), hint: str = "") -> float:
    """``value`` as a number above zero, for what is no field of a class.

    Raises:
        InputError: no number, not above zero, or more than ``largest``, which the ``hint`` explains.
    """
    if isinstance(value, bool | str | bytes):
        raise InputError(f"{name} = {value!r}: a number above 0 is needed")
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} = {value!r}: a number above 0 is needed") from None
    if not 0.0 < number < float("inf"):
        raise InputError(f"{name} = {number:.6g}: a finite number above 0 is needed")
    if number > largest:
        raise InputError(f"{name} = {number:.6g}: at most {largest:.4g} is allowed: {hint}")
    return number


class Parameters(BaseModel):
    """Immutable, checked parameters; a bad value raises InputError that names it."""

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)

    @field_validator("*", mode="before")
    @classmethod
    def _true_is_no_number(cls, value: Any, info: ValidationInfo) -> Any:
        items = value if isinstance(value, tuple | list) else (value,)
        if any(isinstance(item, bool) for item in items):
            types = set(_types(cls.model_fields[info.field_name].annotation))
            if types & {int, float} and bool not in types:
                raise ValueError("a number is needed, not true or false")
        return value

    def __init__(self, **values):
        try:
            super().__init__(**values)
        except ValidationError as error:
            lines = {}
            for problem in error.errors():
                # a field that allows several types has one problem per type: the first says enough
                field, *rest = problem["loc"] or ("",)
                name = ".".join([str(field), *(str(part) for part in rest if isinstance(part, int))])
                message = problem["msg"].removeprefix("Value error, ")
                if problem["type"] == "missing":
                    lines.setdefault(name, f"{name}: is required")
                else:
                    lines.setdefault(name, f"{name} = {problem['input']!r}: {message}" if name else message)
            raise InputError(f"{type(self).__name__}: " + "; ".join(lines.values())) from None

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy with some values changed, checked like a new one.

        Raises:
            InputError: a value that is not allowed.
        """
        return type(self)(**{**{name: getattr(self, name) for name in type(self).model_fields}, **(update or {})})


def _types(annotation: Any) -> Iterator[Any]:
    """``annotation`` and all that it is made of."""
    yield annotation
    for part in get_args(annotation):
        yield from _types(part)


Vector = tuple[float, float, float]


def positive(what: str, value: Any) -> float:
    """``value`` as a float; InputError unless it is finite and above zero."""
    number = finite(what, value)
    if number <= 0.0:
        raise InputError(f"{what} is {value}; it must be above zero.")
    return number


def finite(what: str, value: Any) -> float:
    """``value`` as a float; InputError unless it is a finite number."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InputError(f"{what} is {value!r}; it must be a number.") from None
    if not math.isfinite(number):
        raise InputError(f"{what} is {value}; it must be finite.")
    return number


def vector(what: str, value: Any) -> Vector:
    """``value`` as three finite floats; InputError otherwise."""
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (3,) or not np.all(np.isfinite(array)):
        raise InputError(f"{what} is {value!r}; it must be three finite numbers.")
    return (float(array[0]), float(array[1]), float(array[2]))


def unit_vector(what: str, value: Any) -> Vector:
    """``value`` scaled to length one; InputError if it has no direction."""
    array = np.array(vector(what, value))
    length = float(np.linalg.norm(array))
    if length < 1e-12:
        raise InputError(f"{what} is {value!r}; it must not be zero, for it gives a direction.")
    return vector(what, array / length)
