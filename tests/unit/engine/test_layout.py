"""Rows of numbers in memory: what is written comes back, and one block of lanes lies together."""

import numpy as np
import pytest
import warp as wp

from weavesim.engine.layout import BLOCK, LINE, RowLayout, lanes_view, padded, rows_together, slots_of_nodes

ROWS, LENGTH = 5, 48


@pytest.mark.parametrize(
    ("count", "spare", "expected"), [(16, 0, 16), (16, 1, 32), (1, 0, 16), (31, 1, 32), (31, 4, 48), (0, 0, 0)]
)
def test_padding_fills_whole_blocks(count, spare, expected):
    assert padded(count, spare) == expected
    assert padded(count, spare) % BLOCK == 0


def numbers() -> np.ndarray:
    return np.arange(ROWS * LENGTH, dtype=np.float64).reshape(ROWS, LENGTH)


@pytest.mark.parametrize("record_length", [0, 4, ROWS])
@pytest.mark.parametrize("lane_count", [1, 16])
def test_rows_come_back_as_they_were(lane_count, record_length):
    layout = RowLayout(ROWS, LENGTH, lane_count, record_length)
    flat = layout.flat(numbers())
    assert np.array_equal(layout.read(wp.array(flat, dtype=wp.float64, device="cpu")), numbers())
    row, item = np.indices((ROWS, LENGTH))
    assert np.array_equal(flat[layout.entry(row, item)], numbers())
    assert sorted(layout.entry(row, item).ravel()) == list(range(ROWS * LENGTH))


def test_single_lanes_lie_in_rows_and_wide_ones_in_blocks():
    assert RowLayout(ROWS, LENGTH, 1).entry(2, 7) == 2 * LENGTH + 7
    assert RowLayout(ROWS, LENGTH, 1).stride == LENGTH
    # item 20 is lane 4 of block 1, behind all five rows of block 0
    assert RowLayout(ROWS, LENGTH, 16).entry(2, 20) == (5 + 2) * 16 + 4
    assert RowLayout(ROWS, LENGTH, 16).stride == 16


def test_records_lie_side_by_side_before_the_other_rows_of_their_block():
    layout = RowLayout(ROWS, LENGTH, 16, 4)
    # item 20 is lane 4 of block 1, behind all five rows of block 0
    assert layout.entry(2, 20) == 5 * 16 + 4 * 4 + 2
    assert layout.entry(4, 20) == 5 * 16 + 4 * 16 + 4
    assert layout.stride == 1
    # single lanes have whole rows
    assert RowLayout(ROWS, LENGTH, 1, 4).entry(2, 7) == 2 * LENGTH + 7
    assert RowLayout(ROWS, LENGTH, 1, 4).stride == LENGTH


@pytest.mark.parametrize("lane_count", [1, 16])
def test_a_view_shows_the_same_memory(lane_count):
    layout = RowLayout(ROWS, LENGTH, lane_count)
    entries = wp.array(layout.flat(numbers()), dtype=wp.float64, device="cpu")
    view = layout.view(entries)
    assert view.shape == (ROWS, LENGTH // lane_count)
    assert np.array_equal(view.numpy().reshape(ROWS, LENGTH), numbers())
    entries.fill_(3.0)
    assert (view.numpy() == 3.0).all()


def test_lanes_are_seen_in_an_array_of_numbers():
    array = wp.array(numbers(), dtype=wp.float64, device="cpu")
    view = lanes_view(array, 16)
    assert view.shape == (ROWS, LENGTH // 16)
    assert np.array_equal(view.numpy().reshape(ROWS, LENGTH), numbers())


def test_slots_count_the_entries_of_every_node():
    order, slot = slots_of_nodes(np.array([2, 0, 2, 5, 0, 2]))
    assert order.tolist() == [1, 4, 0, 2, 5, 3]
    assert slot.tolist() == [0, 1, 0, 1, 2, 0]


def test_rows_of_a_block_lie_together_in_lines_of_their_own():
    count = 3 * BLOCK
    numbers = np.arange(2.0 * count).reshape(2, count)
    arrays = {
        "entry": wp.array(np.arange(4 * count).reshape(4, count), dtype=wp.int32, device="cpu"),
        "pair": wp.array(numbers, dtype=wp.float64, device="cpu"),
        "single": wp.array(-numbers[1], dtype=wp.float64, device="cpu"),
    }
    views = rows_together(arrays, BLOCK)
    for name, array in arrays.items():
        expected = lanes_view(array, BLOCK)
        assert views[name].dtype == expected.dtype
        assert np.array_equal(views[name].numpy(), expected.numpy())
    # four rows of 64 bytes, then three of 128
    assert {view.strides[-1] for view in views.values()} == {4 * 64 + 3 * 128}
    assert views["pair"].ptr - views["entry"].ptr == 4 * 64
    assert views["single"].ptr - views["pair"].ptr == 2 * 128
    assert views["entry"].ptr % LINE == 0
