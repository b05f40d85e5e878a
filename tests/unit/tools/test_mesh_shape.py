"""Tools from triangle meshes: sampled distances against closed forms, open sheets, repairs, and refusals."""

import math

import numpy as np
import pytest
import trimesh

from weavesim.errors import InputError
from weavesim.tools.mesh_tool import MeshShape, MeshSurface
from weavesim.tools.sampling import exact_distance, sampled_distance
from weavesim.tools.shapes import DomeOpening, DomePunch, Sphere, rotation_matrix
from weavesim.tools.tool import Tool

RADIUS = 0.05
BALL = trimesh.creation.icosphere(subdivisions=4, radius=RADIUS)
# An icosphere of 5120 facets lies inside its ball by at most this.
FACET_SAG = RADIUS - np.linalg.norm(BALL.triangles_center, axis=1).min()


def lower_half(mesh=BALL):
    return mesh.vertices, mesh.faces[mesh.triangles_center[:, 2] < 0.0]


def shell_points(gap: float, count: int = 5000) -> np.ndarray:
    random = np.random.default_rng(1)
    direction = random.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return direction * (RADIUS + random.uniform(-gap, gap, (count, 1)))


def distance(shape, points):
    return Tool("tool", shape).distance(points)


def sheet(corner_count: int = 11, size: float = 0.2, height=lambda x, y: 0.0 * x):
    """A square sheet about the origin, facing +z."""
    line = np.linspace(-0.5 * size, 0.5 * size, corner_count)
    x, y = np.meshgrid(line, line, indexing="ij")
    vertices = np.column_stack([x.ravel(), y.ravel(), height(x, y).ravel()])
    index = np.arange(corner_count**2).reshape(corner_count, corner_count)
    a, b, c, d = (part.ravel() for part in (index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]))
    return vertices, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


@pytest.fixture(scope="module")
def ball():
    return MeshShape.from_triangles(BALL.vertices, BALL.faces, spacing=0.0012)


@pytest.fixture(scope="module")
def flat():
    return MeshShape.from_triangles(*sheet(), spacing=0.001, reach=0.006)


def test_sampled_ball_is_the_ball_within_facets_and_samples(ball):
    points = shell_points(0.004)
    value, normal = distance(ball, points)
    exact, radial = distance(Sphere(RADIUS), points)
    # a sample interval h over a curvature 1/R costs up to h^2 / 4 R in two directions
    allowed = FACET_SAG + 0.0012**2 / (4 * RADIUS)
    assert np.abs(value - exact).max() < allowed
    assert np.abs(value - exact).max() > 0.1 * allowed  # the bound is not idle
    assert np.einsum("ij,ij->i", normal, radial).min() > math.cos(0.05)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=1e-6)


def test_measured_error_is_that_of_independent_points(ball):
    sampled = sampled_distance(ball.surface)
    points = shell_points(0.002)
    error = distance(ball, points)[0] - exact_distance(ball.surface, points)
    assert 0.5 * sampled.largest_error < np.abs(error).max() < 1.5 * sampled.largest_error
    assert sampled.mean_error < sampled.usual_error < sampled.largest_error < 0.05e-3
    assert np.sqrt(np.mean(error**2)) == pytest.approx(sampled.mean_error, rel=0.3)
    assert "ball: distance sampled every 1.2 mm" in sampled.note("ball")


def test_finer_samples_have_a_smaller_error():
    coarse, fine = (MeshShape.from_triangles(BALL.vertices, BALL.faces, spacing=h) for h in (0.004, 0.002))
    assert sampled_distance(fine.surface).mean_error < 0.4 * sampled_distance(coarse.surface).mean_error


