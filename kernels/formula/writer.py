"""Formulas as C++ for all lanes: a loop over the lanes without branches or calls, which the compiler vectorises.

What is made of parameters alone is computed once, on the host, in double precision (``Constants``). Factors that
several products share are multiplied once.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from typing import Any

from .functions import definitions
from .graph import Expression, Graph, evaluated

# A factor of a product: ("value" or "inverse", expression), ("pair", number of the pair).
Factor = tuple[str, Any]


class Constants:
    """Uniform expressions, each with its place in the array of constants that the device gets."""

    def __init__(self) -> None:
        self._places: dict[Expression, int] = {}

    def __len__(self) -> int:
        return len(self._places)

    def place(self, expression: Expression) -> int:
        """Place of an expression, a new one where it has none."""
        return self._places.setdefault(expression, len(self._places))

    def values(self, symbols: Mapping[str, Any]) -> list[float]:
        """Their values for those of the parameters; 1 and 0 for conditions."""
        return [float(value) for value in evaluated(list(self._places), symbols)]


class Writer:
    """Writes the body of a loop over the lanes.

    Args:
        constants: to which it adds those that it needs.
        real: the C++ type in which everything is computed.
        read: C++ expressions of the symbols.
    """

    def __init__(self, constants: Constants, real: str, read: Mapping[str, str]):
        self.constants, self.real, self.read = constants, real, read
        self.lines: list[str] = []
        self.names: dict[Any, str] = {}
        self.functions: set[str] = set()
        self.products: dict[Expression, list[Factor]] = {}
        self.pairs: list[tuple[Factor, Factor]] = []

    def write(self, outputs: Sequence[Expression]) -> list[str]:
        """Definitions of C++ names, then the outputs' C++ expressions (``texts``)."""
        order = varying_in_order(outputs)
        self.roots = {e.arguments[0]: e for e in order if e.kind == "function" and e.value == "sqrt"}
        for expression in order:
            if expression.kind == "product":
                self.products[expression] = self._factors(expression)
        self._share_factors()
        for expression in order:
            self._define(expression, self._text(expression))
        self.texts = [self._value(output) for output in outputs]
        return self.lines

    # --- products -----------------------------------------------------------------------------------------------------

    def _factors(self, product: Expression) -> list[Factor]:
        """Its factors; what is uniform in it is one of them."""
        coefficient, exponents = product.value
        powers = list(zip(product.arguments, exponents, strict=True))
        uniform = product.graph.product(((a, n) for a, n in powers if a.uniform), abs(coefficient))
        factors: list[Factor] = [] if uniform.is_equal(1.0) else [("value", uniform)]
        for base, exponent in powers:
            if exponent < 0 and base in self.roots:
                # the root's inverse is there anyway, and squaring it is cheaper than another division
                factors += [("inverse", self.roots[base])] * (-2 * exponent)
            elif not base.uniform:
                factors += [("value" if exponent > 0 else "inverse", base)] * abs(exponent)
        return factors

    def _share_factors(self) -> None:
        """Replace the pair of factors that most products have in common, until no two have one in common."""
        while True:
            counts: Counter[tuple[Factor, Factor]] = Counter()
            for factors in self.products.values():
                counts.update({_ordered(a, b) for a, b in combinations(factors, 2)})
            if not counts:
                return
            pair, count = max(counts.items(), key=lambda item: (item[1], _key(item[0][0]), _key(item[0][1])))
            if count < 2:
                return
            shared: Factor = ("pair", len(self.pairs))
            self.pairs.append(pair)
            for factors in self.products.values():
                while pair[0] in factors and pair[1] in factors and (pair[0] != pair[1] or factors.count(pair[0]) > 1):
                    factors.remove(pair[0])
                    factors.remove(pair[1])
                    factors.append(shared)

    def _factor(self, factor: Factor) -> str:
        kind, what = factor
        if kind == "value":
            return self._value(what)
        if factor not in self.names:
            if kind == "inverse":
                self._define(factor, f"{self.real}(1.0) / {self._value(what)}")
            else:
                first, second = self.pairs[what]
                self._define(factor, f"{self._factor(first)} * {self._factor(second)}")
        return self.names[factor]

    # --- everything ---------------------------------------------------------------------------------------------------

    def _define(self, what: Any, text: str) -> None:
        name = self.names[what] = f"t{len(self.names)}"
        condition = isinstance(what, Expression) and what.kind in ("comparison", "all", "any", "not")
        self.lines.append(f"const {'bool' if condition else self.real} {name} = {text};")

    def _value(self, expression: Expression) -> str:
        if expression.is_number:
            return self._literal(expression.value)
        if not expression.uniform:
            return self.names[expression]
        text = f"p.constants[{self.constants.place(expression)}]"
        return f"({text} != {self.real}(0.0))" if expression.kind in ("comparison", "all", "any", "not") else text

    def _literal(self, value: float) -> str:
        # all digits; C++ has no literals for what is not finite
        special = {"inf": "INFINITY", "-inf": "-INFINITY", "nan": "NAN"}
        return f"{self.real}({special.get(repr(value), repr(value))})"

    def _text(self, expression: Expression) -> str:
        arguments = expression.arguments
        match expression.kind:
            case "symbol":
                return self.read[expression.value]
            case "sum":
                return self._sum_text(expression)
            case "product":
                sign = "-" if expression.value[0] < 0.0 else ""
                return sign + " * ".join(self._factor(factor) for factor in self.products[expression])
            case "function":
                self.functions.add(expression.value)
                return f"{expression.value}_of({', '.join(self._value(a) for a in arguments)})"
            case "choice":
                if is_magnitude(expression):
                    return f"wp::abs({self._value(arguments[2])})"
                condition, first, second = (self._value(argument) for argument in arguments)
                return f"{condition} ? {first} : {second}"
            case "comparison":
                return f"{self._value(arguments[0])} {expression.value} {self._value(arguments[1])}"
            case "not":
                return f"!{self._value(arguments[0])}"
            case kind:
                # without branches: both sides are always evaluated
                return {"all": " & ", "any": " | "}[kind].join(self._value(a) for a in arguments)

    def _sum_text(self, expression: Expression) -> str:
        """Terms of varying and uniform expressions; what is uniform in it is one constant."""
        constant, coefficients = expression.value
        terms = list(zip(coefficients, expression.arguments, strict=True))
        graph: Graph = expression.graph
        uniform = graph.sum([(1.0, graph.number(constant)), *((c, a) for c, a in terms if a.uniform)])
        text = ""
        for coefficient, argument in sorted((t for t in terms if not t[1].uniform), key=lambda t: t[0] < 0.0):
            value = self._value(argument)
            if abs(coefficient) != 1.0:
                value = f"{self._literal(abs(coefficient))} * {value}"
            text += (" - " if coefficient < 0.0 else " + ") + value
        if not uniform.is_equal(0.0):
            text += f" + {self._value(uniform)}"
        return text.removeprefix(" + ").strip()


