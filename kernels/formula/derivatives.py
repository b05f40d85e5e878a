"""Exact derivatives of formulas, by the rules of differentiation along one variable (forward mode).

The choice of a member is made last: what a branch that is not taken would divide by never matters.
"""

from collections.abc import Iterable

from .graph import Expression, in_order


class Derivatives:
    """Derivatives with respect to one symbol; what several expressions share is differentiated once."""

    def __init__(self, variable: Expression):
        self.variable = variable
        self.known: dict[Expression, Expression] = {}

    def __call__(self, expression: Expression) -> Expression:
        zero = expression.graph.number(0.0)
        for part in in_order([expression]):
            if part not in self.known:
                moved = [self.known.get(argument, zero) for argument in part.arguments]
                self.known[part] = self._derivative(part, moved)
        return self.known[expression]

    def _derivative(self, part: Expression, moved: list[Expression]) -> Expression:
        graph = part.graph
        if part is self.variable:
            return graph.number(1.0)
        if part.uniform or part.kind in ("symbol", "comparison", "all", "any", "not"):
            return graph.number(0.0)
        if part.kind == "sum":
            return graph.sum(zip(part.value[1], moved, strict=True))
        if part.kind == "product":
            return graph.sum(_product_terms(part, moved))
        if part.kind == "choice":
            return graph.choice(part.arguments[0], moved[1], moved[2])
        return graph.sum(
            (1.0, by_argument * change)
            for by_argument, change in zip(partial_derivatives(part), moved, strict=True)
            if not change.is_equal(0.0)
        )


def _product_terms(part: Expression, moved: list[Expression]) -> Iterable[tuple[float, Expression]]:
    coefficient, exponents = part.value
    powers = list(zip(part.arguments, exponents, strict=True))
    for k, ((base, exponent), change) in enumerate(zip(powers, moved, strict=True)):
        if not change.is_equal(0.0):
            others = powers[:k] + powers[k + 1 :]
            yield 1.0, part.graph.product([(change, 1), (base, exponent - 1), *others], coefficient * exponent)


def partial_derivatives(part: Expression) -> list[Expression]:
    """Of a function by its arguments."""
    graph, name, arguments = part.graph, part.value, part.arguments
    one, x = graph.number(1.0), arguments[0]
    if name == "atan2":
        y, x = arguments
        squared = x * x + y * y
        # at the origin, where there is no derivative, zero, as Warp has it
        inverse = graph.choice(graph.comparison(">", squared, graph.number(0.0)), one / squared, graph.number(0.0))
        return [x * inverse, -(y * inverse)]
    if name == "pow":
        base, exponent = arguments
        by_base = exponent * graph.power(base, exponent - 1.0)
        return [by_base, part * graph.function("log", base) if not exponent.uniform else graph.number(0.0)]
    rules = {
        "sqrt": lambda: 0.5 / part,
        "cbrt": lambda: one / (3.0 * part * part),
        "exp": lambda: part,
        "log": lambda: one / x,
        "sin": lambda: graph.function("cos", x),
        "cos": lambda: -graph.function("sin", x),
        "tan": lambda: one + part * part,
        "asin": lambda: one / graph.function("sqrt", one - x * x),
        "acos": lambda: -one / graph.function("sqrt", one - x * x),
        "atan": lambda: one / (one + x * x),
        "sinh": lambda: graph.function("cosh", x),
        "cosh": lambda: graph.function("sinh", x),
        "tanh": lambda: one - part * part,
        "floor": lambda: graph.number(0.0),
        "ceil": lambda: graph.number(0.0),
    }
    return [rules[name]()]