def test_open_half_of_a_ball_agrees_with_the_whole_ball(ball):
    half = MeshShape.from_triangles(*lower_half(), side=(0.0, 0.0, -1.0), spacing=0.0012)
    assert ball.surface.closed and not half.surface.closed
    points = shell_points(0.004)
    points = points[points[:, 2] < -0.01]
    value, normal = distance(half, points)
    exact, radial = distance(Sphere(RADIUS), points)
    assert np.abs(value - exact).max() < FACET_SAG + 0.0012**2 / (4 * RADIUS)
    assert np.einsum("ij,ij->i", normal, radial).min() > math.cos(0.05)


def test_inside_and_far_outside_have_the_right_sign(ball):
    reach = sampled_distance(ball.surface).reach
    value, _ = distance(ball, np.array([[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.0, 0.0, 1.0], [0.055, 0.055, 0.055]]))
    np.testing.assert_allclose(value[:2], -reach, rtol=1e-6)
    # beyond the box: the reach and the distance to the box
    assert value[2] == pytest.approx(1.0 - RADIUS, abs=1e-3)
    assert value[3] == pytest.approx(reach, rel=1e-6)


@pytest.mark.parametrize("sense", [1, -1])
def test_a_sheet_is_solid_behind_its_side_whatever_its_triangles_say(sense):
    vertices, faces = sheet()
    shape = MeshShape.from_triangles(vertices, faces[:, ::-1], side=(0.0, 0.0, sense), spacing=0.002, reach=0.01)
    points = np.array([[0.03, 0.01, 0.003], [0.03, 0.01, -0.003], [-0.02, 0.05, -0.009]])
    value, normal = distance(shape, points)
    np.testing.assert_allclose(value, sense * points[:, 2], atol=1e-6)
    np.testing.assert_allclose(normal, np.tile([0.0, 0.0, sense], (3, 1)), atol=1e-5)


def test_a_sheet_without_a_side_faces_as_its_triangles_do():
    vertices, faces = sheet()
    for order, z in ((faces, 1.0), (faces[:, ::-1], -1.0)):
        surface = MeshSurface(vertices, order)
        np.testing.assert_allclose(surface.side, (0.0, 0.0, z), atol=1e-12)


def test_no_false_inside_beyond_an_open_border(flat):
    random = np.random.default_rng(2)
    points = random.uniform(-1.0, 1.0, (20_000, 3)) * (0.112, 0.112, 0.008)
    value, _ = distance(flat, points)
    reach = sampled_distance(flat.surface).reach
    inside = (np.abs(points[:, :2]).max(axis=1) < 0.1) & (points[:, 2] < 0.0)
    # a column below the sheet, down to the end of the box
    over = np.maximum(np.abs(points) - (0.1, 0.1, np.inf), 0.0)
    over[:, 2] = np.maximum(points[:, 2], 0.0)
    depth = np.minimum(0.1 - np.abs(points[:, :2]).max(axis=1), -points[:, 2])
    expected = np.clip(np.where(inside, -depth, np.linalg.norm(over, axis=1)), -reach, reach)
    in_box = np.all(np.abs(points) <= (0.106, 0.106, 0.006), axis=1)
    # corners of the body are rounded off over one sample
    assert np.abs(value - expected)[in_box].max() < 0.6e-3
    assert np.quantile(np.abs(value - expected)[in_box], 0.9) < 1e-5
    clear = np.abs(expected) > 1e-3
    np.testing.assert_array_equal((value < 0.0)[in_box & clear], inside[in_box & clear])
    assert np.all(value[~in_box] >= reach)


def test_shallow_points_near_a_border_are_pushed_back_up(flat):
    x = np.linspace(-0.0985, 0.0985, 101)
    points = np.column_stack([x, np.full_like(x, 0.03), np.full_like(x, -0.0003)])
    value, normal = distance(flat, points)
    np.testing.assert_allclose(value, -0.0003, atol=1e-6)
    np.testing.assert_allclose(normal[:, 2], 1.0, atol=1e-6)


