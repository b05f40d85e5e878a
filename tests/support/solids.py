"""Meshes of blocks, balls and sheets, and a check of their signed distance against formulas."""

import numpy as np
import trimesh

from tests.support.oracles import union_distance
from weavesim.tools.mesh_tool import MeshSurface
from weavesim.tools.sampling import exact_distance

LEFT, RIGHT = (-0.05, 0.0, 0.0), (0.05, 0.0, 0.0)
SIZE = (0.06, 0.05, 0.04)


def box(size=SIZE, centre=(0.0, 0.0, 0.0), inverted=False, cuts=0):
    mesh = trimesh.creation.box(size)
    for _ in range(cuts):
        mesh = mesh.subdivide()
    return mesh.vertices + np.array(centre), mesh.faces[:, ::-1] if inverted else mesh.faces


def ball(radius=0.03, centre=(0.0, 0.0, 0.0), inverted=False):
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=radius)
    return mesh.vertices + np.array(centre), mesh.faces[:, ::-1] if inverted else mesh.faces


def together(*meshes):
    first = np.cumsum([0, *(len(vertices) for vertices, _ in meshes[:-1])])
    return np.concatenate([v for v, _ in meshes]), np.concatenate(
        [f + k for (_, f), k in zip(meshes, first, strict=True)]
    )


def shuffled(mesh):
    return mesh[0], np.random.default_rng(0).permutation(mesh[1])


def sheet(size=0.2, count=9, height=0.0):
    line = np.linspace(-0.5 * size, 0.5 * size, count)
    x, y = np.meshgrid(line, line, indexing="ij")
    vertices = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)])
    index = np.arange(count**2).reshape(count, count)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    return vertices, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def points_about(vertices, count=4000):
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    margin = 0.2 * (high - low).max()
    return np.random.default_rng(0).uniform(low - margin, high + margin, (count, 3))


def notes(surface):
    return " ".join(surface.notes())


def agrees(mesh, boxes, **options):
    """The surface of a mesh whose distance is that of a union of boxes: exact outside, of the right sign inside."""
    surface = MeshSurface(*mesh, **options)
    points = points_about(mesh[0])
    expected, value = union_distance(points, boxes), exact_distance(surface, points)
    outside = expected > 0.0
    assert 0.02 < outside.mean() < 0.98
    np.testing.assert_allclose(value[outside], expected[outside], atol=2e-6)
    assert np.all(value[~outside] < 0.0)
    return surface


def repeated(mesh, times=2, flip=False, part=1.0):
    vertices, faces = mesh
    count = int(part * len(faces))
    return vertices, np.concatenate([faces, *[faces[:count, ::-1] if flip else faces[:count]] * (times - 1)])
