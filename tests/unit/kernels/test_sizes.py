"""Kernels and device functions are short and take few arguments: one is read as a page of formulas, not as a listing.

Lines are those of the body, from the first statement after the docstring to the end: a signature is a list of
declarations. The same holds for functions of the host, but a factory may be longer: it holds the device functions that
it defines.
"""

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from weavesim.kernels import rows

KERNELS = Path(rows.__file__).parent
MOST_ARGUMENTS = 8
MOST_LINES = 40
MOST_LINES_OF_A_FACTORY = 150
DEVICE_DECORATORS = ("wp.kernel", "wp.func", "wp.func_native")
# Name and reason of every function that is longer or takes more, as "cell/yarn.py: yarn_forces", with the measured cost
# of staying below where a measurement forbids that. There is none.
EXCEPTIONS: dict[str, str] = {}


class Size(NamedTuple):
    """What is counted of a function."""

    lines: int
    arguments: int
    is_factory: bool

    @property
    def too_large(self) -> bool:
        most = MOST_LINES_OF_A_FACTORY if self.is_factory else MOST_LINES
        return self.lines > most or self.arguments > MOST_ARGUMENTS


def on_device(node: ast.AST) -> bool:
    """True for a kernel or a device function."""
    decorators = node.decorator_list if isinstance(node, ast.FunctionDef) else []
    called = [ast.unparse(each.func if isinstance(each, ast.Call) else each) for each in decorators]
    return any(name in DEVICE_DECORATORS for name in called)


def sizes(source: str) -> Iterator[tuple[str, Size]]:
    """Name and size of every function, those within others too."""
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.FunctionDef):
            continue
        is_factory = any(on_device(inner) for inner in ast.walk(node) if inner is not node)
        body = node.body[1:] if ast.get_docstring(node) is not None and len(node.body) > 1 else node.body
        given = node.args
        arguments = [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg, given.kwarg]
        lines = (node.end_lineno or 0) - body[0].lineno + 1
        yield node.name, Size(lines, len([each for each in arguments if each is not None]), is_factory)


def too_large() -> dict[str, Size]:
    """Every function of the kernels that is longer or takes more than allowed, by file and name."""
    return {
        f"{file.relative_to(KERNELS).as_posix()}: {name}": size
        for file in sorted(KERNELS.rglob("*.py"))
        for name, size in sizes(file.read_text(encoding="utf-8"))
        if size.too_large
    }


def test_functions_are_short_and_take_few_arguments():
    found = {name: size for name, size in too_large().items() if name not in EXCEPTIONS}
    assert found == {}, f"at most {MOST_LINES} lines and {MOST_ARGUMENTS} arguments, or an exception with its reason"


def test_no_exception_is_out_of_date():
    assert sorted(EXCEPTIONS.keys() - too_large().keys()) == []
    assert all(reason.strip() for reason in EXCEPTIONS.values())


def test_functions_of_every_kind_are_seen():
    found = [name for file in KERNELS.rglob("*.py") for name, _ in sizes(file.read_text(encoding="utf-8"))]
    assert {"element_forces", "node_motion", "tool_motion", "equilibrium", "wait_for_all", "energy_cell"} <= {*found}
    assert len(found) > 150


@pytest.mark.parametrize(
    ("body_lines", "argument_count", "large"), [(40, 8, False), (41, 8, True), (40, 9, True), (1, 0, False)]
)
def test_what_is_too_large_is_found(body_lines, argument_count, large):
    arguments = ",\n        ".join(f"a{k}: float" for k in range(argument_count))
    body = "\n        ".join(["x = 1"] * body_lines)
    device = f'    @wp.func\n    def inner(\n        {arguments}\n    ):\n        """A formula."""\n        {body}\n'
    found = dict(sizes(f"def factory():\n{device}\n    return inner\n"))
    assert found["inner"] == Size(body_lines, argument_count, False)
    assert found["inner"].too_large == large
    assert found["factory"].is_factory and not found["factory"].too_large