@pytest.mark.slow
def test_sheet_of_the_die_has_the_distance_of_the_die():
    die = DomeOpening(0.0412, 0.03, 0.01, display_size=(0.22, 0.16), display_depth=0.03)
    mesh = die.display_mesh()
    shape = MeshShape.from_triangles(mesh.vertices, mesh.faces, side=(0.0, 0.0, 1.0))
    assert shape.smallest_radius == pytest.approx(0.01, rel=0.1)
    points, face = trimesh.sample.sample_surface(mesh, 5000, seed=3)
    points = points + np.random.default_rng(3).uniform(-0.002, 0.002, (5000, 1)) * mesh.face_normals[face]
    kept = np.all(np.abs(points) < (0.1, 0.07, 0.024), axis=1)
    value, normal = distance(shape, points[kept])
    exact, exact_normal = distance(die, points[kept])
    spacing = sampled_distance(shape.surface).spacing
    assert spacing <= 0.00105
    # rounding of 10 mm: facets sag by 5e-5 m at most, samples add h^2 / 4 r
    assert np.abs(value - exact).max() < 5e-5 + spacing**2 / (4 * 0.01)
    assert np.quantile(np.einsum("ij,ij->i", normal, exact_normal), 0.001) > math.cos(0.12)


def test_sheet_of_the_punch_is_solid_above():
    punch = DomePunch(0.03, 0.02, display_height=0.01)
    mesh = punch.display_mesh()
    open_faces = mesh.faces[mesh.triangles_center[:, 2] < 0.0099]  # without the lid
    shape = MeshShape.from_triangles(mesh.vertices, open_faces, side=(0.0, 0.0, -1.0), spacing=0.001)
    points = np.random.default_rng(4).uniform(-1.0, 1.0, (5000, 3)) * (0.052, 0.032, 0.032)
    points = points[points[:, 2] < 0.009]
    value = distance(shape, points)[0]
    exact = distance(punch, points)[0]
    near = np.abs(exact) < 0.0045  # values are cut at 6 mm
    np.testing.assert_allclose(value[near], exact[near], atol=1e-4)
    assert np.all(value[exact < -0.0045] < -0.004) and np.any(exact < -0.02)
    assert shape.smallest_radius == pytest.approx(0.03, rel=0.1)


def test_placed_mesh_is_the_mesh_elsewhere(ball):
    turn = rotation_matrix((1.0, 1.0, 0.0), 0.6)
    points = shell_points(0.003, 500)
    vertices, faces = lower_half()
    shape = MeshShape.from_triangles(vertices, faces, side=(0.0, 0.0, -1.0), spacing=0.002)
    value, normal = distance(shape, points)
    moved_value, moved_normal = distance(
        shape.placed((0.3, -0.2, 0.1), turn), points @ np.array(turn).T + (0.3, -0.2, 0.1)
    )
    # the volume is read in single precision
    np.testing.assert_allclose(moved_value, value, atol=1e-7)
    np.testing.assert_allclose(moved_normal @ np.array(turn), normal, atol=1e-3)
    drawn = shape.placed((0.3, -0.2, 0.1), turn).display_mesh()
    assert np.abs(distance(shape.placed((0.3, -0.2, 0.1), turn), drawn.vertices)[0]).max() < 1e-3


def test_drawn_mesh_lies_on_the_sampled_surface(ball):
    assert np.abs(distance(ball, ball.display_mesh().vertices)[0]).max() < 1e-4


