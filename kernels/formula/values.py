"""Values of the expressions of a Warp function, as formulas."""

import ast
import builtins
import inspect
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import warp as wp

from .builtins import BUILTINS, Vector, as_number, is_vector_type
from .graph import Expression

OPERATORS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
}
COMPARISON_NAMES: dict[type, str] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
CONDITIONS = ("comparison", "all", "any", "not")


class Unreadable(Exception):
    """A function that cannot be read as a formula; says where and why."""


class Parameters:
    """The struct of a cell's parameters: numbers and vectors by name."""

    def __init__(self, members: dict[str, Any]):
        self.members = members


def known_names(source: Callable[..., Any]) -> dict[str, Any]:
    """What a function sees around it: built-in names, its module, and what encloses it."""
    enclosing = {}
    for name, cell in zip(source.__code__.co_freevars, source.__closure__ or (), strict=True):
        enclosing[name] = cell.cell_contents
    return vars(builtins) | source.__globals__ | enclosing


class Values:
    """Evaluates expressions; ``reader`` follows the functions that they call and knows the line."""

    def __init__(self, reader: Any, local: dict[str, Any], around: dict[str, Any]):
        self.reader, self.graph = reader, reader.graph
        self.local, self.around = local, around

    def value(self, node: ast.expr) -> Any:
        """Value of an expression of the source: a number, an expression of the graph, a vector, a function, a module.

        Raises:
            Unreadable: it is not followed.
        """
        match node:
            case ast.Constant(value=value) if isinstance(value, (bool, int, float)):
                return value
            case ast.Name(id=name):
                return self.named(name)
            case ast.Attribute():
                return self.attribute(node)
            case ast.Subscript(value=vector, slice=place):
                return self.component(self.value(vector), self.value(place))
            case ast.BinOp(left=left, op=op, right=right):
                return self.operation(op, self.value(left), self.value(right))
            case ast.UnaryOp(op=op, operand=operand):
                return self.signed(op, self.value(operand))
            case ast.Compare(left=left, ops=operations, comparators=rights):
                return self.comparison(left, operations, rights)
            case ast.BoolOp(op=op, values=values):
                name = "all" if isinstance(op, ast.And) else "any"
                return self.graph.combination(name, [self.condition(self.value(one)) for one in values])
            case ast.IfExp(test=test, body=body, orelse=other):
                condition = self.condition(self.value(test))
                if not isinstance(condition, Expression):
                    return self.value(body if condition else other)
                return self.chosen(condition, self.value(body), self.value(other))
            case ast.Tuple(elts=elements):
                return tuple(self.value(one) for one in elements)
            case ast.Call():
                return self.called(node)
        raise self.reader.refusal(f"{ast.unparse(node)!r} is not followed")

    def named(self, name: str) -> Any:
        """What a name stands for."""
        if name in self.local:
            return self.local[name]
        if name in self.around:
            return as_number(self.around[name])
        raise self.reader.refusal(f"{name!r} is not known here")

    def attribute(self, node: ast.Attribute) -> Any:
        """A parameter of the cell, a component of a vector, or what a module has under a name."""
        owner = self.value(node.value)
        if isinstance(owner, Parameters):
            if node.attr not in owner.members:
                raise self.reader.refusal(f"there is no parameter {node.attr!r}")
            return owner.members[node.attr]
        if isinstance(owner, Vector) and node.attr in ("x", "y", "z", "w"):
            return owner["xyzw".index(node.attr)]
        if inspect.ismodule(owner):
            return as_number(getattr(owner, node.attr))
        raise self.reader.refusal(f"{ast.unparse(node)!r} is not followed")

    def component(self, vector: Any, place: Any) -> Any:
        """A component of a vector, by its place."""
        if not isinstance(vector, tuple):
            raise self.reader.refusal("only vectors have components")
        return vector[self.whole(place)]

    def chosen(self, condition: Expression, first: Any, second: Any) -> Any:
        """``first`` where the condition holds, else ``second``; numbers, or vectors of the same length."""
        if first is second or (isinstance(first, (int, float)) and type(first) is type(second) and first == second):
            return first
        if isinstance(first, tuple) and isinstance(second, tuple):
            return type(first)(self.chosen(condition, a, b) for a, b in zip(first, second, strict=True))
        return self.graph.choice(condition, self.scalar(first), self.scalar(second))

    # --- operators ----------------------------------------------------------------------------------------------------

    def signed(self, op: ast.unaryop, value: Any) -> Any:
        """Opposite of a value, or of a condition."""
        if isinstance(op, ast.Not):
            return self.graph.negation(self.condition(value))
        if isinstance(op, ast.USub) and (isinstance(value, Vector) or not isinstance(value, tuple)):
            return -value
        if isinstance(op, ast.UAdd):
            return value
        raise self.reader.refusal(f"the operator {type(op).__name__} is not followed")

    def operation(self, op: ast.operator, a: Any, b: Any) -> Any:
        """Of two numbers, expressions or vectors."""
        if isinstance(a, tuple) or isinstance(b, tuple):
            return self.of_vectors(op, a, b)
        if not isinstance(a, Expression) and not isinstance(b, Expression):
            return self.of_numbers(op, a, b)
        first, second = self.scalar(a), self.scalar(b)
        if isinstance(op, ast.Pow):
            return self.graph.power(first, second)
        if type(op) not in OPERATORS:
            raise self.reader.refusal(f"the operator {type(op).__name__} is not followed")
        return OPERATORS[type(op)](first, second)

    def of_vectors(self, op: ast.operator, a: Any, b: Any) -> Any:
        """Sums of vectors, and products with a scalar."""
        if isinstance(a, Vector) and isinstance(b, Vector) and isinstance(op, (ast.Add, ast.Sub)):
            return Vector(self.operation(op, x, y) for x, y in zip(a, b, strict=True))
        if isinstance(a, Vector) and not isinstance(b, tuple) and isinstance(op, (ast.Mult, ast.Div)):
            return Vector(self.operation(op, x, b) for x in a)
        if isinstance(b, Vector) and not isinstance(a, tuple) and isinstance(op, ast.Mult):
            return Vector(self.operation(op, a, x) for x in b)
        raise self.reader.refusal(f"the operator {type(op).__name__} of vectors is not followed")

    def of_numbers(self, op: ast.operator, a: Any, b: Any) -> Any:
        """Of two numbers that are known: whole ones stay whole, as in Warp."""
        if not isinstance(a, (int, float)) or not isinstance(b, (int, float)):
            raise self.reader.refusal("numbers are needed")
        whole = isinstance(a, int) and isinstance(b, int)
        if isinstance(op, (ast.Add, ast.Sub, ast.Mult)):
            return OPERATORS[type(op)](a, b)
        if not whole and isinstance(op, (ast.Div, ast.Pow)):
            return self.operation(op, self.graph.wrap(a), b)
        # where signs differ, Python and C++ do not agree
        if whole and a >= 0 and b > 0 and isinstance(op, (ast.Div, ast.FloorDiv)):
            return a // b
        if whole and a >= 0 and b > 0 and isinstance(op, ast.Mod):
            return a % b
        raise self.reader.refusal(f"the operator {type(op).__name__} of {a} and {b} is not followed")

    def comparison(self, left: ast.expr, operations: Sequence[ast.cmpop], rights: Sequence[ast.expr]) -> Any:
        """Whether all comparisons of a chain hold."""
        values = [self.scalar(self.value(one)) for one in (left, *rights)]
        if any(type(operation) not in COMPARISON_NAMES for operation in operations):
            raise self.reader.refusal("this comparison is not followed")
        pairs = zip(operations, values[:-1], values[1:], strict=True)
        return self.graph.combination(
            "all", [self.graph.comparison(COMPARISON_NAMES[type(operation)], a, b) for operation, a, b in pairs]
        )

    # --- calls --------------------------------------------------------------------------------------------------------

    def called(self, node: ast.Call) -> Any:
        """What a call returns; functions of the user are followed."""
        function = self.value(node.func)
        if any(isinstance(argument, ast.Starred) for argument in node.args):
            raise self.reader.refusal("a list of arguments is not followed")
        if function is wp.static:
            # code that Warp runs while it compiles
            return as_number(eval(ast.unparse(node.args[0]), dict(self.around), dict(self.local)))
        arguments = [self.value(argument) for argument in node.args]
        named = {one.arg: self.value(one.value) for one in node.keywords if one.arg is not None}
        if isinstance(function, wp.Function) and not function.is_builtin():
            line = self.reader.line
            result = self.reader.call(function, arguments, named)
            self.reader.line = line
            return result
        if function is range:
            return range(*(self.whole(argument) for argument in arguments))
        if function is len:
            return len(arguments[0])
        if is_vector_type(function) and not named:
            return self.vector(function, arguments)
        name = getattr(function, "key", None) or getattr(function, "__name__", str(function))
        if name not in BUILTINS or named:
            raise self.reader.refusal(f"{ast.unparse(node.func)} is not followed")
        return BUILTINS[name](self, *arguments)

    def vector(self, kind: Any, arguments: list[Any]) -> Vector:
        """A vector of a kind from its components, from another one, or from one value for all."""
        if len(arguments) == 1 and isinstance(arguments[0], tuple):
            arguments = list(arguments[0])
        elif len(arguments) <= 1:
            arguments = (arguments or [0.0]) * kind._length_
        if len(arguments) != kind._length_:
            raise self.reader.refusal(f"{kind._length_} components are needed, {len(arguments)} given")
        return Vector(self.scalar(argument) for argument in arguments)

    # --- kinds of values ----------------------------------------------------------------------------------------------

    def scalar(self, value: Any) -> Expression:
        """A number or an expression as an expression."""
        if isinstance(value, (Expression, bool, int, float)):
            return self.graph.wrap(value)
        raise self.reader.refusal("a number is needed")

    def condition(self, value: Any) -> Expression | bool:
        """A value as a condition: what is not zero holds."""
        if isinstance(value, Expression) and value.kind not in CONDITIONS:
            return self.graph.comparison("!=", value, self.graph.number(0.0))
        if isinstance(value, (Expression, bool)):
            return value
        if isinstance(value, (int, float)):
            return value != 0
        raise self.reader.refusal("a condition is needed")

    def whole(self, value: Any) -> int:
        """A whole number that is known."""
        if isinstance(value, Expression) and value.is_number and float(value.value).is_integer():
            return int(value.value)
        if isinstance(value, int):
            return value
        raise self.reader.refusal("a whole number that is known is needed")

    def scalars(self, vector: Any) -> Iterator[Expression]:
        """The components of a vector as expressions."""
        if not isinstance(vector, tuple):
            raise self.reader.refusal("a vector is needed")
        return (self.scalar(component) for component in vector)
