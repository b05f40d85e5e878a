"""Nearest points of a surface: those of a search through all triangles."""

import numpy as np
from trimesh.triangles import closest_point

from weavesim.output.export.nearest import nearest


def test_no_other_triangle_is_nearer():
    rng = np.random.default_rng(0)
    # slivers beside small ones: the nearest centre is often not that of the nearest triangle
    triangles = rng.uniform(size=(60, 3, 3)) * np.where(rng.uniform(size=(60, 1, 1)) < 0.2, 3.0, 0.2)
    points = rng.uniform(-0.5, 2.0, size=(80, 3))
    found, which = nearest(triangles, points)
    for point, near, row in zip(points, found, which, strict=True):
        every = np.linalg.norm(closest_point(triangles, np.tile(point, (60, 1))) - point, axis=1)
        assert np.isclose(np.linalg.norm(near - point), every.min(), rtol=1e-12)
        assert np.isclose(every[row], every.min(), rtol=1e-12)


def test_a_single_triangle_is_enough():
    found, which = nearest(np.eye(3)[None], np.array([[1.0, 1.0, 1.0]]))
    assert np.allclose(found, 1.0 / 3.0) and which.tolist() == [0]
