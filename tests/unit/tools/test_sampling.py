"""Sampled distances where samples alone would fail: thin walls, wedges, far origins, strays; and their error."""

from functools import cache

import numpy as np
import pytest
import trimesh

from tests.support.oracles import box_distance, triangle_distance
from tests.support.runs import small_run
from tests.support.solids import ball, box, together
from weavesim.errors import InputError
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.sampling import sample_meshes, sampled_distance
from weavesim.tools.shapes import rotation_matrix
from weavesim.tools.tool import Tool


def shape(mesh, **options):
    return MeshShape.from_triangles(*mesh, **options)


@cache
def clean_ball():
    return shape(ball())


def distance(mesh_shape, points):
    return Tool("tool", mesh_shape).distance(points)


# --- thin walls -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("wall", [0.0001, 0.0002, 0.0005, 0.001, 0.002])
def test_a_thin_plate_has_an_inside(wall):
    plate = shape(box((0.3, 0.2, wall), (0.0, 0.0, -0.5 * wall)))
    points = np.array([[0.01, 0.02, z] for z in (0.0006, 0.0, -0.4 * wall, -0.5 * wall, -0.8 * wall, -wall - 0.0003)])
    value, normal = distance(plate, points)
    np.testing.assert_allclose(value, [0.0006, 0.0, -0.4 * wall, -0.5 * wall, -0.2 * wall, 0.0003], atol=1e-7)
    # pushed out on the nearer side
    np.testing.assert_allclose(normal[[0, 2, 4, 5], 2], [1.0, 1.0, -1.0, -1.0], atol=1e-4)


@pytest.mark.parametrize("turn", [0.0, 0.4, 1.1])
def test_a_thin_plate_in_any_frame(turn):
    size = (0.3, 0.2, 0.0005)
    matrix = np.array(rotation_matrix((1.0, 2.0, 0.5), turn))
    plate = shape((box(size)[0] @ matrix.T + (0.4, -0.2, 0.1), box(size)[1]))
    random = np.random.default_rng(0)
    points = random.uniform(-0.5, 0.5, (3000, 3)) * (0.32, 0.22, 0.004)
    value, normal = distance(plate, points @ matrix.T + (0.4, -0.2, 0.1))
    expected = box_distance(points, size)
    # a share of the spacing is allowed in the middle of a cell of samples
    tolerance = sampled_distance(plate.surface).tolerance
    np.testing.assert_allclose(value, expected, atol=2.0 * tolerance)
    inner = np.all(np.abs(points[:, :2]) < (0.145, 0.095), axis=1)
    np.testing.assert_allclose(value[inner], expected[inner], atol=2.5e-5)
    between = inner & (np.abs(points[:, 2]) < 0.0004)
    np.testing.assert_allclose(value[between], expected[between], atol=1e-6)
    clear = inner & (np.abs(np.abs(points[:, 2]) - 0.00025) > 1e-5) & (np.abs(points[:, 2]) > 1e-5)
    clear &= between
    np.testing.assert_allclose((normal @ matrix)[clear, 2], np.sign(points[clear, 2]), atol=1e-3)


