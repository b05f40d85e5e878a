"""Every node finds the corners of its elements, in the order of these."""

import numpy as np

from weavesim.engine.layout import RowLayout
from weavesim.engine.mesh.corners import corner_table
from weavesim.kernels.rows import CORNER_ROW_COUNT, ROWS_PER_CORNER

# Two squares side by side, and a third one below the second.
QUADS = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [6, 7, 2, 1]])


def test_entries_are_those_of_the_corners_wherever_elements_lie():
    corners = RowLayout(CORNER_ROW_COUNT, 16, 1)
    places, spare = np.array([5, 0, 9]), 15
    table = corner_table(QUADS, 10, corners, places, spare)

    def entry(element: int, corner: int) -> int:
        return corners.entry(ROWS_PER_CORNER * corner, int(places[element]))

    none = corners.entry(0, spare)
    assert table.shape == (4, 10) and table.dtype == np.int32
    assert table[:, 1].tolist() == [entry(0, 1), entry(1, 0), entry(2, 3), none]
    assert table[:, 2].tolist() == [entry(1, 1), entry(2, 2), none, none]
    assert table[:, 4].tolist() == [entry(0, 2), entry(1, 3), none, none]
    assert (table[:, 8:] == none).all()


def test_a_node_of_many_elements_has_as_many_slots():
    fan = np.array([[0, k, k + 1, k + 10] for k in range(1, 7)])
    table = corner_table(fan, 20, RowLayout(CORNER_ROW_COUNT, 16, 1), np.arange(6), 15)
    assert table.shape == (6, 20)
    assert sorted(table[:, 0]) == list(range(6))