def _ordered(a: Factor, b: Factor) -> tuple[Factor, Factor]:
    return (a, b) if _key(a) <= _key(b) else (b, a)


def _key(factor: Factor) -> tuple[str, int]:
    return factor[0], factor[1].serial if isinstance(factor[1], Expression) else factor[1]


def varying_in_order(outputs: Iterable[Expression]) -> list[Expression]:
    """All that is not uniform in the outputs: each just before it is needed, arguments first."""
    found: dict[Expression, None] = {}
    todo = [(output, False) for output in reversed(list(outputs))]
    while todo:
        expression, ready = todo.pop()
        if expression.uniform or expression in found:
            continue
        if ready:
            found[expression] = None
        else:
            todo.append((expression, True))
            needed = expression.arguments[2:] if is_magnitude(expression) else expression.arguments
            todo += [(argument, False) for argument in reversed(needed)]
    return list(found)


def is_magnitude(expression: Expression) -> bool:
    """Whether it is a choice that ``Graph.magnitude`` makes: a function of its own needs one instruction, not three."""
    if expression.kind != "choice":
        return False
    condition, first, second = expression.arguments
    below = condition.kind == "comparison" and condition.value == "<" and condition.arguments[0] is second
    return below and condition.arguments[1].is_equal(0.0) and first is -second


def over_lanes(lines: Iterable[str], lanes: int) -> list[str]:
    """A loop over the lanes, which the compiler turns into vector instructions."""
    return [
        # all lanes of a block side by side: one half alone waits for its own results
        *(["#pragma clang loop vectorize(enable) interleave_count(2)"] if lanes > 1 else []),
        f"for (int i = 0; i < {lanes}; ++i) {{",
        *(f"    {line}" for line in lines),
        "}",
    ]


def assignments(
    outputs: Mapping[str, Expression], constants: Constants, read: Mapping[str, str], real: str
) -> tuple[list[str], set[str]]:
    """Lines that compute all outputs, then write each where its name says; and the functions that they call."""
    writer = Writer(constants, real, read)
    lines = writer.write(list(outputs.values()))
    written = [f"{place} = {text};" for place, text in zip(outputs, writer.texts, strict=True)]
    return [*lines, *written], writer.functions


def lane_loop(
    outputs: Sequence[Expression], constants: Constants, read: Mapping[str, str], lanes: int, real: str
) -> str:
    """C++ of a function that returns a matrix with one row of lanes per output; parameters are in ``p.constants``."""
    places = {f"result.data[{row}][i]": output for row, output in enumerate(outputs)}
    lines, functions = assignments(places, constants, read, real)
    kind = f"wp::mat_t<{len(outputs)}, {lanes}, {'wp::float64' if real == 'double' else 'wp::float32'}>"
    return "\n".join([*definitions(functions, real), f"{kind} result;", *over_lanes(lines, lanes), "return result;"])
