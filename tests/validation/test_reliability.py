"""docs/reliability.md has a row for every kind of fault that testing found, and every row names tests that exist."""

import ast
import re
from functools import cache

import pytest

from tests.support.paths import ROOT

PAGE = (ROOT / "docs" / "reliability.md").read_text(encoding="utf-8")
ROWS = {
    cells[1]: cells
    for line in PAGE.splitlines()
    if re.fullmatch(r"[A-D]\d+", (cells := [cell.strip() for cell in line.split("|")])[1:2] and cells[1] or "")
}
KINDS = (
    [f"A{k}" for k in range(1, 21)]
    + [f"B{k}" for k in range(1, 11)]
    + [f"C{k}" for k in range(1, 13)]
    + ["D1", "D2", "D3"]
)


@cache
def functions_of(path: str) -> frozenset[str]:
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    return frozenset(
        node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    )


def test_every_kind_has_its_row():
    assert list(ROWS) == KINDS


@pytest.mark.parametrize("kind", KINDS)
def test_every_row_says_what_and_is_held(kind):
    _, _, seen, cause, answer, held_by, _ = ROWS[kind]
    assert all(len(text) > 15 for text in (seen, cause, answer))
    tests = re.findall(r"`(tests/[\w/]+\.py)(?:::(\w+))?`", held_by)
    assert tests and len(tests) == held_by.count("`") // 2
    for path, name in tests:
        assert functions_of(path)
        assert not name or name in functions_of(path), f"{path}::{name}"