@pytest.mark.parametrize("wall", [0.0003, 0.0005, 0.0012])
def test_the_shell_of_a_punch_has_a_wall(wall):
    """A hollow ball: solid between two radii, whatever the file says of the inner surface."""
    outer, inner = (trimesh.creation.icosphere(subdivisions=4, radius=0.05 - depth) for depth in (0.0, wall))
    shell = shape(together((outer.vertices, outer.faces), (inner.vertices, inner.faces)))
    direction = np.random.default_rng(1).normal(size=(2000, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    depth = np.random.default_rng(2).uniform(-0.002, 0.002 + wall, (2000, 1))
    value, normal = distance(shell, (0.05 - depth) * direction)
    expected = np.maximum(-depth, depth - wall)[:, 0]
    # facets lie up to 80 um inside the ball
    np.testing.assert_allclose(value, expected, atol=9e-5)
    out = np.einsum("ij,ij->i", normal, direction)
    assert np.all(out[depth[:, 0] < 0.5 * wall - 1e-4] > 0.99)
    assert np.all(out[depth[:, 0] > 0.5 * wall + 1e-4] < -0.99)


@pytest.mark.parametrize("ribs", [1, 3])
def test_an_open_sheet_with_a_blade(ribs):
    """Ribs of 0.4 mm on a flat die, each a pair of steep faces in one sheet: solid within."""
    outline = [(-0.15, 0.0)]
    for k in range(ribs):
        x = 0.05 * (k - 0.5 * (ribs - 1))
        outline += [(x - 0.0002, 0.0), (x - 0.0002, 0.01), (x + 0.0002, 0.01), (x + 0.0002, 0.0)]
    outline.append((0.15, 0.0))
    x, z = np.array(outline).T
    vertices = np.concatenate([np.column_stack([x, np.full_like(x, y), z]) for y in (-0.1, 0.1)])
    k, n = np.arange(len(x) - 1), len(x)
    faces = np.concatenate([np.column_stack([k, k + 1, k + n + 1]), np.column_stack([k, k + n + 1, k + n])])
    die = shape((vertices, faces), side=(0.0, 0.0, 1.0))
    x = 0.05 * (ribs - 1) / 2
    points = np.array([[x + dx, 0.03, z] for dx, z in ((0.0, 0.005), (0.0005, 0.005), (-0.0005, 0.005), (0.0, 0.0103))])
    np.testing.assert_allclose(distance(die, points)[0], [-0.0002, 0.0003, 0.0003, 0.0003], atol=1e-6)


def test_a_wedge_that_ends_in_an_edge():
    corners = [(-0.1, y, z) for y in (-0.1, 0.1) for z in (-0.01, 0.01)] + [(0.1, y, 0.0) for y in (-0.1, 0.1)]
    hull = trimesh.convex.convex_hull(np.array(corners))
    wedge = shape((hull.vertices, hull.faces))
    random = np.random.default_rng(3)
    points = random.uniform(-1.0, 1.0, (2000, 3)) * (0.12, 0.08, 0.012)
    value = distance(wedge, points)[0]
    reach = sampled_distance(wedge.surface).reach
    unsigned = triangle_distance(points, hull.vertices, hull.faces)
    inside = (np.abs(points[:, 2]) < 0.05 * (0.1 - points[:, 0])) & (points[:, 0] > -0.1)
    near = unsigned < 0.5 * reach
    np.testing.assert_allclose(value[near], np.where(inside, -unsigned, unsigned)[near], atol=1.2e-4)
    thin = near & (points[:, 0] > 0.05)
    assert np.count_nonzero(thin & inside) > 10
    clear = thin & (unsigned > 1e-5)
    np.testing.assert_array_equal(value[clear] < 0.0, inside[clear])


# --- far, stray, and small things ------------------------------------------------------------------------------------


@pytest.mark.parametrize("far", [(15.0, -12.0, 3.0), (1000.0, 0.0, 0.0)])
def test_a_mesh_far_from_its_origin(far):
    vertices, faces = box((0.3, 0.2, 0.0005))
    there = shape((vertices + np.array(far), faces), origin=-np.array(far))
    points = np.random.default_rng(4).uniform(-1.0, 1.0, (500, 3)) * (0.14, 0.09, 0.002)
    np.testing.assert_allclose(distance(there, points)[0], box_distance(points, (0.3, 0.2, 0.0005)), atol=1e-6)


@pytest.mark.parametrize("kind", ["unused", "of a degenerate triangle", "of a flat triangle"])
def test_a_stray_vertex_changes_nothing(kind):
    vertices, faces = ball()
    vertices = np.concatenate([vertices, [(5.0, 5.0, 5.0), (2.5, 2.5, 2.5)]])
    n = len(vertices)
    further = {
        "unused": [],
        "of a degenerate triangle": [[0, n - 2, n - 2]],
        "of a flat triangle": [[n - 2, n - 2, n - 1]],
    }
    faces = np.concatenate([faces, np.array(further[kind], dtype=int).reshape(-1, 3)])
    stray, clean = shape((vertices, faces)), clean_ball()
    assert sampled_distance(stray.surface).spacing == pytest.approx(sampled_distance(clean.surface).spacing, rel=1e-9)
    points = np.random.default_rng(5).uniform(-0.04, 0.04, (500, 3))
    np.testing.assert_allclose(distance(stray, points)[0], distance(clean, points)[0], atol=1e-7)


@pytest.mark.parametrize("away", [0.5, 3.0])
def test_a_far_fleck_is_told_and_spoils_nothing(away):
    flecked = shape(together(ball(), box((0.001, 0.001, 0.001), (away, 0.0, away))))
    surface = flecked.surface
    assert "12 triangles, 1.73 mm across, lie far from the rest" in " ".join(surface.notes())
    direction = np.random.default_rng(6).normal(size=(500, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    value = distance(flecked, 0.031 * direction)[0]
    np.testing.assert_allclose(value, 0.001, atol=4e-4)
    assert sampled_distance(surface).usual_error < 2e-5
    assert distance(flecked, np.array([[away, 0.0, away]]))[0][0] == pytest.approx(-0.0005, abs=1e-6)


# --- the error beside the thickness of the sheet ----------------------------------------------------------------------


@pytest.mark.parametrize("thickness", [0.0001, 0.0005, 0.002])
@pytest.mark.parametrize(
    "mesh", [box((0.3, 0.2, 0.0005)), box((0.2, 0.2, 0.2)), ball(0.1)], ids=["plate", "box", "ball"]
)
def test_the_error_follows_the_thickness_of_the_sheet(mesh, thickness):
    surface = shape(mesh).surface
    sampled = sampled_distance(surface, "cpu", thickness)
    assert sampled.usual_error < 0.1 * thickness
    assert sampled_distance(surface, "cpu", thickness) is sampled
    assert sampled.tolerance <= 0.08 * thickness


def coarse_errors(monkeypatch, share):
    """Samples that are believed although they err by ``share`` of the thickness of 1 mm."""
    monkeypatch.setattr(
        "weavesim.tools.sampling._errors", lambda *_: (np.zeros((1000, 3)), np.full(1000, share * 1e-3))
    )


def test_an_error_of_half_the_thickness_is_refused(monkeypatch):
    coarse_errors(monkeypatch, 0.51)
    with pytest.raises(
        InputError, match=r"tool 0: its distance errs by 0.51 mm near the surface .* 51 % of the sheet's"
    ):
        sample_meshes([Tool("tool", shape(ball()))], "cpu", 1e-3)
    coarse_errors(monkeypatch, 0.49)
    sample_meshes([Tool("tool", shape(ball()))], "cpu", 1e-3)


def test_a_smaller_error_is_a_doubt_of_the_run(monkeypatch):
    coarse_errors(monkeypatch, 0.25)
    tool = Tool("ball", shape(ball(), origin=(0.0, 0.0, -0.032)))
    info = small_run(tools=[tool]).prepare().info
    assert any("ball 0: its distance errs by 0.25 mm near the surface" in warning for warning in info.warnings)
