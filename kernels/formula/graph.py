"""Formulas as graphs: every subexpression exists once, sums and products are simplified as they are made.

A ``Graph`` makes ``Expression`` values of real numbers. It folds constants, collects like terms and powers, and leaves
the grouping of sums alone, since that may have been chosen for its rounding: only what cancels exactly, as in
(1 + e) - 1, is regrouped. Arguments always come before what is made of them (``Expression.serial``).
"""

import math
import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import reduce
from typing import Any

import numpy as np

from .functions import arctangent2

COMPARISONS: dict[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip
# Functions of real numbers, by their names in C++, as NumPy has them.
FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sqrt": np.sqrt, "cbrt": np.cbrt, "exp": np.exp, "log": np.log, "pow": np.power,
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan,
    "atan2": arctangent2, "sinh": np.sinh, "cosh": np.cosh, "tanh": np.tanh, "floor": np.floor, "ceil": np.ceil,
}  # fmt: skip


class Expression:
    """A number, symbol, sum, product, function, choice or condition; made by a ``Graph`` only.

    Attributes:
        kind: "number", "symbol", "sum", "product", "function", "choice", "comparison", "all", "any" or "not".
        value: the number; the symbol's name; of a sum (constant, coefficients); of a product (coefficient, exponents);
            the function; the comparison.
        arguments: what it is made of.
        uniform: True if it is made of parameters alone.
        serial: place in the order of creation.
    """

    __slots__ = ("arguments", "graph", "kind", "serial", "uniform", "value")

    def __init__(self, graph: "Graph", kind: str, value: Any, arguments: tuple["Expression", ...], uniform: bool):
        self.graph, self.kind, self.value, self.arguments, self.uniform = graph, kind, value, arguments, uniform
        self.serial = len(graph.known)

    @property
    def is_number(self) -> bool:
        """Whether it is a constant."""
        return self.kind == "number"

    def is_equal(self, number: float) -> bool:
        """Whether it is this number."""
        return self.kind == "number" and self.value == number

    def __add__(self, other: "Expression | float") -> "Expression":
        return self.graph.sum([(1.0, self), (1.0, self.graph.wrap(other))])

    def __sub__(self, other: "Expression | float") -> "Expression":
        return self.graph.sum([(1.0, self), (-1.0, self.graph.wrap(other))])

    def __mul__(self, other: "Expression | float") -> "Expression":
        return self.graph.product([(self, 1), (self.graph.wrap(other), 1)])

    def __truediv__(self, other: "Expression | float") -> "Expression":
        return self.graph.product([(self, 1), (self.graph.wrap(other), -1)])

    def __neg__(self) -> "Expression":
        return self.graph.product([(self, 1)], -1.0)

    def __radd__(self, other: float) -> "Expression":
        return self + other

    def __rsub__(self, other: float) -> "Expression":
        return self.graph.wrap(other) - self

    def __rmul__(self, other: float) -> "Expression":
        return self * other

    def __rtruediv__(self, other: float) -> "Expression":
        return self.graph.wrap(other) / self


