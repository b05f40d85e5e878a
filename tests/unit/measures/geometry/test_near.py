"""Pairs of bodies whose spheres meet, against all pairs."""

import numpy as np

from weavesim.measures.geometry.near import near_pairs


def test_near_pairs_are_all_whose_spheres_meet():
    corners = np.random.default_rng(0).uniform(0.0, 1.0, (300, 4, 3)) * 0.2 + np.random.default_rng(1).uniform(
        0, 1, (300, 1, 3)
    )
    centre = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centre[:, None], axis=2).max(axis=1)
    gap = np.linalg.norm(centre[:, None] - centre, axis=2)
    wanted = np.argwhere(np.triu(gap <= radius[:, None] + radius, 1))
    found = np.column_stack(near_pairs(centre, corners))
    assert np.array_equal(found[np.lexsort(found.T[::-1])], wanted)


def test_near_pairs_of_different_groups_are_all_of_them():
    rng = np.random.default_rng(2)
    corners = rng.uniform(0.0, 0.2, (200, 4, 3)) + rng.uniform(0.0, 1.0, (200, 1, 3))
    group = rng.integers(0, 3, 200)
    centre = corners.mean(axis=1)
    every = np.column_stack(near_pairs(centre, corners))
    found = np.column_stack(near_pairs(centre, corners, group))
    wanted = every[group[every[:, 0]] != group[every[:, 1]]]
    assert {tuple(pair) for pair in found.tolist()} == {tuple(pair) for pair in wanted.tolist()} and len(found) > 100
