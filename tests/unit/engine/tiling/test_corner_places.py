"""Places of corner records are enough for all nodes to find what they read, and few."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from weavesim.engine.tiling.corner_places import CornerPlaces
from weavesim.engine.tiling.tiles import divide_step
from weavesim.sheet.blank import Blank

LANES, TILE = 16, 64


def padded_corners(blank: Blank, order: np.ndarray) -> np.ndarray:
    """(4, padded elements) corner nodes with the elements in ``order``, as the model lays them out."""
    result = np.empty((4, (len(order) // LANES + 1) * LANES), dtype=np.int64)
    result[:] = blank.node_count + np.arange(4)[:, None]
    result[:, : len(order)] = blank.quads[order].T
    return result


def step_through(element_nodes: np.ndarray, parts, places: CornerPlaces) -> None:
    """Do a step, whose threads run one after the other, with the number of a block as its record."""
    content = np.full(places.count, -1)
    readers = [np.unique(np.flatnonzero((element_nodes // LANES == b).any(axis=0)) // LANES) for b in
               range(element_nodes.max() // LANES + 1)]  # fmt: skip

    def check(nodes: tuple[int, int]) -> None:
        for block in range(nodes[0], sum(nodes)):
            assert np.array_equal(content[places.of_block[readers[block]]], readers[block])

    for part in parts:
        for tile in part.tiles:
            for first, count in tile.elements:
                content[places.of_block[first : first + count]] = np.arange(first, first + count)
                assert (np.diff(places.of_block[first : first + count]) == 1).all()
            for nodes in tile.nodes:
                check(nodes)
    for part in parts:
        for nodes in part.shared:
            check(nodes)


@settings(deadline=None, max_examples=60)
@given(
    width=st.integers(1, 40),
    height=st.integers(1, 40),
    thread_count=st.integers(1, 6),
    window=st.sampled_from([1, 3]),
    swaps=st.integers(0, 60),
    seed=st.integers(0, 2**32 - 1),
)
def test_nodes_find_what_their_elements_wrote(width, height, thread_count, window, swaps, seed):
    """In meshes numbered row by row, with some elements elsewhere, on any number of threads."""
    blank = Blank.rectangle((0.0, 0.0), (0.01 * width, 0.01 * height), 0.01)
    order, random = np.arange(blank.element_count), np.random.default_rng(seed)
    for _ in range(swaps):
        pair = random.integers(len(order), size=2)
        order[pair] = order[pair[::-1]]
    element_nodes = padded_corners(blank, order)
    parts = divide_step(element_nodes, LANES, thread_count, TILE, window)
    places = CornerPlaces.of(element_nodes, LANES, parts)
    step_through(element_nodes, parts, places)
    # threads run side by side: none may write where another one's nodes read
    own = [
        {int(places.of_block[b]) for tile in part.tiles for first, n in tile.elements for b in range(first, first + n)}
        for part in parts
    ]
    assert sum(map(len, own)) == len(set().union(*own))
    assert places.of_block.min() == 0 and places.of_block.max() < places.count


@pytest.mark.parametrize("thread_count", [1, 2, 4])
def test_places_do_not_grow_with_the_sheet(thread_count):
    """Two tiles in turn for each thread, and one more wherever a row of nodes waits for another thread."""
    found = []
    for length in (0.8, 1.6, 3.2):
        blank = Blank.rectangle((0.0, 0.0), (length, 0.3), 0.01)
        element_nodes = padded_corners(blank, np.arange(blank.element_count))
        parts = divide_step(element_nodes, LANES, thread_count, TILE)
        found.append(CornerPlaces.of(element_nodes, LANES, parts).count)
    largest = (2 * thread_count + (thread_count - 1)) * TILE // LANES
    assert found[0] == found[1] == found[2] <= largest


def test_numbers_in_no_order_need_all_places():
    blank = Blank.rectangle((0.0, 0.0), (0.3, 1.6), 0.01)
    element_nodes = padded_corners(blank, np.random.default_rng(1).permutation(blank.element_count))
    parts = divide_step(element_nodes, LANES, 1, TILE)
    places = CornerPlaces.of(element_nodes, LANES, parts)
    assert places.count >= 0.9 * len(places.of_block)
