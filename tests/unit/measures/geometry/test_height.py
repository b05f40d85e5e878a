"""Heights of points over sheets, where they are known."""

import numpy as np
import pytest

from weavesim.measures.geometry.height import heights_over
from weavesim.sheet.blank import Blank

BLANK = Blank.rectangle((-0.05, -0.05), (0.05, 0.05), 0.01)
POINTS = np.random.default_rng(0).uniform(-0.05, 0.05, (50, 3))


def over(points: np.ndarray, position: np.ndarray = BLANK.node_position, up: np.ndarray = BLANK.initial_director):
    return heights_over(points, position, BLANK.quads, up)


def test_over_a_flat_sheet_the_height_is_z():
    near = POINTS * (1.0, 1.0, 0.02)
    assert over(near) == pytest.approx(near[:, 2], abs=1e-12)
    assert over(near * (1.0, 1.0, 0.0)) == pytest.approx(0.0, abs=1e-15)


def test_up_is_the_side_of_the_directors():
    near = POINTS * (1.0, 1.0, 0.02)
    assert over(near, up=-BLANK.initial_director) == pytest.approx(-near[:, 2], abs=1e-12)


def test_it_turns_with_the_sheet():
    rotation = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    near = POINTS * (1.0, 1.0, 0.02)
    found = over(near @ rotation.T, BLANK.node_position @ rotation.T, BLANK.initial_director @ rotation.T)
    assert found == pytest.approx(near[:, 2], abs=1e-12)


def test_beside_the_sheet_there_is_none():
    assert np.isnan(over(np.array([(0.06, 0.0, 0.001), (0.0, -0.08, 0.0)]))).all()
    assert over(np.array([(0.0501, 0.0, 0.001)])) == pytest.approx(0.001)


def test_on_a_cylinder_it_is_the_distance_from_it():
    """But for the height of the elements' chords, h^2 / 8 R."""
    x, y = BLANK.material_coordinates.T
    angle, radius = x / 0.1, 0.1
    around = np.column_stack([np.sin(angle), np.zeros_like(x), np.cos(angle)])
    position = radius * around + np.column_stack([0.0 * x, y, 0.0 * x])
    found = over(position + 0.002 * around, position, around)
    assert found == pytest.approx(0.002, abs=0.01**2 / 0.8 + 1e-9)
