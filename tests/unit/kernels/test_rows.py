"""Rows of the shared arrays: numbered without gaps, known to kernels, and never written as numbers."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import warp as wp

from weavesim.kernels import pass_entries, rows
from weavesim.kernels.rows import CornerRow, MotionRow, Rows, SlipRow

KERNELS = Path(rows.__file__).parent
ARRAYS = Rows.__subclasses__()
assert pass_entries.PassEntry in ARRAYS


@pytest.mark.parametrize("array", ARRAYS)
def test_members_take_all_rows_in_order(array):
    taken = [row for member in array for row in range(member.span.start, member.span.stop)]
    assert taken == list(range(array.row_count()))


@pytest.mark.parametrize("array", ARRAYS)
def test_every_member_has_a_unit_and_a_description(array):
    assert all(member.unit and member.description for member in array)


def test_vectors_of_the_motion_are_numbered():
    names = list(rows.MOTION_VECTORS)
    assert [MotionRow[name].vector for name in names[:-1]] == [0, 1, 2, 3, 4]
    assert names[rows.VELOCITY_REMAINDER] == "velocity_remainder"


def test_vectors_of_the_motion_have_all_rows_but_that_of_the_mean_angle():
    taken = sorted(row for vector in rows.MOTION_VECTORS.values() for row in vector)
    assert taken == [row for row in range(MotionRow.row_count()) if row != MotionRow.mean_angle]


@pytest.mark.parametrize(
    ("array", "length"), [(MotionRow, rows.MOTION_RECORD_LENGTH), (CornerRow, rows.ROWS_PER_CORNER)]
)
def test_a_record_is_made_of_pieces_of_four(array, length):
    """A vector and a scalar: so no piece lies across two lines of the cache."""
    assert length % 4 == 0
    assert [row % 4 for row in array if row < length] == [0, 3] * (length // 4)
    assert rows.MOTION_RECORD_LENGTH == 16 and rows.CORNER_ROW_COUNT == 4 * rows.ROWS_PER_CORNER


def test_array_indexed_by_a_member():
    corner = np.arange(CornerRow.row_count())
    assert corner[CornerRow.angle] == 7
    assert corner[CornerRow.couple.span].tolist() == [4, 5, 6]


@wp.kernel(module="unique", enable_backward=False)
def mark_spin(values: wp.array2d(dtype=wp.float32)):
    values[MotionRow.spin, 0] = 1.0
    values[MotionRow.spin + SlipRow.weft_bending_slip, 1] = 2.0


def test_kernel_indexes_by_a_member():
    values = wp.zeros((MotionRow.row_count(), 2), dtype=wp.float32, device="cpu")
    wp.launch(mark_spin, dim=1, outputs=[values], device="cpu")
    wanted = np.zeros((MotionRow.row_count(), 2))
    wanted[16, 0], wanted[18, 1] = 1.0, 2.0
    assert np.array_equal(values.numpy(), wanted)


def test_rows_are_known_without_warp():
    code = "import sys, weavesim.kernels.rows; sys.exit('warp' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=KERNELS.parent).returncode == 0


def own_matrices(function: ast.AST) -> set[str]:
    """Names that a function gives to what a call returned: they are matrices of its own, not shared arrays."""
    return {
        target.id
        for node in ast.walk(function)
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call)
        for target in node.targets
        if isinstance(target, ast.Name)
    }


def literal_rows(source: str) -> list[str]:
    """Entries of arrays with a number for their row, as in ``energies[5, e]`` or ``energies[count + 5, e]``."""

    def numbered(index: ast.expr) -> bool:
        if isinstance(index, ast.BinOp) and isinstance(index.op, ast.Add):
            return numbered(index.left) or numbered(index.right)
        return isinstance(index, ast.Constant) and isinstance(index.value, int)

    def found(scope: ast.AST, own: set[str]) -> Iterator[str]:
        for node in ast.iter_child_nodes(scope):
            yield from found(node, own_matrices(node) if isinstance(node, ast.FunctionDef) else own)
            entry = isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Tuple)
            if entry and numbered(node.slice.elts[0]) and ast.unparse(node.value) not in own:
                yield ast.unparse(node)

    return list(found(ast.parse(source), set()))


@pytest.mark.parametrize("room", ["cell", "laws", "shell", "stepping"])
def test_no_row_is_a_literal(room):
    found = {file.name: literal_rows(file.read_text()) for file in (KERNELS / room).glob("*.py")}
    assert found and {name: literals for name, literals in found.items() if literals} == {}


def test_literal_row_is_found():
    assert literal_rows("energies[part_count + 5, e] = fields[7, e]") == ["energies[part_count + 5, e]", "fields[7, e]"]


def test_matrix_of_a_function_is_no_shared_array():
    lines = (
        "c = wp.matrix(shape=(3, 3), dtype=real)",
        "fields = report.fields",
        "return c[0, 1] + fields[2, e] + q[1, e]",
    )
    assert literal_rows("def f(q, report, e):\n    " + "\n    ".join(lines)) == ["fields[2, e]", "q[1, e]"]
