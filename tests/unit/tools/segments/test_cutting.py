"""Sectors of triangles: they share the area, and what is left lies in them."""

import numpy as np
import pytest

from weavesim.tools.segments.cutting import sector_of


def areas(triangles) -> np.ndarray:
    vertices, faces = triangles
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)[:, 2]


def grid(count=7):
    """A square around the origin, whose corners do not lie on the sides of the sectors."""
    x = np.linspace(-1.0, 1.3, count)
    vertices = np.array([[a, b, 0.3 * a] for a in x for b in x])
    number = np.arange(count * count).reshape(count, count)
    a, b, c, d = (part.ravel() for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    return vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


@pytest.mark.parametrize("count", [2, 3, 5, 8])
def test_sectors_share_the_area_and_keep_their_side(count):
    whole, step = grid(), 2.0 * np.pi / count
    parts = [sector_of(whole, (0.1, -0.05), k * step, (k + 1) * step) for k in range(count)]
    assert sum(areas(part).sum() for part in parts) == pytest.approx(areas(whole).sum())
    for k, (vertices, faces) in enumerate(parts):
        assert areas((vertices, faces)).min() > -1e-15
        assert len(np.unique(faces)) == len(vertices)
        middle = vertices[faces].mean(axis=1)[:, :2] - (0.1, -0.05)
        angle = np.arctan2(middle[:, 1], middle[:, 0]) % (2.0 * np.pi)
        large = areas((vertices, faces)) > 1e-9
        assert np.all((angle[large] > k * step - 1e-9) & (angle[large] < (k + 1) * step + 1e-9))


def test_nothing_may_be_left():
    vertices, faces = sector_of(grid(), (5.0, 0.0), -0.5, 0.5)
    assert len(vertices) == 0 and faces.shape == (0, 3)
