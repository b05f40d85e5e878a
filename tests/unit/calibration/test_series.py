"""Rows in the order of time, offsets, thinning."""

import numpy as np
import pytest

from weavesim.calibration.series import (
    Series,
    first_reversal,
    in_order,
    noise_of,
    thinned,
    turns,
    without_offset,
)
from weavesim.errors import InputError


def series(x, y=None):
    x = np.asarray(x, dtype=float)
    y = x**2 if y is None else np.asarray(y, dtype=float)
    return Series("test.csv", "", x, y, np.arange(2, len(x) + 2), ("angle", "force"))


def test_rows_in_no_order_are_sorted_and_that_is_said():
    x = np.random.default_rng(0).permutation(np.linspace(0.0, 1.0, 30))
    found = in_order(series(x))
    np.testing.assert_allclose(found.x, np.sort(x))
    np.testing.assert_allclose(found.y, np.sort(x) ** 2)
    assert found.lines[0] == 2 + int(np.argmin(x)) and "sorted" in found.notes[0]


def test_falling_rows_are_reversed():
    found = in_order(series(np.linspace(1.0, 0.0, 10)))
    assert found.x[0] == 0.0 and "reversed" in found.notes[0]


def test_a_loop_keeps_its_order():
    x = np.concatenate([np.linspace(0, 1, 20), np.linspace(0.95, 0, 19)])
    noisy = x + 0.005 * np.sin(50.0 * np.arange(len(x)))
    found = in_order(series(noisy))
    np.testing.assert_array_equal(found.x, noisy)
    assert found.unloads and first_reversal(noisy) in (19, 20, 21) and len(turns(noisy)) == 1


def test_two_cycles_are_two_loops_not_disorder():
    up, down = np.linspace(0, 1, 20), np.linspace(0.95, 0.05, 19)
    x = np.concatenate([up, down, up, down])
    assert turns(x) == [19, 39, 58]
    np.testing.assert_array_equal(in_order(series(x)).x, x)


def test_ten_cycles_of_conditioning_are_no_disorder_but_one_row_out_of_place_is():
    cycle = np.concatenate([np.linspace(0, 1, 10), np.linspace(0.9, 0.1, 9)])
    cycles = np.tile(cycle, 10)
    assert not in_order(series(cycles)).notes
    x = np.linspace(0.0, 1.0, 41)
    swapped = x.copy()
    swapped[[10, 30]] = swapped[[30, 10]]
    np.testing.assert_allclose(in_order(series(swapped)).x, x)


def test_a_test_that_begins_loaded_is_refused():
    x = np.concatenate([np.linspace(0.9, 0.0, 20), np.linspace(0.05, 1.0, 20)])
    with pytest.raises(InputError, match="line 2: column 'angle': it begins at 0.9, and falls before it rises"):
        in_order(series(x))


@pytest.mark.parametrize(("last", "told"), [([0.4], "0.4 after 1: a single row"), ([0.9, 0.5], "0.9 after 1: 2 rows")])
def test_a_stray_row_at_the_end_is_no_unloading(last, told):
    x = np.concatenate([np.linspace(0.0, 1.0, 18), last])
    with pytest.raises(InputError, match=f"line 20: column 'angle': {told} after a turn, .* leave these out"):
        in_order(series(x))


def test_an_unloading_of_three_rows_is_one():
    x = np.concatenate([np.linspace(0.0, 1.0, 18), [0.9, 0.7, 0.5]])
    np.testing.assert_array_equal(in_order(series(x)).x, x)


def test_many_rows_are_averaged_on_each_branch():
    x = np.concatenate([np.linspace(0, 1, 5000), np.linspace(1, 0, 5000)])
    found = thinned(series(x, 3.0 * x))
    assert 140 <= len(found.x) <= 152
    np.testing.assert_allclose(found.y, 3.0 * found.x)
    assert found.x[first_reversal(found.x) - 1] > 0.99


@pytest.mark.parametrize(("offset", "expected"), [("ask", 0.0), ("subtract", 0.0), ("keep", 0.015)])
def test_a_small_offset_of_the_machine(offset, expected):
    x = np.linspace(0.0, 1.0, 50)
    found = without_offset(series(x, x**2 + 0.015), offset)
    assert found.y[0] == pytest.approx(expected, abs=1e-12)


def test_a_larger_offset_is_a_question_and_a_large_one_a_mistake():
    x = np.linspace(0.0, 1.0, 50)
    with pytest.raises(InputError, match="line 2: column 'force': 0.1 at the start, 9% of the largest"):
        without_offset(series(x, x**2 + 0.1), "ask")
    with pytest.raises(InputError, match="is no offset"):
        without_offset(series(x, x**2 + 0.5), "subtract")


def test_noise_at_the_start_is_no_offset():
    rng = np.random.default_rng(1)
    x = np.linspace(0.0, 1.0, 200)
    noisy = series(x, x + 0.02 * rng.standard_normal(200))
    assert noise_of(noisy) == pytest.approx(0.02, rel=0.3)
    assert without_offset(noisy, "ask") is noisy
