"""Parts of a mesh, and normals of its elements."""

import time

import numpy as np
import pytest

from weavesim.sheet.blank import Blank
from weavesim.sheet.topology import doubled_normals, part_of_nodes


@pytest.mark.parametrize("part_count", [1, 2, 7])
def test_parts_are_found_in_any_order_of_nodes_and_elements(part_count):
    """Rectangles of 20 x 15 elements side by side, numbered at random; each part is named by its smallest node."""
    one = Blank.rectangle((0.0, 0.0), (0.2, 0.15), 0.01).quads.astype(int)
    count = one.max() + 1
    random = np.random.default_rng(part_count)
    number = random.permutation(part_count * count)
    quads = np.vstack([number[one + k * count] for k in range(part_count)])
    part = part_of_nodes(quads[random.permutation(len(quads))], len(number))
    for k in range(part_count):
        nodes = number[k * count : (k + 1) * count]
        assert set(part[nodes]) == {nodes.min()}


def test_pairs_connect_chains_and_leave_the_rest():
    pairs = np.array([[5, 3], [1, 4], [3, 1]])
    assert part_of_nodes(pairs, 7).tolist() == [0, 1, 2, 1, 1, 1, 6]
    assert part_of_nodes(np.empty((0, 2), dtype=int), 3).tolist() == [0, 1, 2]


def test_the_parts_of_a_large_blank_take_little_time():
    quads = Blank.rectangle((0.0, 0.0), (3.0, 3.0), 0.01).quads
    started = time.process_time()
    part_of_nodes(quads, quads.max() + 1)
    assert time.process_time() - started < 1.0


def test_normals_are_twice_as_long_as_the_area_and_up_for_counter_clockwise_corners():
    position = np.array([(0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (3.0, 2.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 4.0)])
    quads = np.array([[0, 1, 2, 3], [3, 2, 1, 0], [0, 1, 4, 0]])
    np.testing.assert_allclose(doubled_normals(position, quads), [(0, 0, 12), (0, 0, -12), (0, -12, 0)], atol=1e-15)
