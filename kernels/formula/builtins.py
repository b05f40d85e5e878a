"""Functions of Warp, by name, as formulas."""

import math
from collections.abc import Callable
from typing import Any

import warp as wp

from .graph import Expression


class Vector(tuple):
    """Components of a vector."""


_SCALARS = (
    wp.float64, wp.float32, wp.int32, wp.int64, wp.uint32, wp.uint64, wp.int8, wp.int16, wp.uint8, wp.uint16,
)  # fmt: skip


def as_number(value: Any) -> Any:
    """A constant of Warp as a number of Python; other values as they are."""
    if isinstance(value, _SCALARS):
        return value.value
    if hasattr(value, "_wp_scalar_type_") and not isinstance(value, type) and is_vector_type(type(value)):
        return Vector(float(component) for component in value)
    return value


def is_vector_type(kind: Any) -> bool:
    """Whether it is one of Warp's types of vectors."""
    return isinstance(kind, type) and hasattr(kind, "_wp_scalar_type_") and len(getattr(kind, "_shape_", ())) == 1


def _function(name: str) -> Callable[..., Expression]:
    return lambda reader, *arguments: reader.graph.function(name, *(reader.scalar(a) for a in arguments))


def _fold(name: str) -> Callable[..., Expression]:
    """Of two numbers, or of the components of one vector."""

    def fold(reader: Any, *arguments: Any) -> Expression:
        values = list(reader.scalars(arguments[0])) if len(arguments) == 1 else [reader.scalar(a) for a in arguments]
        result = values[0]
        for value in values[1:]:
            result = getattr(reader.graph, name)(result, value)
        return result

    return fold


def _number(reader: Any, value: Any) -> Any:
    return reader.scalar(value)


def _whole(reader: Any, value: Any) -> int:
    return reader.whole(value)


def _where(reader: Any, condition: Any, first: Any, second: Any) -> Any:
    condition = reader.condition(condition)
    if not isinstance(condition, Expression):
        return first if condition else second
    if isinstance(first, tuple):
        return type(first)(_where(reader, condition, a, b) for a, b in zip(first, second, strict=True))
    return reader.graph.choice(condition, reader.scalar(first), reader.scalar(second))


def _magnitude(reader: Any, value: Any) -> Expression:
    return reader.graph.magnitude(reader.scalar(value))


def _clamp(reader: Any, value: Any, low: Any, high: Any) -> Expression:
    graph = reader.graph
    return graph.smaller(graph.larger(reader.scalar(low), reader.scalar(value)), reader.scalar(high))


def _either(comparison: str, if_so: float, otherwise: float) -> Callable[..., Expression]:
    """One of two numbers, by the comparison of a value with zero."""

    def either(reader: Any, value: Any) -> Expression:
        graph = reader.graph
        holds = graph.comparison(comparison, reader.scalar(value), graph.number(0.0))
        return graph.choice(holds, graph.number(if_so), graph.number(otherwise))

    return either


def _logarithm(base: float) -> Callable[..., Expression]:
    return lambda reader, value: reader.graph.function("log", reader.scalar(value)) * (1.0 / math.log(base))


def _power(reader: Any, base: Any, exponent: Any) -> Expression:
    return reader.graph.power(reader.scalar(base), reader.scalar(exponent))


def _dot(reader: Any, a: Any, b: Any) -> Expression:
    return reader.graph.sum((1.0, x * y) for x, y in zip(reader.scalars(a), reader.scalars(b), strict=True))


def _length(reader: Any, a: Any) -> Expression:
    return reader.graph.function("sqrt", _dot(reader, a, a))


def _componentwise(operation: Callable[[Any, Any], Any]) -> Callable[..., Any]:
    def apply(reader: Any, a: Any, b: Any) -> Any:
        return type(a)(operation(x, y) for x, y in zip(reader.scalars(a), reader.scalars(b), strict=True))

    return apply


BUILTINS: dict[str, Callable[..., Any]] = {
    **{name: _function(name) for name in (
        "sqrt", "cbrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh",
        "floor", "ceil",
    )},
    "log2": _logarithm(2.0), "log10": _logarithm(10.0), "pow": _power,
    "min": _fold("smaller"), "max": _fold("larger"), "abs": _magnitude, "clamp": _clamp, "where": _where,
    "sign": _either("<", -1.0, 1.0), "step": _either("<", 1.0, 0.0), "nonzero": _either("==", 0.0, 1.0),
    "degrees": lambda reader, a: reader.scalar(a) * (180.0 / math.pi),
    "radians": lambda reader, a: reader.scalar(a) * (math.pi / 180.0),
    "dot": _dot, "length": _length, "length_sq": lambda reader, a: _dot(reader, a, a),
    "cw_mul": _componentwise(lambda a, b: a * b), "cw_div": _componentwise(lambda a, b: a / b),
    "float": _number, "float64": _number, "float32": _number, "int": _whole, "int32": _whole, "int64": _whole,
}  # fmt: skip
