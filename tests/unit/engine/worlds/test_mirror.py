"""Copies of the memory of runs, and structs that find them."""

import numpy as np
import pytest
import warp as wp

from weavesim.engine.worlds.mirror import Memory, Mirror, Unalike, array_offsets


@wp.struct
class Inner:
    values: wp.array(dtype=wp.float32)
    factor: wp.float32


@wp.struct
class Outer:
    first: wp.int32
    inner: Inner
    rows: wp.array2d(dtype=wp.float32)
    nothing: wp.array(dtype=wp.float64)


@wp.kernel(module="unique", enable_backward=False)
def scale_rows(worlds: wp.array(dtype=Outer)):
    a = worlds[wp.tid()]
    for i in range(a.rows.shape[1]):
        a.rows[1, i] = a.inner.factor * a.inner.values[i]


def array(values):
    return wp.array(np.asarray(values, dtype=np.float32), dtype=wp.float32, device="cpu")


def run(number, constant):
    """A written array (2, 3), a constant one (3,), and a struct of views of both."""
    rows = array(np.full((2, 3), number))
    inner, outer = Inner(), Outer()
    inner.values, inner.factor = constant, number + 1.0
    outer.inner, outer.rows = inner, rows
    return rows, constant, outer


@pytest.mark.parametrize("same", [True, False])
def test_structs_find_the_copies(same):
    runs = [run(number, array([1.0, 2.0, 3.0 if same else number])) for number in range(4)]
    mirror = Mirror(wp.get_device("cpu"), [[rows] for rows, _, _ in runs], [[constant] for _, constant, _ in runs])
    worlds = mirror.structs([outer for _, _, outer in runs])
    wp.launch(scale_rows, dim=4, inputs=[worlds], device="cpu")
    assert [rows.numpy().tolist() for rows, _, _ in runs] == [[[k] * 3] * 2 for k in range(4)]  # not on the host yet
    mirror.download([1, 3], [runs[0][0]])
    for number, (rows, constant, _) in enumerate(runs):
        changed = (number + 1.0) * constant.numpy() if number in (1, 3) else np.full(3, number)
        np.testing.assert_array_equal(rows.numpy(), [np.full(3, number), changed])


def test_what_is_the_same_everywhere_is_copied_once():
    shared, other = [array([1.0, 2.0]) for _ in range(3)], [array([number]) for number in range(3)]
    written = [array([1.0]) for _ in range(3)]
    constant = [list(pair) for pair in zip(shared, other, strict=True)]
    mirror = Mirror(wp.get_device("cpu"), [[each] for each in written], constant)
    assert [pool.shape[0] for pool in mirror._pools] == [3, 1, 3]


def test_rows_are_one_array_of_all_runs():
    written = [array(np.arange(6).reshape(2, 3) + 10 * number) for number in range(2)]
    mirror = Mirror(wp.get_device("cpu"), [[each] for each in written], [[], []])
    rows = mirror.rows(written, wp.float32, (2, 3))
    np.testing.assert_array_equal(rows.numpy(), [each.numpy() for each in written])
    assert rows.ptr == mirror._pools[0].ptr


def test_views_lie_within_their_arrays():
    whole = array(np.arange(8))
    memory = Memory([whole, whole[2:5]])
    assert memory.spans == [(whole.ptr, 32)]
    places, offsets = memory.find(np.array([whole[3:].ptr, whole.ptr + 32, 1], dtype=np.uint64))
    assert places.tolist() == [0, -1, -1] and offsets[0] == 12


def test_runs_of_other_sizes_are_refused():
    with pytest.raises(Unalike, match="number or size"):
        Mirror(wp.get_device("cpu"), [[array([1.0])], [array([1.0, 2.0])]], [[], []])


def test_an_array_that_nobody_knows_is_refused():
    runs = [run(number, array([1.0, 2.0, 3.0])) for number in range(2)]
    mirror = Mirror(wp.get_device("cpu"), [[rows] for rows, _, _ in runs], [[], []])
    with pytest.raises(Unalike, match="not known"):
        mirror.structs([outer for _, _, outer in runs])


def test_arrays_within_structs_are_found():
    assert len(list(array_offsets(Outer.ctype))) == 3
