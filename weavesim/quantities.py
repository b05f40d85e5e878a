"""Checks of single numbers and vectors: for function arguments, and as field types of three or more numbers.

All messages have the form "name = value: what is needed"; booleans and strings are not numbers.
"""

from __future__ import annotations

import math
import reprlib
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator

from .errors import InputError

Vector = tuple[float, float, float]


def finite(name: str, value: Any) -> float:
    """``value`` as a float.

    Raises:
        InputError: not a finite number.
    """
    number = _number(value)
    if not math.isfinite(number):
        raise InputError(f"{name} = {_shown(value)}: a finite number is needed")
    return number


def positive(name: str, value: Any, *, largest: float = math.inf, hint: str = "") -> float:
    """``value`` as a float.

    Raises:
        InputError: not a finite number above zero, or above ``largest``; the ``hint`` explains that limit.
    """
    number = _number(value)
    if not 0.0 < number < math.inf:
        raise InputError(f"{name} = {_shown(value)}: a finite number above 0 is needed")
    if number > largest:
        raise InputError(f"{name} = {_shown(value)}: at most {largest:.4g} is allowed: {hint}")
    return number


def vector(name: str, value: Any) -> Vector:
    """``value`` as three floats.

    Raises:
        InputError: not three finite numbers.
    """
    try:
        return _vector(value)
    except ValueError as error:
        raise InputError(f"{name} = {_shown(value)}: {error}") from None


def unit_vector(name: str, value: Any) -> Vector:
    """``value`` scaled to length one.

    Raises:
        InputError: not three finite numbers, or all of them zero.
    """
    try:
        return _unit_vector(value)
    except ValueError as error:
        raise InputError(f"{name} = {_shown(value)}: {error}") from None


def _shown(value: Any) -> str:
    return reprlib.repr(value.tolist() if isinstance(value, np.ndarray | np.generic) else value)


def _number(value: Any) -> float:
    """``value`` as a float, NaN if it is not a number."""
    if isinstance(value, bool | np.bool_ | str | bytes):
        return math.nan
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return math.nan


def _vector(value: Any) -> Vector:
    try:
        x, y, z = (_number(item) for item in value)
    except (TypeError, ValueError):
        x = y = z = math.nan
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        raise ValueError("three finite numbers are needed")
    return (x, y, z)


def _unit_vector(value: Any) -> Vector:
    given = _vector(value)
    length = float(np.linalg.norm(given))
    if length < 1e-12:
        raise ValueError("a direction is needed, other than zero")
    if not math.isfinite(length):  # the square of a component overflows, and the direction would be zero
        raise ValueError("a direction of moderate length is needed, such as (0, 0, 1)")
    # a vector that is already scaled keeps its bits
    return given if abs(length - 1.0) <= UNIT_ROUNDING else _vector(np.array(given) / length)


def _numbers(value: Any) -> tuple[float, ...]:
    if isinstance(value, str | bytes):
        raise ValueError("a list of numbers is needed")
    try:
        items = tuple(value)
    except TypeError:
        raise ValueError("a list of numbers is needed") from None
    return tuple(finite(f"entry {k}", item) for k, item in enumerate(items))


# A vector that was scaled to length one differs from it by less than this.
UNIT_ROUNDING = 4.0 * float(np.finfo(np.float64).eps)
# Field types: three finite numbers; the same, scaled to length one; any number of finite numbers.
FiniteVector = Annotated[Vector, BeforeValidator(_vector)]
UnitVector = Annotated[Vector, BeforeValidator(_unit_vector)]
Numbers = Annotated[tuple[float, ...], BeforeValidator(_numbers)]
