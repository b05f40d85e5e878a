"""Formulas from the source of Warp functions.

``read`` follows a function as Warp compiles it: one statement after the other, loops of known length unrolled, and
functions that it calls as part of it. Where a condition depends on the state, both sides are followed and one is
chosen. What cannot be followed is ``Unreadable``, with the line and the reason.
"""

import ast
import inspect
from collections.abc import Sequence
from typing import Any

import warp as wp

from .builtins import Vector
from .graph import Expression, Graph
from .values import Unreadable, Values, known_names

# Statements that a function may have once its loops are unrolled.
LARGEST_STATEMENT_COUNT = 4000
DEEPEST_CALL = 20


def read(graph: Graph, function: wp.Function, arguments: Sequence[Any]) -> Any:
    """What ``function`` returns for expressions, vectors and parameters as arguments.

    Raises:
        Unreadable: if it cannot be read as a formula.
    """
    reader = Reader(graph)
    try:
        return reader.call(function, list(arguments), {})
    except Unreadable:
        raise
    except (TypeError, ValueError, KeyError, IndexError, AttributeError, ArithmeticError, RecursionError) as error:
        raise Unreadable(f"{function.key}, line {reader.line}: {type(error).__name__}: {error}") from error


class Reader:
    """Follows one function and those that it calls."""

    def __init__(self, graph: Graph):
        self.graph = graph
        self.line = 0
        self.statement_count = 0
        self.depth = 0

    def call(self, function: wp.Function, arguments: list[Any], named: dict[str, Any]) -> Any:
        """What a function returns for these arguments: an expression, or a vector of them.

        Raises:
            Unreadable: it does what cannot be followed, is too long, or calls too deeply.
        """
        source = function.func
        overloads = (*function.user_overloads.values(), *function.user_templates.values())
        if source is None or function.native_snippet is not None or len({one.func for one in overloads}) > 1:
            raise self.refusal(f"{function.key} has no single source in Python")
        if function.custom_grad_func is not None:
            raise self.refusal(f"{function.key} has a derivative of its own")
        self.depth += 1
        if self.depth > DEEPEST_CALL:
            raise self.refusal("functions call each other too deeply")
        names = list(inspect.signature(source).parameters)
        local = dict(zip(names, arguments, strict=False)) | named
        missing = [name for name in names if name not in local]
        for name in missing:
            local[name] = inspect.signature(source).parameters[name].default
        if len(arguments) > len(names) or any(local[name] is inspect.Parameter.empty for name in missing):
            raise self.refusal(f"{function.key} is called with {len(arguments)} arguments")
        (definition,) = function.adj.tree.body
        frame = Frame(self, local, known_names(source), getattr(function.adj, "fun_lineno", 1) - 1)
        result = frame.run(definition.body)
        self.depth -= 1
        if result is None:
            raise self.refusal(f"{function.key} returns nothing")
        return result

    def refusal(self, reason: str) -> Unreadable:
        """An error with the line that is followed."""
        return Unreadable(f"line {self.line}: {reason}")


class Frame(Values):
    """Follows the statements of one call."""

    def __init__(self, reader: Reader, local: dict[str, Any], around: dict[str, Any], first_line: int):
        super().__init__(reader, local, around)
        self.first_line = first_line

    def run(self, statements: Sequence[ast.stmt]) -> Any:
        """Returned value, or None if the end is reached."""
        for k, statement in enumerate(statements):
            self.reader.line = self.first_line + statement.lineno
            self.reader.statement_count += 1
            if self.reader.statement_count > LARGEST_STATEMENT_COUNT:
                raise self.reader.refusal("the function is too long")
            match statement:
                case ast.Return(value=value):
                    if value is None:
                        raise self.reader.refusal("it returns nothing")
                    return self.value(value)
                case ast.If():
                    done, result = self.branch(statement, statements[k + 1 :])
                    if done:
                        return result
                case ast.For():
                    result = self.loop(statement)
                    if result is not None:
                        return result
                case _:
                    self.simple(statement)
        return None

    def simple(self, statement: ast.stmt) -> None:
        """Follow an assignment, or a line that does nothing."""
        match statement:
            case ast.Assign(targets=[target], value=value):
                self.assign(target, self.value(value))
            case ast.AnnAssign(target=target, value=value) if value is not None:
                self.assign(target, self.value(value))
            case ast.AugAssign(target=target, op=op, value=value):
                now = self.value(ast.copy_location(ast_as_value(target), target))
                self.assign(target, self.operation(op, now, self.value(value)))
            case ast.Pass() | ast.Expr(value=ast.Constant()):
                pass
            case _:
                raise self.reader.refusal(f"the statement {ast.unparse(statement)!r} is not followed")

    def assign(self, target: ast.expr, value: Any) -> None:
        """Keep a value under a name, as a component of a vector, or a tuple under several names."""
        match target:
            case ast.Name(id=name):
                self.local[name] = value
            case ast.Tuple(elts=targets):
                for one, part in zip(targets, value, strict=True):
                    self.assign(one, part)
            case ast.Subscript(value=ast.Name(id=name), slice=place):
                components = list(self.local[name])
                components[self.whole(self.value(place))] = self.scalar(value)
                self.local[name] = Vector(components)
            case _:
                raise self.reader.refusal(f"the assignment to {ast.unparse(target)!r} is not followed")

    def branch(self, statement: ast.If, rest: Sequence[ast.stmt]) -> tuple[bool, Any]:
        """(whether the function ends here, what it returns)."""
        condition = self.condition(self.value(statement.test))
        if not isinstance(condition, Expression):
            result = self.run(statement.body if condition else statement.orelse)
            return result is not None, result
        before = dict(self.local)
        returns = any(isinstance(node, ast.Return) for node in ast.walk(statement))
        results, locals_after = [], []
        for side in (statement.body, statement.orelse):
            self.local = dict(before)
            # with a return on either side, what follows belongs to both
            results.append(self.run([*side, *(rest if returns else ())]))
            locals_after.append(self.local)
        if returns:
            if results[0] is None or results[1] is None:
                raise self.reader.refusal("only one side of a condition returns a value")
            return True, self.chosen(condition, results[0], results[1])
        common = [name for name in locals_after[0] if name in locals_after[1]]
        self.local = {name: self.chosen(condition, locals_after[0][name], locals_after[1][name]) for name in common}
        return False, None

    def loop(self, statement: ast.For) -> Any:
        """What the function returns within a loop over a range of known length; None if it goes on."""
        over = self.value(statement.iter)
        if not isinstance(over, range) or statement.orelse:
            raise self.reader.refusal("a loop is followed only over a range of known length")
        for number in over:
            self.assign(statement.target, number)
            result = self.run(statement.body)
            if result is not None:
                return result
        return None


def ast_as_value(target: ast.expr) -> ast.expr:
    """The target of an assignment as an expression that reads it."""
    return ast.parse(ast.unparse(target), mode="eval").body
