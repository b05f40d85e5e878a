"""Tools of very many triangles are drawn coarser, and keep their shape."""

import numpy as np
import trimesh

from weavesim.output.paraview.tools import MOST_TRIANGLES
from weavesim.tools.drawing import coarser, gathered


def test_few_triangles_stay_as_they_are():
    ball = trimesh.creation.icosphere(3, radius=0.1)
    vertices, faces = coarser((ball.vertices, ball.faces), MOST_TRIANGLES)
    assert np.array_equal(vertices, ball.vertices) and np.array_equal(faces, ball.faces)


def test_very_many_become_few_within_a_cell_of_the_grid():
    ball = trimesh.creation.icosphere(6, radius=0.1)
    assert len(ball.faces) > 4 * MOST_TRIANGLES
    vertices, faces = coarser((ball.vertices, ball.faces), MOST_TRIANGLES)
    assert 0.5 * MOST_TRIANGLES < len(faces) <= MOST_TRIANGLES
    radius = np.linalg.norm(vertices, axis=1)
    assert radius.max() < 0.1 + 1e-12 and radius.min() > 0.1 - 0.2 / 50
    coarse = trimesh.Trimesh(vertices, faces)
    assert abs(coarse.area / ball.area - 1.0) < 0.05


def test_triangles_that_fall_together_are_one():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.01, 0, 0], [1, 1, 0]], dtype=float)
    faces = np.array([[0, 1, 2], [3, 1, 2], [0, 3, 1], [1, 4, 2]])
    points, left = gathered(vertices, faces, 0.1)
    assert len(points) == 4 and len(left) == 2