class Graph:
    """All expressions of some formulas."""

    def __init__(self) -> None:
        self.known: dict[tuple[Any, ...], Expression] = {}

    def _make(self, kind: str, value: Any, *arguments: Expression, uniform: bool | None = None) -> Expression:
        key = (kind, value, *(argument.serial for argument in arguments))
        found = self.known.get(key)
        if found is None:
            uniform = all(argument.uniform for argument in arguments) if uniform is None else uniform
            found = self.known[key] = Expression(self, kind, value, arguments, uniform)
        return found

    def number(self, value: float) -> Expression:
        """A constant."""
        # zero has one sign
        return self._make("number", float(value) + 0.0)

    def wrap(self, value: Expression | float) -> Expression:
        """An expression as it is, and a number as a constant."""
        return value if isinstance(value, Expression) else self.number(value)

    def symbol(self, name: str, *, uniform: bool = False) -> Expression:
        """A variable, by its name."""
        return self._make("symbol", name, uniform=uniform)

    # --- sums and products --------------------------------------------------------------------------------------------

    def sum(self, terms: Iterable[tuple[float, Expression]]) -> Expression:
        """Sum of coefficients times expressions."""
        constant, grouped, flat, flat_length = 0.0, {}, {}, 0
        for coefficient, term in terms:
            scale, bare = self._split(term)
            scale *= coefficient
            if bare.kind == "number":
                constant += scale * bare.value
                continue
            inner = list(zip(bare.value[1], bare.arguments, strict=True)) if bare.kind == "sum" else [(1.0, bare)]
            if bare.kind == "sum":
                constant += scale * bare.value[0]
                bare = self._sum(0.0, dict((b, a) for a, b in inner))
                again, bare = self._split(bare)
                grouped[bare] = grouped.get(bare, 0.0) + scale * again
            else:
                grouped[bare] = grouped.get(bare, 0.0) + scale
            flat_length += len(inner)
            for factor, part in inner:
                flat[part] = flat.get(part, 0.0) + scale * factor
        grouped = {term: factor for term, factor in grouped.items() if factor != 0.0}
        flat = {term: factor for term, factor in flat.items() if factor != 0.0}
        # like terms across groups: without groups it is shorter
        return self._sum(constant, flat if len(flat) < flat_length else grouped)

    def _split(self, term: Expression) -> tuple[float, Expression]:
        """(coefficient, the rest) of a product."""
        if term.kind != "product" or term.value[0] == 1.0:
            return 1.0, term
        coefficient, exponents = term.value
        return coefficient, self._product(1.0, dict(zip(term.arguments, exponents, strict=True)))

    def _sum(self, constant: float, terms: Mapping[Expression, float]) -> Expression:
        if not terms:
            return self.number(constant)
        if constant == 0.0 and len(terms) == 1:
            ((term, factor),) = terms.items()
            return self.product([(term, 1)], factor)
        ordered = sorted(terms, key=lambda term: term.serial)
        if constant == 0.0:
            # a factor of all terms belongs to the product around them
            least = min(abs(factor) for factor in terms.values())
            if least not in (0.0, 1.0) and math.isfinite(least):
                inner = self._make("sum", (0.0, tuple(terms[term] / least for term in ordered)), *ordered)
                return self.product([(inner, 1)], least)
        return self._make("sum", (constant + 0.0, tuple(terms[term] for term in ordered)), *ordered)

    def product(self, factors: Iterable[tuple[Expression, int]], coefficient: float = 1.0) -> Expression:
        """Product of a coefficient and of powers with whole exponents."""
        powers: dict[Expression, int] = {}
        todo = list(factors)
        while todo:
            base, exponent = todo.pop(0)
            if base.kind == "number":
                coefficient *= float(np.float64(base.value) ** exponent) if exponent >= 0 or base.value else math.inf
            elif base.kind == "product":
                coefficient *= base.value[0] ** exponent
                todo += [(inner, power * exponent) for inner, power in zip(base.arguments, base.value[1], strict=True)]
            else:
                powers[base] = powers.get(base, 0) + exponent
        if coefficient == 0.0:
            return self.number(0.0)
        return self._product(coefficient, self._without_roots(powers))

    def _without_roots(self, powers: dict[Expression, int]) -> dict[Expression, int]:
        """Squares of roots as what is under the root."""
        result: dict[Expression, int] = {}
        for base, exponent in powers.items():
            if base.kind == "function" and base.value == "sqrt" and abs(exponent) > 1:
                half = exponent // 2 if exponent > 0 else -(-exponent // 2)
                inner = base.arguments[0]
                result[inner] = result.get(inner, 0) + half
                exponent -= 2 * half
            result[base] = result.get(base, 0) + exponent
        return {base: exponent for base, exponent in result.items() if exponent != 0}

    def _product(self, coefficient: float, powers: Mapping[Expression, int]) -> Expression:
        powers = {base: exponent for base, exponent in powers.items() if exponent != 0}
        if not powers:
            return self.number(coefficient)
        if coefficient == 1.0 and len(powers) == 1:
            ((base, exponent),) = powers.items()
            if exponent == 1:
                return base
        ordered = sorted(powers, key=lambda base: base.serial)
        return self._make("product", (coefficient, tuple(powers[base] for base in ordered)), *ordered)

    # --- functions, choices, conditions -------------------------------------------------------------------------------

    def function(self, name: str, *arguments: Expression) -> Expression:
        """One of ``FUNCTIONS``."""
        if all(argument.is_number for argument in arguments):
            with np.errstate(all="ignore"):
                return self.number(float(FUNCTIONS[name](*(np.float64(argument.value) for argument in arguments))))
        return self._make("function", name, *arguments)

    def power(self, base: Expression, exponent: Expression) -> Expression:
        """``base`` to the power of ``exponent``."""
        if exponent.is_number and float(exponent.value).is_integer() and abs(exponent.value) <= 16:
            return self.product([(base, int(exponent.value))])
        if exponent.is_equal(0.5):
            return self.function("sqrt", base)
        return self.function("pow", base, exponent)

    def choice(self, condition: Expression | bool, first: Expression, second: Expression) -> Expression:
        """``first`` where the condition holds, else ``second``."""
        if not isinstance(condition, Expression):
            return first if condition else second
        return first if first is second else self._make("choice", None, condition, first, second)

    def comparison(self, name: str, first: Expression, second: Expression) -> Expression | bool:
        """Whether a comparison, such as "<", holds; true or false of two constants."""
        if first.is_number and second.is_number:
            return bool(COMPARISONS[name](first.value, second.value))
        return self._make("comparison", name, first, second)

    def negation(self, condition: Expression | bool) -> Expression | bool:
        """The opposite of a condition."""
        return self._make("not", None, condition) if isinstance(condition, Expression) else not condition

    def combination(self, name: str, conditions: Sequence[Expression | bool]) -> Expression | bool:
        """ "all" or "any" of some conditions."""
        decisive = name == "any"
        if any(condition is decisive for condition in conditions):
            return decisive
        open_ones = [condition for condition in conditions if isinstance(condition, Expression)]
        if not open_ones:
            return not decisive
        return open_ones[0] if len(open_ones) == 1 else self._make(name, None, *open_ones)

    def larger(self, a: Expression, b: Expression) -> Expression:
        """The larger of two."""
        return self.choice(self.comparison(">", a, b), a, b)

    def smaller(self, a: Expression, b: Expression) -> Expression:
        """The smaller of two."""
        return self.choice(self.comparison("<", a, b), a, b)

    def magnitude(self, a: Expression) -> Expression:
        """|a|."""
        return self.choice(self.comparison("<", a, self.number(0.0)), -a, a)


