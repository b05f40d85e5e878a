"""An order in which neighbours follow each other, and what is said of meshes that are in none."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from weavesim.errors import InputError
from weavesim.meshes.numbering import (
    blocks_touched,
    checked_numbering,
    each_once,
    neighbouring_order,
    rows_numbered,
    scatter_told,
)


def rows(nx: int, ny: int) -> np.ndarray:
    """Quadrilaterals of a mesh of (nx + 1) by (ny + 1) nodes in rows."""
    index = np.arange((nx + 1) * (ny + 1)).reshape(nx + 1, ny + 1)
    return np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)


def shuffled(quads: np.ndarray, seed: int) -> np.ndarray:
    """The same mesh with nodes and elements numbered at random."""
    random = np.random.default_rng(seed)
    return random.permutation(random.permutation(quads.max() + 1)[quads])


@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 10**6))
@settings(max_examples=60, deadline=None)
def test_the_order_is_a_permutation_whose_neighbours_are_as_near_as_in_rows(nx, ny, seed):
    quads, count = shuffled(rows(nx, ny), seed), (nx + 1) * (ny + 1)
    nodes, elements = neighbouring_order(quads, count)
    assert sorted(nodes) == list(range(count)) and sorted(elements) == list(range(nx * ny))
    place = np.argsort(nodes)
    corners = place[quads[elements]]
    assert (np.diff(corners.min(axis=1)) >= 0).all()
    # fronts of a grid of four neighbours are its diagonals: two of them, of at most min + 1 nodes, hold an edge
    assert (np.abs(corners - np.roll(corners, -1, axis=1)).max()) <= 2 * (min(nx, ny) + 1)


def test_a_strip_is_numbered_from_end_to_end():
    nodes, elements = neighbouring_order(shuffled(rows(40, 1), 3), 82)
    corners = np.argsort(nodes)[shuffled(rows(40, 1), 3)[elements]]
    assert (corners.max(axis=1) - corners.min(axis=1)).max() == 3


def test_blocks_that_a_block_of_elements_touches():
    # sixteen elements of a strip have 34 nodes in sequence, in three blocks, or four where they begin at odd ones
    assert blocks_touched(rows(16, 1)) == 3.0
    assert blocks_touched(rows(3, 1)) == 1.0
    apart = 16 * np.arange(64).reshape(16, 4)
    assert blocks_touched(apart) == 64.0


def test_meshes_in_no_order_are_told_where_it_costs_something():
    large = rows(70, 70)
    assert scatter_told(large) == ""
    nodes, elements = neighbouring_order(shuffled(large, 1), 71 * 71)
    assert scatter_told(np.argsort(nodes)[shuffled(large, 1)[elements]]) == ""
    # 64 corners in 316 blocks of nodes: 316 (1 - (1 - 1/316)^64) = 58 different ones
    told = scatter_told(shuffled(large, 1))
    assert 'numbering = "neighbouring"' in told and "use nodes in 58 different places" in told
    assert scatter_told(shuffled(rows(60, 60), 1)) == ""


@pytest.mark.parametrize("value", ["Kept", "along", "", None, 1, ["kept"]])
def test_another_numbering_is_refused(value):
    with pytest.raises(InputError, match="numbering = .*: one of 'kept', 'neighbouring' is needed"):
        checked_numbering(value)
    assert checked_numbering("neighbouring") == "neighbouring"


@given(st.lists(st.integers(1, 10**9), min_size=1, max_size=30, unique=True), st.data())
@settings(max_examples=60, deadline=None)
def test_rows_are_found_by_their_numbers(numbers, data):
    known = np.array(numbers)
    wanted = data.draw(st.lists(st.sampled_from(numbers), max_size=10))
    found = rows_numbered("node", np.array(wanted, dtype=int), known, len(known))
    assert known[found].tolist() == wanted
    with pytest.raises(InputError, match=f"has no node {max(numbers) + 1}: "):
        rows_numbered("node", [numbers[0], max(numbers) + 1], known, len(known))


def test_without_numbers_they_are_the_rows_counted_from_one():
    assert rows_numbered("element", [3, 1], None, 3).tolist() == [2, 0]
    for wrong in (0, 4, [1, 7]):
        with pytest.raises(InputError, match="has no element"):
            rows_numbered("element", wrong, None, 3)
    for wrong in ([1.0], "2", [[1, 2]]):
        with pytest.raises(InputError, match="whole numbers are needed"):
            rows_numbered("element", wrong, None, 3)


def test_numbers_are_there_once():
    assert each_once(np.array([7, 3])) and each_once(np.zeros(0, dtype=int))
    assert not each_once(np.array([7, 7])) and not each_once(np.array([0, 1]))
