"""Kernels and device functions stay short enough to be read as one formula sheet each."""

import ast
from collections.abc import Iterator

from tests.support.imports import Sources
from tests.support.paths import ROOT

# About forty lines, without the docstring and the list of arguments.
LARGEST_BODY = 45
# A kernel's arguments are the arrays that it reads and writes, one by one.
LARGEST_ARGUMENT_COUNT = {"wp.func": 8, "wp.kernel": 10}
# Longer ones, each with the measurement that forbids to divide it; it stands beside the function too.
MEASURED: dict[str, str] = {}


def device_functions() -> Iterator[tuple[str, str, ast.FunctionDef]]:
    """Name with its module, decorator and tree of every kernel and device function."""
    for module, tree in Sources(ROOT).tree_of.items():
        for node in ast.walk(tree) if module.startswith("weavesim.kernels") else ():
            if isinstance(node, ast.FunctionDef):
                for decorator in node.decorator_list:
                    name = ast.unparse(decorator).partition("(")[0]
                    if name in LARGEST_ARGUMENT_COUNT:
                        yield f"{module}.{node.name}", name, node


def body_length(node: ast.FunctionDef) -> int:
    body = node.body[1:] if ast.get_docstring(node) is not None and len(node.body) > 1 else node.body
    return (node.end_lineno or 0) - body[0].lineno + 1


def test_device_functions_are_found():
    names = {name for name, _, _ in device_functions()}
    assert len(names) > 100
    assert "weavesim.kernels.shell.force.element_forces" in names


def test_no_kernel_or_device_function_is_long():
    long = {name for name, _, node in device_functions() if body_length(node) > LARGEST_BODY}
    assert long == set(MEASURED)


def test_no_kernel_or_device_function_has_many_arguments():
    many = {name: len(node.args.args) for name, kind, node in device_functions()
            if len(node.args.args) > LARGEST_ARGUMENT_COUNT[kind]}  # fmt: skip
    assert many == {}