def test_half_and_quarter_meshes_are_mirrored():
    ball = Sphere(RADIUS).display_mesh()
    whole = MeshSurface(ball.vertices, ball.faces)
    quarter = ball.submesh([np.all(ball.triangles_center[:, :2] > 0.0, axis=1)], append=True)
    cut = MeshSurface(quarter.vertices, quarter.faces, side=(1.0, 1.0, 0.0))
    assert cut.cut_planes == ["x", "y"] and any('mirror=("x",)' in line for line in cut.notes())
    mirrored = MeshSurface(quarter.vertices, quarter.faces, mirror=("x", "y"))
    assert mirrored.closed and mirrored.cut_planes == []
    points = shell_points(0.004, 500)
    np.testing.assert_allclose(exact_distance(mirrored, points), exact_distance(whole, points), atol=1e-7)
    # a capped half: its cut face goes
    half = trimesh.creation.box((0.1, 0.1, 0.1), transform=trimesh.transformations.translation_matrix((0.05, 0, 0)))
    box = MeshSurface(half.vertices, half.faces, mirror=("x",))
    assert box.closed
    np.testing.assert_allclose(
        exact_distance(box, np.array([[0.0, 0.0, 0.04], [0.08, 0, 0]])), [-0.01, -0.02], atol=1e-7
    )


def test_triangles_that_face_all_ways_are_put_in_order():
    random = np.random.default_rng(5)
    faces = BALL.faces.copy()
    turned = random.random(len(faces)) < 0.5
    faces[turned] = faces[turned][:, ::-1]
    surface = MeshSurface(BALL.vertices, faces)
    assert trimesh.Trimesh(surface.vertices, surface.faces, process=False).volume == pytest.approx(
        BALL.volume, rel=1e-6
    )
    vertices, faces = lower_half()
    turned = random.random(len(faces)) < 0.5
    faces = np.where(turned[:, None], faces[:, ::-1], faces)
    surface = MeshSurface(vertices, faces, side=(0.0, 0.0, -1.0))
    normal = trimesh.Trimesh(surface.vertices, surface.faces, process=False).face_normals
    assert np.all(np.einsum("ij,ij->i", normal, surface.vertices[surface.faces[:, 0]]) > 0.0)


def test_patches_that_only_touch_are_one_sheet():
    """CAD patches share no vertices along a seam: neither a wall of the body nor a gap may appear there."""
    left, faces = sheet(11, 0.1)
    right, other = sheet(8, 0.1)  # other divisions, turned over: the seam has T-junctions
    vertices = np.concatenate([left - (0.05, 0.0, 0.0), right + (0.05, 0.0, 0.0)])
    surface = MeshSurface(vertices, np.concatenate([faces, other[:, ::-1] + len(left)]), side=(0.0, 0.0, 1.0))
    assert surface.open_edge_count == 3 * 10 + 3 * 7
    points = np.column_stack([np.linspace(-0.01, 0.01, 200), np.full(200, 0.0123), np.full(200, -0.003)])
    np.testing.assert_allclose(exact_distance(surface, points), -0.003, atol=1e-7)
    np.testing.assert_allclose(exact_distance(surface, -points), 0.003, atol=1e-7)


def test_triangle_soup_is_welded():
    soup = BALL.vertices[BALL.faces].reshape(-1, 3)
    surface = MeshSurface(soup, np.arange(len(soup)).reshape(-1, 3))
    assert surface.closed and len(surface.vertices) == len(BALL.vertices)


def test_degenerate_triangles_are_removed_and_counted():
    vertices, faces = sheet()
    flat_ones = np.array([[0, 0, 1], [0, 1, 2]])  # a repeated vertex, and three in a line along y
    surface = MeshSurface(vertices, np.concatenate([faces, flat_ones]))
    assert surface.removed_triangle_count == 2
    assert len(surface.faces) == len(faces)
    assert any("2 degenerate triangles removed" in line for line in surface.notes())


@pytest.mark.parametrize("radius", [0.01, 0.04])
def test_smallest_radius_is_that_of_the_rounding(radius):
    torus = trimesh.creation.torus(0.15, radius, major_sections=90, minor_sections=32)
    assert MeshSurface(torus.vertices, torus.faces).smallest_radius == pytest.approx(radius, rel=0.05)


def test_flat_and_hollow_sheets_have_no_convex_radius():
    assert math.isinf(MeshSurface(*sheet()).smallest_radius)
    cup = sheet(21, 0.1, lambda x, y: 2.0 * (x**2 + y**2))
    assert math.isinf(MeshSurface(*cup, side=(0.0, 0.0, 1.0)).smallest_radius)
    assert MeshSurface(*cup, side=(0.0, 0.0, -1.0)).smallest_radius == pytest.approx(0.25, rel=0.1)


