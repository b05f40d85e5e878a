"""Distances to triangles in double precision: those of bodies that are known, wherever the tool stands."""

import numpy as np
import pytest
import trimesh

from weavesim.process.motions.paths import Pose
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Sphere, Union, rotation_matrix
from weavesim.tools.surfaces.exact import ExactSurface
from weavesim.tools.tool import Tool

SIZE = np.array([0.06, 0.04, 0.02])
TURN = rotation_matrix((0.0, 0.0, 1.0), 0.3)


def box_distance(points):
    """Signed distance to a box about the origin, (k,) [m]."""
    beside = np.abs(points) - 0.5 * SIZE
    return np.linalg.norm(np.maximum(beside, 0.0), axis=1) + np.minimum(beside.max(axis=1), 0.0)


@pytest.fixture(scope="module")
def box():
    """Divided finely, so that triangles are small, and turned."""
    mesh = trimesh.creation.box(SIZE).subdivide().subdivide().subdivide()
    return MeshShape.from_triangles(mesh.vertices, mesh.faces, origin=(0.01, 0.0, 0.0), rotation=TURN)


@pytest.fixture(scope="module")
def points():
    return np.random.default_rng(1).uniform(-0.05, 0.05, size=(2000, 3))


def test_distances_of_a_box_in_its_place(box, points):
    tool = Tool("box", box, axis=(0.0, 1.0, 0.0))
    surface = ExactSurface(tool, 0.02)
    distance, normal = surface(points)
    local = (points - [0.01, 0.02, 0.0]) @ np.array(TURN)
    assert surface.error < 5e-8
    assert np.abs(distance - box_distance(local)).max() < surface.error
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1.0)
    # a step back by the distance along the normal ends on the surface
    assert np.abs(box_distance((points - distance[:, None] * normal - [0.01, 0.02, 0.0]) @ np.array(TURN))).max() < 1e-7
    assert not surface.beyond(points).any()


def test_a_turned_tool_turns_its_distances(box, points):
    tool, turn = Tool("box", box), np.array(rotation_matrix((1.0, 0.0, 0.0), 0.5))
    pose = Pose.from_numbers(np.concatenate([turn.ravel(), [0.0, 0.0, 0.03]]))
    distance, normal = ExactSurface(tool, pose)(points)
    still, direction = ExactSurface(tool)(pose.back(points))
    assert distance == pytest.approx(still, abs=1e-12)
    assert np.allclose(normal, pose.turned(direction))


def test_the_nearest_part_counts(box, points):
    ball = Sphere(origin=(0.0, 0.03, 0.0), radius=0.01)
    distance, _ = ExactSurface(Tool("both", Union((box, ball))))(points)
    to_box = box_distance((points - [0.01, 0.0, 0.0]) @ np.array(TURN))
    to_ball = np.linalg.norm(points - [0.0, 0.03, 0.0], axis=1) - 0.01
    assert distance == pytest.approx(np.minimum(to_box, to_ball), abs=5e-8)


def test_an_open_sheet_ends_at_its_border():
    plate = [[-0.05, -0.05, 0.0], [0.05, -0.05, 0.0], [0.05, 0.05, 0.0], [-0.05, 0.05, 0.0]]
    surface = ExactSurface(Tool("plate", MeshShape.from_triangles(plate, [[0, 1, 2], [0, 2, 3]])))
    asked = np.array(
        [[0.0, 0.01, 0.003], [0.049, 0.0, 0.003], [0.053, 0.0, -0.001], [0.0, -0.07, -0.02], [0, 0, -0.01]]
    )
    distance, normal = surface(asked)
    assert distance == pytest.approx([0.003, 0.003, 0.003, 0.02, -0.01], abs=1e-9)
    assert normal[:2] == pytest.approx(np.array([[0.0, 0.0, 1.0]] * 2), abs=1e-9)
    assert surface.beyond(asked).tolist() == [False, False, True, True, False]
    on, _ = surface(np.array([[0.01, 0.02, 0.0], [0.01, 0.02, 1e-10]]))
    assert on == pytest.approx([0.0, 1e-10], abs=1e-15)
