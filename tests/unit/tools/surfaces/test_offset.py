"""Offsets of surfaces whose answer is known: balls, edges, fillets; hollows that are too sharp are refused."""

import numpy as np
import pytest
import trimesh

from weavesim import InputError
from weavesim.tools.surfaces.offset import offset_surface


@pytest.mark.parametrize("distance", [0.002, -0.002])
def test_a_ball_becomes_a_larger_or_a_smaller_one(distance):
    ball = trimesh.creation.icosphere(4, 0.05)
    moved = offset_surface("ball", ball.vertices, ball.faces, distance)
    assert np.allclose(np.linalg.norm(moved, axis=1), 0.05 + distance, rtol=2e-3)


def test_edges_and_corners_of_a_box_stay_sharp():
    box = trimesh.creation.box((0.1, 0.2, 0.3))
    moved = offset_surface("box", box.vertices, box.faces, 0.01)
    assert np.allclose(np.abs(moved), np.abs(box.vertices) + 0.01)


def test_a_sharp_hollow_edge_stays_one():
    # two walls that meet at a right angle, seen from inside
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1], [0, 1, 0], [1, 1, 0], [0, 1, 1]], dtype=float)
    faces = np.array([[0, 1, 4], [0, 4, 3], [0, 3, 5], [0, 5, 2]])
    moved = offset_surface("angle", vertices, faces, 0.1)
    assert np.allclose(moved[[0, 3]][:, [0, 2]], 0.1)


def test_no_distance_changes_nothing():
    box = trimesh.creation.box((0.1, 0.2, 0.3))
    assert np.array_equal(offset_surface("box", box.vertices, box.faces, 0.0), box.vertices)


def test_a_hollow_below_the_distance_is_refused_with_its_place():
    ball = trimesh.creation.icosphere(2, 0.005)
    with pytest.raises(InputError, match=r"ball: its offset by 6 mm crosses itself at \("):
        offset_surface("ball", ball.vertices, ball.faces[:, ::-1], 0.006)


def test_a_slot_below_twice_the_distance_is_refused():
    vertices = np.array([[x, y, z] for x in (0.0, 0.01) for y in (0.0, 0.05) for z in (0.0, 0.05)])
    # two walls 10 mm apart that face each other
    faces = np.array([[0, 2, 3], [0, 3, 1], [4, 7, 6], [4, 5, 7]])
    with pytest.raises(InputError, match="crosses itself"):
        offset_surface("slot", vertices, faces, 0.006)
    moved = offset_surface("slot", vertices, faces, 0.004)
    assert np.allclose(sorted(set(moved[:, 0].round(12))), [0.004, 0.006])
