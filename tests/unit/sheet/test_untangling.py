"""Poor elements become better ones; good meshes and fixed nodes stay."""

import numpy as np

from weavesim.sheet.untangling import corner_sines, untangled


def grid(count=6):
    x, y = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    index = np.arange(count * count).reshape(count, count)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    node = np.column_stack([x.ravel(), y.ravel()]).astype(float)
    inner = ((x > 0) & (x < count - 1) & (y > 0) & (y < count - 1)).ravel()
    return node, quads, inner


def test_a_tangled_mesh_becomes_regular_again():
    node, quads, inner = grid()
    tangled = node.copy()
    tangled[14] += (1.4, 0.9)
    assert corner_sines(tangled, quads).min() < 0.0
    result = untangled(tangled, quads, inner, 0.5)
    assert corner_sines(result, quads).min() > 0.5
    assert np.array_equal(result[~inner], node[~inner])


def test_a_good_mesh_is_left_alone():
    node, quads, inner = grid()
    assert np.array_equal(untangled(node, quads, inner, 0.5), node)
