"""A ring of corner records holds for every node what the arrays of the state would."""

import numpy as np
import pytest

from tests.support.runs import one_sheet_run
from weavesim.engine.tiling.corner_places import CornerPlaces
from weavesim.engine.tiling.corner_ring import CornerRing
from weavesim.engine.tiling.tiles import divide_step
from weavesim.fabric.presets import glass_polypropylene
from weavesim.kernels.rows import CORNER_ROW_COUNT, ROWS_PER_CORNER
from weavesim.sheet.blank import Blank

LANES = 16


@pytest.fixture(scope="module")
def sheet():
    blank = Blank.rectangle((0.0, 0.0), (0.1, 0.2), 0.005)
    return one_sheet_run(
        name="free", blank=blank, fabric=glass_polypropylene(), lane_count=LANES, threads=1, duration=1.0
    ).model.sheet


@pytest.fixture(scope="module")
def ring(sheet):
    parts = divide_step(sheet.element_nodes, LANES, 1, 64)
    return CornerRing(sheet, CornerPlaces.of(sheet.element_nodes, LANES, parts))


def test_it_is_smaller_than_the_arrays_of_the_state(sheet, ring):
    assert ring.records.size < 0.3 * CORNER_ROW_COUNT * sheet.element_count


def test_a_tile_lies_at_its_place(sheet, ring):
    """Read by the address alone: all but the tile's own blocks are outside."""
    parts = divide_step(sheet.element_nodes, LANES, 1, 64)
    places = CornerPlaces.of(sheet.element_nodes, LANES, parts)
    whole = sheet.corners.view(ring.records)
    for first, count in (run for tile in parts[0].tiles for run in tile.elements):
        view = ring.at(first)
        assert view.strides == whole.strides and view.dtype == whole.dtype
        for block in range(first, first + count):
            address = view.ptr + block * view.strides[1]
            assert address == ring.records.ptr + places.of_block[block] * whole.strides[1]


def test_nodes_read_there_the_corners_that_they_read_before(sheet, ring):
    """An entry of the ring is that of the sheet with another block, and the spare one is zero."""
    block_size = CORNER_ROW_COUNT * LANES
    parts = divide_step(sheet.element_nodes, LANES, 1, 64)
    places = CornerPlaces.of(sheet.element_nodes, LANES, parts)
    before = sheet.nodes.corner_offset.numpy()
    after = ring.nodes.corner_offset.numpy()
    spare = before == sheet.corners.entry(0, sheet.blank.element_count)
    assert spare.any() and not spare.all()
    expected = places.of_block[before // block_size] * block_size + before % block_size
    assert np.array_equal(after[~spare], expected[~spare])
    assert np.array_equal(after[spare] // block_size, np.full(spare.sum(), places.count))
    assert after.max() + ROWS_PER_CORNER <= ring.records.size


def test_nodes_are_the_same_otherwise(sheet, ring):
    for name in ("mass", "inverse_mass", "inverse_inertia", "freedom", "angle_weight", "load"):
        assert getattr(ring.nodes, name).ptr == getattr(sheet.nodes, name).ptr
    assert ring.nodes.corner_stride == sheet.nodes.corner_stride
