"""Simplified triangles of large tool meshes, for the samples of their distance."""

import numpy as np
import pytest

from weavesim.tools.mesh_tool import MeshSurface
from weavesim.tools.sampling import sampled_distance
from weavesim.tools.solid_triangles import FAR_TOLERANCE, NEAR_TOLERANCE, SIMPLIFIED_FACE_COUNT, SolidTriangles

trimesh = pytest.importorskip("trimesh")
SPACING = 0.002


def wavy_sheet(count: int = 121) -> MeshSurface:
    x = np.linspace(-0.15, 0.15, count)
    x, y = (values.ravel() for values in np.meshgrid(x, x, indexing="ij"))
    corner = np.arange(count * count).reshape(count, count)
    a, b, c, d = (part.ravel() for part in (corner[:-1, :-1], corner[1:, :-1], corner[1:, 1:], corner[:-1, 1:]))
    vertices = np.column_stack([x, y, 0.02 * np.cos(20.0 * x) * np.cos(15.0 * y)])
    return MeshSurface(vertices, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])]))


def ball() -> MeshSurface:
    mesh = trimesh.creation.icosphere(subdivisions=6, radius=0.06)
    return MeshSurface(mesh.vertices, mesh.faces)


def fine_box() -> MeshSurface:
    mesh = trimesh.creation.box((0.1, 0.06, 0.0005))
    for _ in range(6):
        mesh = mesh.subdivide()
    return MeshSurface(mesh.vertices, mesh.faces)


@pytest.mark.parametrize("made", [wavy_sheet, ball, fine_box])
def test_simplified_triangles_lie_within_a_share_of_the_spacing(made):
    surface = made()
    assert len(surface.solid_faces) > SIMPLIFIED_FACE_COUNT
    triangles = SolidTriangles(surface, "cpu", SPACING)
    assert triangles.far.indices.shape[0] < 3 * len(surface.solid_faces) / 2
    low, high = surface.vertices.min(axis=0) - 0.005, surface.vertices.max(axis=0) + 0.005
    points = np.random.default_rng(1).uniform(low, high, (3000, 3))
    exact, near, far = (
        triangles.distance(points, mesh, triangles.crossed) for mesh in (triangles.mesh, triangles.near, triangles.far)
    )
    inside = np.abs(exact) < 0.01
    assert np.count_nonzero(inside) > 100
    np.testing.assert_allclose(near[inside], exact[inside], atol=1.5 * NEAR_TOLERANCE * SPACING + 1e-7)
    np.testing.assert_allclose(far[inside], exact[inside], atol=1.5 * FAR_TOLERANCE * SPACING + 1e-7)


def test_a_fine_thin_wall_is_as_right_as_a_coarse_one():
    sampled = sampled_distance(fine_box(), "cpu", 0.0005, 0.0005)
    assert sampled.largest_error < 0.25 * 0.0005
    assert sampled.usual_error < 0.1 * 0.0005


@pytest.mark.parametrize(("length", "crossed"), [(0.17, 0), (0.22, 1)])
def test_surfaces_inside_the_solid_are_seen_on_simplified_triangles(length, crossed):
    # a bar bent to a ring of radius 30 mm: a longer one than 188 mm runs into itself
    bar = trimesh.creation.box((length, 0.01, 0.01))
    for _ in range(6):
        bar = bar.subdivide()
    x, y, z = np.array(bar.vertices).T
    ring = np.column_stack([(0.03 + y) * np.cos(x / 0.03), (0.03 + y) * np.sin(x / 0.03), z])
    surface = MeshSurface(ring, bar.faces)
    assert SolidTriangles(surface, "cpu").crossed == crossed
    assert SolidTriangles(surface, "cpu", SPACING).crossed == crossed


def test_a_device_that_has_no_memory_is_told(monkeypatch):
    """The thread that simplifies meanwhile waits for the other to begin, which it never does."""

    def full(*arguments, **options):
        raise MemoryError

    monkeypatch.setattr(SolidTriangles, "_on_device", full)
    with pytest.raises(MemoryError):
        SolidTriangles(ball(), "cpu", SPACING)
