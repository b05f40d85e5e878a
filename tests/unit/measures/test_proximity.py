"""Parts of a sheet that come close to each other, against a dense sampling."""

import numpy as np
import pytest

from weavesim import measures
from weavesim.errors import InputError
from weavesim.sheet.blank import Blank


def sampled_gaps(position, quads):
    """Distance of every node from a dense set of points of every element, (node_count, element_count)."""
    u, v = (g.ravel() for g in np.meshgrid(*2 * (np.linspace(0.0, 1.0, 41),)))
    inside = u + v <= 1.0
    weights = np.stack([1.0 - u - v, u, v], axis=1)[inside]
    gaps = np.full((len(position), len(quads)), np.inf)
    for element, corners in enumerate(position[quads]):
        for triangle in ((0, 1, 2), (0, 2, 3)):
            points = weights @ corners[list(triangle)]
            gap = np.linalg.norm(position[:, None] - points[None], axis=2).min(axis=1)
            gaps[:, element] = np.minimum(gaps[:, element], gap)
    near = np.eye(len(position), dtype=bool)
    for i in range(4):
        near[quads[:, i], quads[:, (i + 1) % 4]] = near[quads[:, (i + 1) % 4], quads[:, i]] = True
    within_two = (near.astype(int) @ near.astype(int)) > 0
    gaps[within_two[:, quads].any(axis=2)] = np.inf
    return gaps


@pytest.mark.parametrize("seed", range(3))
def test_close_pairs_against_a_dense_sampling(seed):
    blank = Blank.rectangle((0.0, 0.0), (0.08, 0.08), 0.01)
    rng = np.random.default_rng(seed)
    position = blank.node_position * (1.0, 0.3, 1.0) + rng.normal(0.0, 0.01, blank.node_position.shape)
    gaps = sampled_gaps(position, blank.quads)
    for distance in (0.002, 0.005, 0.01):
        # the sampling sees every distance at most this much too large
        slack = 1.0e-4 + 0.05 * distance
        found = measures.close_pairs(position, blank.quads, distance)
        assert (gaps < distance).sum() <= found <= (gaps < distance + slack).sum()
    assert found > 0


@pytest.mark.parametrize("stagger", [0.0, 0.005])
def test_close_pairs_of_a_flat_and_of_a_folded_sheet(stagger):
    blank = Blank.rectangle((-0.1, 0.0), (0.1, 0.1), 0.01)
    assert measures.close_pairs(blank.node_position, blank.quads, 0.015) == 0
    folded = np.array(blank.node_position)
    upper = folded[:, 0] > 0.0
    folded[upper, 0] = stagger - folded[upper, 0]
    folded[upper, 1] += stagger
    folded[upper, 2] = 0.0004
    # layers whose nodes lie between each other are as close as those whose nodes face each other
    assert measures.close_pairs(folded, blank.quads, 0.0006) >= 2 * 8 * 9
    assert measures.close_pairs(folded, blank.quads, 0.0003) == 0
    with pytest.raises(InputError, match="must be positive"):
        measures.close_pairs(folded, blank.quads, 0.0)
