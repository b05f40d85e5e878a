"""Formulas are compiled anew when a number in them changes: none is hidden from the hash of a kernel."""

import ast
from collections.abc import Iterator

from tests.support.paths import ROOT


def statics_of_loops(tree: ast.AST) -> Iterator[int]:
    """Lines with a ``wp.static(...)`` of the variable of a loop around it.

    Warp evaluates such an expression when it compiles, and does not hash its value.
    """
    for loop in ast.walk(tree):
        if isinstance(loop, ast.For):
            variables = {node.id for node in ast.walk(loop.target) if isinstance(node, ast.Name)}
            for node in ast.walk(loop):
                if not isinstance(node, ast.Call) or ast.unparse(node.func) != "wp.static":
                    continue
                if variables & {name.id for name in ast.walk(node) if isinstance(name, ast.Name)}:
                    yield node.lineno


def test_no_static_expression_depends_on_a_loop():
    found = {
        f"{path.relative_to(ROOT)}:{line}"
        for folder in ("kernels", "weavesim", "scenes")
        for path in (ROOT / folder).rglob("*.py")
        for line in statics_of_loops(ast.parse(path.read_text(encoding="utf-8")))
    }
    assert not found, "use a vector of Warp instead"


def test_such_expressions_are_found():
    text = "for k in range(3):\n    for j in range(2):\n        x = x + wp.static(table[n - k])\n    y = wp.static(n)"
    assert list(statics_of_loops(ast.parse(text))) == [3]