@pytest.mark.parametrize("ending", ["stl", "obj", "ply"])
def test_files_of_common_formats_are_read(tmp_path, ending):
    path = tmp_path / f"tool.{ending}"
    mesh = BALL.copy()
    mesh.apply_scale(1000.0)
    mesh.export(path)
    with pytest.raises(InputError, match=r"100 m across.*unit_scale=0\.001"):
        MeshShape.from_file(path)
    shape = MeshShape.from_file(path, unit_scale=0.001, origin=(0.0, 0.0, 0.1))
    assert shape.surface.closed and len(shape.surface.faces) == len(BALL.faces)
    np.testing.assert_allclose(shape.display_mesh().bounds.mean(axis=0), [0.0, 0.0, 0.1], atol=1e-6)


def test_files_that_are_no_mesh_are_refused(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        MeshShape.from_file(tmp_path / "missing.stl")
    for name, content in (("text.stl", "solid nothing"), ("noise.ply", "not a mesh"), ("tool.xyzzy", "1 2 3")):
        path = tmp_path / name
        path.write_text(content)
        with pytest.raises(InputError, match=f"{name}.*(cannot be read|no triangles)"):
            MeshShape.from_file(path)
    points = tmp_path / "points.obj"
    points.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\n")
    with pytest.raises(InputError, match="points.obj"):
        MeshShape.from_file(points)


def _with(vertices, row, value):
    vertices = np.array(vertices)
    vertices[row] = value
    return vertices


@pytest.mark.parametrize(
    ("build", "says"),
    [
        (lambda v, f: MeshSurface(v, f[:0]), "no triangles"),
        (lambda v, f: MeshSurface(_with(v, 7, math.nan), f), "not finite, the first is vertex 7"),
        (lambda v, f: MeshSurface(v[:, :2], f), "shape"),
        (lambda v, f: MeshSurface(v, f + len(v)), "use vertex"),
        (lambda v, f: MeshSurface(1000.0 * v, f), "1000 times too big.*unit_scale=0.001"),
        (lambda v, f: MeshSurface(0.001 * v, f), "too small"),
        (lambda v, f: MeshSurface(0.0 * v + (0.1, 0.0, 0.0), f), "too small"),
        (lambda v, f: MeshSurface(v * (1.0, 0.0, 0.0), f), "degenerate"),
        (lambda v, f: MeshSurface(v, f, side=(1.0, 0.0, 0.0)), "edge-on"),
        (lambda v, f: MeshSurface(v, f, side=(0.0, 0.0, 0.0)), "side"),
        (lambda v, f: MeshSurface(v, f, mirror=("z",)), '"x"'),
        (lambda v, f: MeshSurface(v + (1.0, 0.0, 0.0), f, mirror=("x",)), "must end at the plane"),
        (lambda v, f: MeshSurface(v, f, spacing=-1.0), "spacing"),
        (lambda v, f: MeshSurface(v, f, spacing=0.1), "a tenth of the size"),
        (lambda v, f: MeshSurface(v, f, spacing=0.001, reach=0.002), "four times the spacing"),
        (lambda v, f: sampled_distance(MeshSurface(v, f, spacing=1e-5, reach=0.1)), "at least"),
        (lambda v, f: MeshSurface(BALL.vertices, BALL.faces[1:]), "close its holes"),
        (lambda v, f: MeshSurface(BALL.vertices, BALL.faces[1:], side=(0.0, 0.0, 1.0)), "close its holes"),
        (lambda v, f: MeshShape.from_file("tool.stl", unit_scale=0.0), "unit_scale"),
    ],
)
def test_bad_meshes_are_refused(build, says):
    with pytest.raises(InputError, match=says):
        build(*sheet())
