"""Blocks of elements for samples: compact, and within windows."""

import numpy as np
import pytest

from weavesim.engine.surface.order import compact_order, window
from weavesim.sheet.blank import Blank


@pytest.mark.parametrize(
    ("element_count", "lane_count", "expected"), [(1269, 1, 1), (1280, 16, 8), (10**6, 16, 64), (9, 16, 1)]
)
def test_a_window_is_a_share_of_the_sheet(element_count, lane_count, expected):
    assert window(element_count, lane_count) == expected


@pytest.mark.parametrize("side", [(0.16, 0.1), (0.1, 0.037)])
def test_elements_change_places_within_windows(side):
    blank = Blank.rectangle((0.0, 0.0), side, 0.005)
    centres = blank.node_position[blank.quads].mean(axis=1)
    order = compact_order(centres, 4)
    assert sorted(order) == list(range(len(centres)))
    assert np.array_equal(order // 64, np.arange(len(centres)) // 64)


def test_blocks_are_compact():
    """Of a sheet of 32 x 32 elements in one window: squares of four by four."""
    blank = Blank.rectangle((0.0, 0.0), (0.16, 0.16), 0.005)
    centres = blank.node_position[blank.quads].mean(axis=1)
    blocks = centres[compact_order(centres, 64)].reshape(-1, 16, 3)
    extent = blocks.max(axis=1) - blocks.min(axis=1)
    assert np.allclose(extent[:, :2], 0.015)
