"""Candidates in doubted cells against a search of all triangles, and what tells the side at edges and corners."""

import numpy as np
import pytest
import trimesh
import warp as wp

from tests.support.oracles import triangle_distance
from tests.support.solids import box
from weavesim.kernels.contact.fill_samples import sampled_distance_kernel
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.samples.candidates import facings
from weavesim.tools.sampling import exact_distance, sampled_distance
from weavesim.tools.tool import Tool


def turned(mesh):
    """In a frame whose axes are not those of the cells."""
    matrix = trimesh.transformations.rotation_matrix(0.7, (1.0, 0.4, 0.2))[:3, :3]
    return mesh[0] @ matrix.T, mesh[1]


def spike():
    """A star-shaped body whose corners are neither convex nor hollow: saddles, sharp edges and needles."""
    ball = trimesh.creation.icosphere(subdivisions=2, radius=0.03)
    random = np.random.default_rng(3)
    return ball.vertices * random.uniform(0.55, 1.0, (len(ball.vertices), 1)), ball.faces


def step_die():
    """An open sheet with a sharp step: an edge on top and a groove below."""
    x, z = np.array([-0.06, -0.01, 0.0, 0.06]), np.array([0.0, 0.0, -0.02, -0.02])
    vertices = np.concatenate([np.column_stack([x, np.full(4, y), z]) for y in (-0.05, 0.05)])
    k = np.arange(3)
    return vertices, np.concatenate([np.column_stack([k, k + 5, k + 1]), np.column_stack([k, k + 4, k + 5])])


@pytest.mark.parametrize("mesh", [turned(box((0.05, 0.04, 0.03))), spike(), step_die()], ids=["box", "spike", "step"])
def test_candidates_hold_the_nearest_triangle_and_tell_the_side(mesh):
    shape = MeshShape.from_triangles(*mesh)
    surface = shape.surface
    sampled = sampled_distance(surface, "cpu", 0.001, 0.001)
    first = sampled.others[3].numpy()
    assert np.all(np.diff(first) > 0)  # no part of a doubted cell is left to a search of all triangles
    edge = surface.vertices[surface.faces]
    random = np.random.default_rng(2)
    share = random.uniform(0.0, 1.0, (len(edge), 40, 1))
    along = np.concatenate([(1 - share) * edge[:, [k]] + share * edge[:, [(k + 1) % 3]] for k in range(3)])
    points = along.reshape(-1, 3)
    points = points[random.choice(len(points), 5000)] + random.normal(size=(5000, 3)) * 4e-4
    value, normal = Tool("tool", shape).distance(points)
    expected = exact_distance(surface, points)
    # in cells that are not doubted samples may err by the tolerance
    doubted = np.abs(value - expected) < 2e-7
    assert np.mean(doubted) > 0.3
    near = np.abs(expected) < 0.0015
    np.testing.assert_allclose(value[near], expected[near], atol=3.0 * sampled.tolerance)
    clear = near & (np.abs(expected) > 2.0 * sampled.tolerance)
    np.testing.assert_array_equal(value[clear] < 0.0, expected[clear] < 0.0)
    np.testing.assert_allclose(np.linalg.norm(normal[near], axis=1), 1.0, atol=1e-5)
    if surface.closed:
        unsigned = triangle_distance(points, surface.vertices, surface.faces)
        np.testing.assert_allclose(np.abs(value)[doubted & near], unsigned[doubted & near], atol=1e-6)


def test_too_many_candidates_leave_the_search_to_all_triangles(monkeypatch):
    mesh = turned(box((0.05, 0.04, 0.03)))
    points = np.random.default_rng(4).uniform(-0.03, 0.03, (4000, 3))

    def value(shape):
        record = sampled_distance(shape.surface, "cpu", 0.001, 0.001).record
        result = wp.zeros(len(points), dtype=float, device="cpu")
        inputs = [record, wp.array(points, dtype=wp.vec3, device="cpu")]
        wp.launch(sampled_distance_kernel, dim=len(points), inputs=inputs, outputs=[result], device="cpu")
        return result.numpy()

    with_lists = value(MeshShape.from_triangles(*mesh))
    none = (np.zeros(0, np.float32), np.zeros(0, np.int32))
    monkeypatch.setattr(
        "weavesim.tools.samples.candidates._lists",
        lambda triangles, corner, *_: (np.zeros(8 * len(corner) + 1, dtype=np.int32), *none),
    )
    np.testing.assert_allclose(value(MeshShape.from_triangles(*mesh)), with_lists, atol=2e-8)


def test_facings_of_a_cube_point_outwards_from_faces_edges_and_corners():
    vertices, faces = box((2.0, 2.0, 2.0))
    found = facings(vertices, faces, np.arange(len(faces)))
    assert found.shape == (len(faces), 7, 3)
    np.testing.assert_allclose(found[:, 4:], vertices[faces] / np.sqrt(3.0), atol=1e-12)
    middle = 0.5 * (vertices[faces] + np.roll(vertices[faces], -1, axis=1))
    np.testing.assert_allclose(found[:, 1:4], middle / np.linalg.norm(middle, axis=2, keepdims=True), atol=1e-12)
    some = np.array([3, 7])
    np.testing.assert_allclose(facings(vertices, faces, some), found[some], atol=1e-12)


def test_borders_seams_and_touching_corners_tell_no_side():
    vertices, faces = box((2.0, 2.0, 2.0))
    found = facings(vertices, faces[1:], np.arange(len(faces) - 1))
    border = np.isin(faces[1:], faces[0])
    np.testing.assert_array_equal(np.all(found[:, 4:] == 0.0, axis=2), border)
    assert np.count_nonzero(np.all(found[:, 1:4] == 0.0, axis=2)) == 3
    # two cubes that share one vertex
    corner = np.flatnonzero(np.all(vertices == 1.0, axis=1))[0]
    other = np.where(np.all(vertices + 2.0 == 1.0, axis=1), corner, np.arange(len(vertices)) + len(vertices))
    both = np.concatenate([vertices, vertices + 2.0])
    meeting = np.concatenate([faces, other[faces]])
    found = facings(both, meeting, np.arange(len(meeting)))
    np.testing.assert_array_equal(np.all(found[:, 4:] == 0.0, axis=2), meeting == corner)
    assert not np.any(np.all(found[:, :4] == 0.0, axis=2))
