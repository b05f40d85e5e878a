"""Records: sixteen lanes transpose them, single lanes read whole rows; both move bits, and only their own."""

import numpy as np
import pytest
import warp as wp

from weavesim.engine.layout import RowLayout
from weavesim.kernels.lane_types import ALL_LANE_TYPES, step_options
from weavesim.kernels.records import SCALAR, gather4, record3, record4, store_record3, store_record4, vector_of

ROWS, RECORD, LENGTH = 11, 8, 48


@pytest.fixture(params=ALL_LANE_TYPES, ids=lambda types: f"{types.real.__name__}-{types.lane_count}")
def types(request):
    return request.param


@pytest.fixture
def layout(types) -> RowLayout:
    return RowLayout(ROWS, LENGTH, types.lane_count, RECORD)


def numbers(types) -> np.ndarray:
    """Random bits that no arithmetic would keep: with NaN, infinity and subnormal numbers among them."""
    real = wp.dtype_to_numpy(types.real)
    values = np.random.default_rng(3).normal(size=(ROWS, LENGTH)).astype(real)
    values[1, 5], values[3, 6], values[4, 7] = np.nan, np.inf, np.finfo(real).smallest_subnormal
    return values


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    return a.shape == b.shape and a.tobytes() == b.tobytes()


def array(layout: RowLayout, types, values: np.ndarray) -> wp.array:
    return wp.array(layout.flat(values), dtype=types.real, device="cpu")


@pytest.mark.parametrize("row", [0, 4])
def test_gathered_pieces(types, layout, row):
    @wp.kernel(module="unique", enable_backward=False, module_options=step_options(types.real))
    def read(
        source: wp.array(dtype=types.real),
        index: wp.array(dtype=types.indices),
        row: int,
        stride: int,
        result: wp.array2d(dtype=types.lanes),
    ):
        block = wp.tid()
        piece = gather4(source, index[block], row * stride, stride)
        for i in range(4):
            result[i, block] = piece[i]

    values, items = numbers(types), np.random.default_rng(1).integers(LENGTH, size=LENGTH)
    items[:2] = 0, LENGTH - 1
    # the places of the items are any multiples: the array ends with its last record
    index = wp.array(
        layout.entry(0, items).astype(np.int32).reshape(-1, types.lane_count), dtype=types.indices, device="cpu"
    )
    result = wp.zeros((4, LENGTH // types.lane_count), dtype=types.lanes, device="cpu")
    source = array(layout, types, values)
    wp.launch(
        read,
        dim=result.shape[1],
        inputs=[source, index, row, layout.stride],
        outputs=[result],
        device="cpu",
    )
    assert same_bits(result.numpy().reshape(4, LENGTH), values[row : row + 4, items])


def test_own_records_come_back(types, layout):
    @wp.kernel(module="unique", enable_backward=False, module_options=step_options(types.real))
    def move(source: wp.array2d(dtype=types.lanes), target: wp.array2d(dtype=types.lanes)):
        block = wp.tid()
        piece = record4(source, RECORD, 4, block)
        store_record4(target, RECORD, 0, block, vector_of(piece), piece[SCALAR])
        store_record3(target, RECORD, 4, block, record3(source, RECORD, 0, block))

    values = numbers(types)
    before = np.full_like(values, 7.0)
    target = array(layout, types, before)
    wp.launch(
        move,
        dim=LENGTH // types.lane_count,
        inputs=[layout.view(array(layout, types, values))],
        outputs=[layout.view(target)],
        device="cpu",
    )
    found = layout.read(target)
    assert same_bits(found[:4], values[4:8])
    assert same_bits(found[4:7], values[:3])
    # beside the scalar behind the second vector, nothing else is touched
    assert same_bits(found[8:], before[8:])
