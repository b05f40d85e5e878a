"""Elements that are not there are as padding; the others keep every bit."""

import numpy as np
import pytest

from weavesim.engine.mesh.elements import element_tables, inverse, rows_padded
from weavesim.sheet.geometry import ElementGeometry


def test_elements_that_are_not_there_are_as_padding(curved_blank):
    geometry, count = ElementGeometry.of(curved_blank), curved_blank.element_count
    density, kept = np.linspace(0.5, 1.0, count), np.arange(count) % 3 != 1
    length, spare = 16 * (count // 16 + 1), curved_blank.node_count
    whole = element_tables(curved_blank.quads, geometry, density, np.ones(count, dtype=bool), spare, length)
    part = element_tables(curved_blank.quads, geometry, density, kept, spare, length)
    assert np.array_equal(whole.nodes, whole.corners) and np.array_equal(part.nodes, whole.nodes)
    gone = np.flatnonzero(~kept)
    assert np.array_equal(part.corners[:, gone], np.tile(spare + np.arange(4)[:, None], len(gone)))
    assert np.array_equal(part.corners[:, :count][:, kept], curved_blank.quads[kept].T)
    for name, values in part.values.items():
        assert np.array_equal(values[..., :count][..., kept], whole.values[name][..., :count][..., kept])
        padding = values[..., -1:]
        assert np.array_equal(values[..., gone], np.broadcast_to(padding, values[..., gone].shape)), name
    assert part.values["area"].sum() == pytest.approx(geometry.area[kept].sum())


def test_rows_and_inverse():
    assert rows_padded([[1.0, 2.0]], 4).tolist() == [[1.0, 2.0, 0.0, 0.0]]
    assert inverse(np.array([2.0, 0.0])).tolist() == [0.5, 0.0]
    assert inverse(np.array([2.0, 0.0]), np.array([3.0, 5.0])).tolist() == [1.5, 0.0]
