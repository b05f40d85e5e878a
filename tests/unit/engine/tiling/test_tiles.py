"""A step is shared out to threads so that no node moves before its elements are done."""

import numpy as np
import pytest

from weavesim.engine.tiling.tiles import divide_step
from weavesim.sheet.blank import Blank

LANES = 16


def padded_corners(quads: np.ndarray, node_count: int) -> np.ndarray:
    """(4, padded elements) corner nodes, as the model lays them out."""
    result = np.empty((4, (len(quads) // LANES + 1) * LANES), dtype=np.int64)
    result[:] = node_count + np.arange(4)[:, None]
    result[:, : len(quads)] = quads.T
    return result


@pytest.mark.parametrize("thread_count", [1, 2, 3, 200])
@pytest.mark.parametrize("shuffled", [False, True])
@pytest.mark.parametrize("window", [1, 8])
def test_no_node_moves_before_its_elements_are_done(thread_count, shuffled, window):
    blank = Blank.rectangle((0.0, 0.0), (1.0, 1.0), 1.0 / 40.0)
    quads = np.random.default_rng(0).permutation(blank.quads) if shuffled else blank.quads
    corners = padded_corners(quads, blank.node_count)
    element_nodes = corners // LANES
    parts = divide_step(corners, LANES, thread_count, 256, window)
    assert len(parts) == thread_count
    assert all(first % window == 0 for part in parts for tile in part.tiles for first, _ in tile.elements)
    done = np.zeros((thread_count, corners.shape[1] // LANES), dtype=int)
    moved = np.zeros(element_nodes.max() + 1, dtype=int)

    def check(nodes: tuple[int, int], finished: np.ndarray) -> None:
        blocks = np.arange(nodes[0], sum(nodes))
        needed = np.isin(element_nodes, blocks).any(axis=0).nonzero()[0] // LANES
        assert finished[needed].all()
        moved[blocks] += 1

    for own, part in zip(done, parts, strict=True):
        for tile in part.tiles:
            for first, count in tile.elements:
                own[first : first + count] += 1
            # other threads may not have begun
            for nodes in tile.nodes:
                check(nodes, own)
    for part in parts:
        for nodes in part.shared:
            check(nodes, done.sum(axis=0))
    assert (done.sum(axis=0) == 1).all() and (moved == 1).all()
    waiting = sum(count for part in parts for _, count in part.shared)
    if thread_count == 1:
        assert waiting == 0
    elif thread_count < 4:
        # one row of nodes between two threads; without an order all have to wait
        assert waiting == len(moved) if shuffled else waiting <= 4 * (thread_count - 1)


def test_elements_along_the_border_are_done_with_their_neighbours():
    """A fitted mesh has them behind all others: still few nodes wait for more than one tile, in few runs."""
    blank = Blank.disc(0.2, 0.004)
    (part,) = divide_step(padded_corners(blank.quads, blank.node_count), LANES, 1, 1024)
    moved = [sum(count for _, count in tile.nodes) for tile in part.tiles]
    assert len(moved) > 7 and sum(moved) == -(-(blank.node_count + 4) // LANES)
    assert max(moved) < 2.0 * 1024 / LANES
    assert part.run_count < 6 * len(part.tiles)


def test_nodes_of_a_mesh_in_rows_whose_border_comes_first_move_with_their_tiles():
    """Mesh generators number corners and sides before what is inside: elements in rows, in their own order."""
    blank = Blank.rectangle((0.0, 0.0), (1.0, 1.0), 1.0 / 100.0)
    x, y, _ = blank.node_position.T
    inside = (np.minimum(x, y) > 1e-9) & (np.maximum(x, y) < 1.0 - 1e-9)
    number = np.empty(blank.node_count, dtype=np.int64)
    number[np.argsort(inside, kind="stable")] = np.arange(blank.node_count)
    (part,) = divide_step(padded_corners(number[blank.quads], blank.node_count), LANES, 1, 1024)
    moved = [sum(count for _, count in tile.nodes) for tile in part.tiles]
    assert [tile.elements for tile in part.tiles[:2]] == [((0, 64),), ((64, 64),)]
    assert min(moved) > 0.8 * 1024 / LANES and part.run_count <= 4 * len(part.tiles)


def test_elements_in_no_order_keep_their_own():
    blank = Blank.rectangle((0.0, 0.0), (1.0, 1.0), 1.0 / 60.0)
    quads = np.random.default_rng(0).permutation(blank.quads)
    (part,) = divide_step(padded_corners(quads, blank.node_count), LANES, 1, 256)
    assert [tile.elements for tile in part.tiles] == [((16 * k, 16),) for k in range(14)] + [((224, 2),)]
    assert sum(len(tile.nodes) for tile in part.tiles) <= 2
