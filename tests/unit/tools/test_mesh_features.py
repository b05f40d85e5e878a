"""Features of tools that decide how finely a sheet must be meshed: sharp edges, fillets, slender bodies."""

import math

import numpy as np
import pytest
import trimesh

from weavesim.tools.mesh_features import face_normals
from weavesim.tools.mesh_repair import edge_products
from weavesim.tools.mesh_tool import MeshShape, MeshSurface
from weavesim.tools.shapes import Capsule, DomePunch, Plane, Sphere, Torus, Union, rotation_matrix
from weavesim.tools.tool import Tool

make = trimesh.creation


def surface(mesh, **options):
    return MeshSurface(mesh.vertices, mesh.faces, **options)


def shape(mesh, **options):
    return MeshShape.from_triangles(mesh.vertices, mesh.faces, **options)


def grid(size=0.4, count=41):
    """Nodes of a flat sheet."""
    line = np.linspace(-0.5 * size, 0.5 * size, count)
    return np.array([(x, y, 0.0) for x in line for y in line])


@pytest.mark.parametrize(
    ("mesh", "width"),
    [
        (make.box((0.003, 0.003, 0.04)), 0.003),
        (make.box((0.008, 0.008, 0.01)), 0.008),
        (make.box((0.001, 0.06, 0.02)), 0.001),
        (make.box((0.3, 0.2, 0.0005)), 0.2),
        (make.cylinder(0.004, 0.03), 0.008),
        (make.annulus(0.05, 0.06, 0.03), 0.01),
        (make.icosphere(5, 0.05), 0.1),
    ],
    ids=["pin", "box", "blade", "plate", "cylinder", "tube", "ball"],
)
def test_width_is_that_of_the_silhouette_along_the_axis(mesh, width):
    assert surface(mesh).smallest_width((0.0, 0.0, 1.0)) == pytest.approx(width, rel=0.07)


def test_width_follows_the_axis_and_the_frame():
    blade = make.box((0.001, 0.06, 0.02))
    turn = rotation_matrix((1.0, 2.0, 0.3), 0.7)
    turned = shape(blade, rotation=turn)
    along = tuple(np.array(turn)[:, 2])
    assert Tool("blade", turned, axis=along).smallest_width == pytest.approx(0.001, rel=0.02)
    assert Tool("blade", turned, axis=np.array(turn)[:, 0]).smallest_width == pytest.approx(0.02, rel=0.02)


def test_the_silhouette_of_a_tool_is_drawn_once(monkeypatch):
    drawn = []
    monkeypatch.setattr("weavesim.tools.mesh_tool.smallest_width", lambda *of: drawn.append(of) or 0.01)
    tool = Tool("box", shape(make.box((0.01, 0.02, 0.03))))
    assert not drawn and tool.smallest_width == tool.smallest_width == 0.01 and len(drawn) == 1
    # along another axis it is another
    assert tool.model_copy(update={"axis": (1.0, 0.0, 0.0)}).smallest_width == 0.01 and len(drawn) == 2


def test_width_of_formulas():
    assert math.isinf(Plane().smallest_width())
    assert Union([Plane(), Sphere(0.004)]).smallest_width() == 0.008
    assert Capsule(0.002, 0.05).smallest_width() == 0.004
    assert Torus(0.003, 0.1).smallest_width() == 0.006
    assert DomePunch(0.03, 0.02).smallest_width() == 0.06


@pytest.mark.parametrize(
    "mesh", [make.box((0.1, 0.1, 0.04)), make.cylinder(0.004, 0.03), make.cone(0.02, 0.05)], ids=["box", "pin", "cone"]
)
def test_a_convex_sharp_edge_has_no_radius(mesh):
    assert surface(mesh).smallest_radius == 0.0


def test_borders_grooves_and_facets_are_no_sharp_edges():
    plate = make.box((0.1, 0.1, 0.01))
    top = plate.faces[plate.face_normals[:, 2] > 0.5]
    assert math.isinf(MeshSurface(plate.vertices, top).smallest_radius)
    # a groove: two planes that rise from x = 0, seen from above and from below
    x, y = np.meshgrid((-0.1, 0.0, 0.1), (-0.1, 0.1), indexing="ij")
    corners = np.column_stack([x.ravel(), y.ravel(), np.abs(x.ravel())])
    faces = [[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]]
    assert math.isinf(MeshSurface(corners, faces, side=(0.0, 0.0, 1.0)).smallest_radius)
    assert MeshSurface(corners, faces, side=(0.0, 0.0, -1.0)).smallest_radius == 0.0
    ball = make.icosphere(4, 0.05)
    assert surface(ball).smallest_radius == pytest.approx(0.05, rel=0.06)


@pytest.mark.parametrize(("place", "count"), [((0, 0, 0.03), 4), ((0, 0, -0.03), 4), ((1.0, 0, 0.03), 0)])
def test_sharp_edges_that_face_the_sheet_are_found(place, count):
    """Those of the face towards the sheet, not those of the back, nor any beyond the sheet."""
    tool = Tool("box", shape(make.box((0.1, 0.1, 0.04)), origin=place))
    edges = tool.sharp_edges_facing(grid())
    assert len(edges) == count
    np.testing.assert_allclose(np.abs(edges[:, 2]), 0.01, atol=1e-12)
    assert math.isinf(tool.fillet_radius)


def test_a_punch_with_a_sharp_back_has_no_sharp_edge_for_the_sheet():
    mesh = DomePunch(0.03, 0.02, display_height=0.01).display_mesh()
    tool = Tool("punch", shape(mesh, origin=(0.0, 0.0, 0.031)))
    assert tool.smallest_radius == 0.0
    assert tool.fillet_radius == pytest.approx(0.03, rel=0.1)
    assert tool.elements_per_quarter_turn(0.005) == pytest.approx(0.5 * math.pi * 6.0, rel=0.1)
    assert len(tool.sharp_edges_facing(grid())) == 0


def test_products_of_edges_are_those_of_numpy_to_the_bit():
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=0.05)
    p, q, r = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    product = np.column_stack(edge_products(mesh.vertices, mesh.faces))
    np.testing.assert_array_equal(product, np.cross(q - p, r - p))
    normal, area = face_normals(mesh.vertices, mesh.faces)
    np.testing.assert_array_equal(area, 0.5 * np.linalg.norm(product, axis=1))
    np.testing.assert_array_equal(normal, product / np.linalg.norm(product, axis=1)[:, None])
