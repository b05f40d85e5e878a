"""Parameters of a study: what their values are, and how they are written into a job."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..errors import InputError
from ..tables.units import parse_unit
from .schema import VaryTable

Value = float | int | str | bool | tuple[Any, ...]

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\D.*)?")
# Digits of the values of a design: the same on every machine, whatever the last bits of its random numbers.
DIGITS = 7
# At which a normal distribution is cut off, in standard deviations.
CUT_OFF = 3.0


@dataclass(frozen=True)
class Factor:
    """A parameter of a study.

    Attributes:
        name: in all results.
        keys: of the job, which get the same value.
        unit: of its numbers as they are written; "" for SI or none.
        si_unit: of the job's key, for numbers that are written without one; "" for none.
        low, high: ends of its range; mean minus and plus three deviations of a normal distribution.
        scale: "linear", "log", "normal", or "values".
        step: values are multiples of it from ``low`` on; 0 for any value.
        choices: its values, if these are given.
        count: levels of a factorial study; None if the file does not say.
        scattered: nobody controls it.
    """

    name: str
    keys: tuple[str, ...]
    unit: str = ""
    si_unit: str = ""
    low: float = 0.0
    high: float = 1.0
    scale: str = "linear"
    step: float = 0.0
    choices: tuple[Value, ...] = ()
    count: int | None = None
    scattered: bool = False

    @property
    def is_numeric(self) -> bool:
        """Whether all of its values are numbers."""
        return all(isinstance(choice, int | float) and not isinstance(choice, bool) for choice in self.choices)

    @property
    def shown_unit(self) -> str:
        """Of its numbers, for readers; "" for none."""
        return (self.unit or self.si_unit) if self.is_numeric else ""

    @property
    def label(self) -> str:
        """Its name with the unit."""
        return f"{self.name} [{self.shown_unit}]" if self.shown_unit else self.name

    @property
    def base(self) -> Value:
        """A value in the middle."""
        return self.choices[len(self.choices) // 2] if self.choices else self.at(0.5)

    @property
    def ends(self) -> tuple[Value, ...]:
        """The values at both ends; every one that is given."""
        return self.choices or (self.at(0.0), self.at(1.0))

    @property
    def level_count(self) -> int | None:
        """How many values it can have; None for any number."""
        if self.choices:
            return len(self.choices)
        return int((self.high - self.low) / self.step + 1.0e-9) + 1 if self.step else None

    def levels(self) -> tuple[Value, ...]:
        """Of a factorial study.

        Raises:
            InputError: neither values nor a count are given.
        """
        if self.choices:
            return self.choices
        count = self.count or self.level_count
        if count is None:
            raise InputError(f"{self.name}: count is required in a factorial study with a range: how many values")
        shares = np.linspace(0.0, 1.0, count)
        if self.scale == "normal":  # evenly in the value, not in the probability
            return tuple(_rounded(self.low + share * (self.high - self.low)) for share in shares)
        return tuple(dict.fromkeys(self.at(float(share)) for share in shares))

    def at(self, share: float) -> Value:
        """The value below which a share of the distribution lies, 0 to 1."""
        if self.choices:
            return self.choices[min(int(share * len(self.choices)), len(self.choices) - 1)]
        if self.scale == "normal":
            from scipy.stats import truncnorm

            deviation = (self.high - self.low) / (2.0 * CUT_OFF)
            middle = 0.5 * (self.low + self.high)
            return _rounded(float(truncnorm.ppf(share, -CUT_OFF, CUT_OFF, loc=middle, scale=deviation)))
        if self.step:
            count = self.level_count or 1
            value = self.low + self.step * min(int(share * count), count - 1)
            whole = float(self.step).is_integer() and float(self.low).is_integer()
            return round(value) if whole else _rounded(value)
        if self.scale == "log":
            return _rounded(math.exp(math.log(self.low) + share * math.log(self.high / self.low)))
        return _rounded(self.low + share * (self.high - self.low))

    def settings(self, value: Value) -> list[str]:
        """Of the job, in the form of --set."""
        return [f"{key}={self.text(value)}" for key in self.keys]

    def text(self, value: Value) -> str:
        """A value as it stands in a job, with its unit."""
        if isinstance(value, bool | str | tuple):
            return json.dumps(value, ensure_ascii=False)
        return f"{value!r} {self.unit}".strip()

    def shown(self, value: Value) -> str:
        """A value for readers."""
        if isinstance(value, str):
            return value
        if isinstance(value, bool | tuple):
            return self.text(value)
        number = f"{value:.5g}" if isinstance(value, float) else repr(value)
        return f"{number} {self.shown_unit}".strip()

    def with_si_unit(self, unit_of: Callable[[str], str]) -> Factor:
        """The same, with the unit that ``unit_of`` gives of its keys, if that is one."""
        units = {unit_of(key) for key in self.keys}
        return replace(self, si_unit=units.pop()) if len(units) == 1 else self


def factor_of(table: VaryTable, *, scattered: bool = False) -> Factor:
    """The parameter of a table.

    Raises:
        InputError: a range that is empty, values without a common unit.
    """
    keys = (table.key,) if isinstance(table.key, str) else table.key
    if not keys or not all(key.strip() and "=" not in key for key in keys):
        raise InputError(f"key = {table.key!r}: a key of the job is needed, such as tools.ring.force")
    common: dict[str, Any] = {"name": table.name or keys[0], "keys": keys, "count": table.count, "scattered": scattered}
    if table.values is not None:
        unit, numbers = _common_unit(table.values)
        given = tuple(numbers) if numbers else tuple(_plain(value) for value in table.values)
        if len({json.dumps(value) for value in given}) < len(given):
            raise InputError(f"values = {list(table.values)}: every value once is needed")
        return Factor(**common, unit=unit if numbers else "", choices=given, scale="values")
    given = (table.mean, table.deviation) if table.range is None else table.range
    step = () if table.step is None else (table.step,)
    unit, numbers = _common_unit((*given, *step))
    what = "mean and deviation" if table.range is None else "range"
    if not numbers:
        raise InputError(f"{what} = {_listed((*given, *step))}: numbers with one unit are needed")
    first, second = numbers[:2]
    if table.range is None:
        if second <= 0.0:
            raise InputError(f"deviation = {given[1]!r}: above 0 is needed")
        return Factor(**common, unit=unit, low=first - CUT_OFF * second, high=first + CUT_OFF * second, scale="normal")
    if not first < second:
        raise InputError(f"range = {_listed(given)}: it is empty; the first value must be below the second")
    if table.scale == "log" and first <= 0.0:
        raise InputError(f"range = {_listed(given)}: a log scale needs values above 0")
    if step and not 0.0 < numbers[2] <= second - first:
        raise InputError(f"step = {table.step!r}: above 0 and at most {second - first:g} is needed")
    if step and table.scale == "log":
        raise InputError("step: has no effect on a log scale; leave one of them out")
    return Factor(**common, unit=unit, low=first, high=second, scale=table.scale, step=numbers[2] if step else 0.0)


def _listed(values: tuple[Any, ...]) -> str:
    return f"[{', '.join(map(repr, values))}]"


def _common_unit(values: tuple[Any, ...]) -> tuple[str, list[float]]:
    """The unit of the first of some numbers, and all of them in it; no numbers if one is none, or of another kind."""
    parsed: list[tuple[float, str]] = []
    for value in values:
        if isinstance(value, int | float) and not isinstance(value, bool):
            parsed.append((value, ""))
        elif isinstance(value, str) and (match := _NUMBER.fullmatch(value)):
            parsed.append((float(match[1]), (match[2] or "").strip()))
        else:
            return "", []
    unit = parsed[0][1]
    numbers: list[float] = []
    for number, written in parsed:
        if written != unit:
            own, other = parse_unit(unit) if unit else None, parse_unit(written) if written else None
            if own is None or other is None or own.dimension != other.dimension:
                return "", []
            number = _rounded(number * other.factor / own.factor)
        numbers.append(number)
    return unit, numbers


def _plain(value: Any) -> Value:
    return tuple(_plain(item) for item in value) if isinstance(value, list | tuple) else value


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def parsed_vary(text: str) -> VaryTable:
    """The table of "tools.ring.force=100:2000:8" or "tools.ring.friction=0.1,0.2"; numbers may have units.

    Raises:
        InputError: another form.
    """
    form = "KEY=LOW:HIGH:COUNT, KEY=LOW:HIGH or KEY=VALUE,VALUE,... is needed, such as tools.ring.force=100:2000:8"
    key, equals, rest = text.partition("=")
    if not equals or not key.strip() or not rest.strip():
        raise InputError(f"--vary {text}: {form}")
    parts = [part.strip() for part in rest.split(":")]
    try:
        if len(parts) == 1:
            return VaryTable(key=key.strip(), values=tuple(_value(part) for part in rest.split(",")))
        if len(parts) > 3 or not all(parts):
            raise InputError(form)
        count = {"count": int(parts[2])} if len(parts) == 3 and parts[2].isdigit() else {}
        if len(parts) == 3 and not count:
            raise InputError(f"{parts[2]!r} is no count; {form}")
        return VaryTable(key=key.strip(), range=(_value(parts[0]), _value(parts[1])), **count)
    except InputError as error:
        raise InputError(f"--vary {text}: {str(error).removeprefix('VaryTable: ')}") from None


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text.strip()
