"""What is fetched ahead: as many lines of the cache as it has, and no effect on any value."""

import platform
import sys

import numpy as np
import pytest
import warp as wp

from scripts.benchmarks.compilation.instructions import instruction_names
from tests.support.lanes import scalars
from weavesim.engine.layout import LINE
from weavesim.kernels.fetching import expect_next
from weavesim.kernels.lane_types import CPU_LANE_COUNT, lane_types

ROW_COUNT, BLOCK_COUNT = 3, 4


@pytest.fixture
def types(precision):
    return lane_types(precision.real, CPU_LANE_COUNT)


def copying(types):
    """Kernel that copies rows, and numbers in one row, and asks for those of the next block."""
    lanes = types.lanes

    @wp.kernel(module="unique", enable_backward=False)
    def copy(
        rows: wp.array2d(dtype=lanes), one: wp.array(dtype=lanes), copied: wp.array2d(dtype=lanes)
    ):  # the last row is that of ``one``
        block = wp.tid()
        expect_next(rows, 0, wp.static(ROW_COUNT), block)
        expect_next(one, block)
        for row in range(wp.static(ROW_COUNT)):
            copied[row, block] = rows[row, block]
        copied[wp.static(ROW_COUNT), block] = one[block]

    return copy


def test_nothing_changes_and_nothing_fails_behind_the_last_block(types):
    values = np.random.default_rng(0).normal(size=(ROW_COUNT + 1, BLOCK_COUNT * CPU_LANE_COUNT))
    copied = scalars(types, np.zeros(values.shape))
    wp.launch(
        copying(types), dim=BLOCK_COUNT, inputs=[scalars(types, values[:-1]), scalars(types, values[-1])],
        outputs=[copied], device="cpu",
    )  # fmt: skip
    assert np.array_equal(copied.numpy().reshape(values.shape), values.astype(copied.numpy().dtype))


@pytest.mark.skipif(
    sys.platform != "linux" or platform.machine() != "x86_64", reason="objects for Linux on an x86 processor are read"
)
def test_every_line_is_asked_for_once(types, precision):
    names = instruction_names(copying(types))
    lines_per_row = CPU_LANE_COUNT * precision.numpy.itemsize // LINE
    assert sum(name.startswith("prefetch") for name in names) == (ROW_COUNT + 1) * lines_per_row