def in_order(expressions: Iterable[Expression]) -> list[Expression]:
    """These and all that they are made of, arguments first."""
    found: dict[int, Expression] = {}
    todo = list(expressions)
    while todo:
        expression = todo.pop()
        if expression.serial not in found:
            found[expression.serial] = expression
            todo += expression.arguments
    return [found[serial] for serial in sorted(found)]


def evaluated(expressions: Sequence[Expression], symbols: Mapping[str, Any]) -> list[Any]:
    """Values of expressions for values of the symbols, numbers or NumPy arrays."""
    values: dict[Expression, Any] = {}
    with np.errstate(all="ignore"):
        for expression in in_order(expressions):
            values[expression] = _evaluated(expression, [values[one] for one in expression.arguments], symbols)
    return [values[expression] for expression in expressions]


def _evaluated(expression: Expression, arguments: list[Any], symbols: Mapping[str, Any]) -> Any:
    match expression.kind:
        case "number":
            return np.float64(expression.value)
        case "symbol":
            return np.asarray(symbols[expression.value], dtype=np.float64)[()]
        case "sum":
            constant, coefficients = expression.value
            return sum((c * a for c, a in zip(coefficients, arguments, strict=True)), np.float64(constant))
        case "product":
            coefficient, exponents = expression.value
            powers = (math.prod([a] * abs(n)) for a, n in zip(arguments, exponents, strict=True))
            signed = (a if n > 0 else 1.0 / a for a, n in zip(powers, exponents, strict=True))
            return math.prod(signed, start=np.float64(coefficient))
        case "function":
            return FUNCTIONS[expression.value](*arguments)
        case "choice":
            return np.where(*arguments)[()]
        case "comparison":
            return COMPARISONS[expression.value](*arguments)
        case "not":
            return np.logical_not(arguments[0])
        case _:
            return reduce(np.logical_and if expression.kind == "all" else np.logical_or, arguments)
