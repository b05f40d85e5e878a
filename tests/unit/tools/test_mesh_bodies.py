"""Bodies and sheets of one mesh: each has its own inside, whatever the file says, and what has none is refused."""

import numpy as np
import pytest

from tests.support.oracles import box_distance, union_distance
from tests.support.solids import LEFT, RIGHT, SIZE, agrees, ball, box, notes, points_about, sheet, shuffled, together
from weavesim.errors import InputError
from weavesim.tools.mesh_bodies import winding_numbers
from weavesim.tools.mesh_tool import MeshShape, MeshSurface
from weavesim.tools.sampling import exact_distance
from weavesim.tools.tool import Tool

# --- bodies that lie apart, touch, overlap, or contain each other ----------------------------------------------------


@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize("second", [False, True])
def test_each_body_is_turned_outwards_by_itself(first, second):
    mesh = together(box(centre=LEFT, inverted=first), box(centre=RIGHT, inverted=second))
    surface = agrees(mesh, [(SIZE, LEFT), (SIZE, RIGHT)])
    assert surface.closed and "2 closed bodies" in notes(surface)
    turned = first + second
    assert (f"{turned} of them faced inwards" in notes(surface)) == bool(turned)


def test_three_bodies_of_which_two_face_inwards_and_one_is_disordered():
    faces = box()[1].copy()
    faces[::3] = faces[::3, ::-1]
    middle = (box()[0] + (0.0, 0.15, 0.0), faces)
    mesh = together(box(centre=LEFT, inverted=True), middle, box(centre=RIGHT, inverted=True))
    agrees(mesh, [(SIZE, LEFT), (SIZE, RIGHT), (SIZE, (0.0, 0.15, 0.0))])


def test_an_inverted_file_is_turned():
    agrees(box(inverted=True, cuts=2), [(SIZE, (0.0, 0.0, 0.0))])


TOUCHING = {
    "face with the same triangles": ((0.06, 0.0, 0.0), 0),
    "face with the same triangles, finer": ((0.06, 0.0, 0.0), 2),
    "face with other triangles": ((0.06, 0.01, 0.005), 1),
    "edge": ((0.06, 0.05, 0.0), 0),
    "edge of other division": ((0.06, 0.05, 0.01), 1),
    "corner": ((0.06, 0.05, 0.04), 0),
    "overlap": ((0.03, 0.02, 0.01), 0),
    "overlap with coplanar faces": ((0.03, 0.0, 0.0), 1),
}


@pytest.mark.parametrize("inverted", [False, True], ids=["", "inverted"])
@pytest.mark.parametrize("case", TOUCHING)
def test_bodies_that_touch_or_overlap_are_one_solid(case, inverted):
    shift, cuts = TOUCHING[case]
    mesh = together(box(cuts=cuts), box(centre=shift, inverted=inverted, cuts=cuts))
    surface = agrees(mesh, [(SIZE, (0.0, 0.0, 0.0)), (SIZE, shift)])
    assert surface.closed
    if "edge" not in case and "corner" not in case:
        # no wall is left inside
        middle = 0.5 * np.array(shift)
        assert exact_distance(surface, middle[None])[0] < -0.009


def test_a_row_of_blocks_that_share_walls_is_one_body():
    mesh = together(*(box(centre=(0.06 * i, 0.05 * j, 0.0)) for i in range(3) for j in range(2)))
    surface = agrees(mesh, [((0.18, 0.1, 0.04), (0.06, 0.025, 0.0))])
    assert "6 of 6 solids meet and are united" in notes(surface)
    assert exact_distance(surface, np.array([[0.06, 0.025, 0.0]]))[0] == pytest.approx(-0.02, abs=1e-6)


def test_overlapping_balls_have_the_distance_of_their_union():
    centres = np.array([(-0.015, 0.0, 0.0), (0.02, 0.0, 0.0), (0.0, 0.02, 0.01)])
    mesh = together(*(ball(centre=tuple(c), inverted=k == 1) for k, c in enumerate(centres)))
    surface = MeshSurface(*mesh)
    points = points_about(mesh[0])
    expected = np.min([np.linalg.norm(points - c, axis=1) - 0.03 for c in centres], axis=0)
    value = exact_distance(surface, points)
    clear = np.abs(expected) > 1e-3
    np.testing.assert_array_equal(np.sign(value[clear]), np.sign(expected[clear]))
    # facets lie up to 0.2 mm inside the balls
    np.testing.assert_allclose(value[expected > 0], expected[expected > 0], atol=4e-4)


@pytest.mark.parametrize("inner", [False, True])
@pytest.mark.parametrize("outer", [False, True])
def test_a_shell_within_a_body_is_its_cavity(outer, inner):
    mesh = together(box((0.1, 0.1, 0.1), inverted=outer), box(inverted=inner))
    surface = MeshSurface(*mesh)
    points = points_about(mesh[0])
    solid = (box_distance(points, (0.1, 0.1, 0.1)) < 0.0) & (box_distance(points, SIZE) > 0.0)
    np.testing.assert_array_equal(exact_distance(surface, points) < 0.0, solid)
    assert "1 closed surfaces lie inside another and are cavities" in notes(surface)


def test_a_body_in_a_cavity_is_solid():
    sizes = [(0.1, 0.1, 0.1), SIZE, (0.02, 0.02, 0.02)]
    mesh = together(*(box(size) for size in sizes))
    points = points_about(mesh[0])
    outer, cavity, inner = (box_distance(points, size) for size in sizes)
    solid = ((outer < 0.0) & (cavity > 0.0)) | (inner < 0.0)
    surface = MeshSurface(*mesh)
    np.testing.assert_array_equal(exact_distance(surface, points) < 0.0, solid)
    assert "1 bodies lie in such cavities" in notes(surface)


# --- bodies and sheets in one file ------------------------------------------------------------------------------------


@pytest.mark.parametrize("height", [0.0, 0.05, -0.05])
def test_a_body_beside_a_sheet(height):
    """The sheet is solid below, down to the end; the box stands on it, above it, or below it."""
    mesh = together(sheet(), box(centre=(0.02, 0.0, height + 0.02), inverted=True))
    surface = MeshSurface(*mesh, side=(0.0, 0.0, 1.0))
    assert not surface.closed and "closed bodies and an open sheet (32 open edges" in notes(surface)
    points = points_about(mesh[0])
    boxes = [((0.2, 0.2, 2.0), (0.0, 0.0, -1.0)), (SIZE, (0.02, 0.0, height + 0.02))]
    expected, value = union_distance(points, boxes), exact_distance(surface, points)
    np.testing.assert_array_equal(value < 0.0, expected < 0.0)
    # the walls are about a metre deep, in single precision
    np.testing.assert_allclose(value[expected > 0], expected[expected > 0], atol=4e-6)


# --- what has no inside -----------------------------------------------------------------------------------------------


def moebius(count=60):
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    rim = [
        np.column_stack(
            [
                (0.1 + s * np.cos(angle / 2)) * np.cos(angle),
                (0.1 + s * np.cos(angle / 2)) * np.sin(angle),
                s * np.sin(angle / 2),
            ]
        )
        for s in (-0.02, 0.02)
    ]
    k = np.arange(count)
    after = (k + 1) % count
    low, high, low_next, high_next = k, k + count, after.copy(), after + count
    low_next[-1], high_next[-1] = high_next[-1], low_next[-1]
    faces = np.concatenate([np.column_stack([low, low_next, high_next]), np.column_stack([low, high_next, high])])
    return np.concatenate(rim), faces


def with_inner_wall():
    vertices, faces = box()
    places = [(-0.03, -0.025, -0.02), (0.03, -0.025, 0.02), (0.03, 0.025, 0.02), (-0.03, 0.025, -0.02)]
    a = [int(np.argmin(np.linalg.norm(vertices - place, axis=1))) for place in places]
    # the diagonals of the two ends must be edges
    return vertices, np.concatenate([_with_diagonals(vertices, faces, a), [[a[0], a[1], a[2]], [a[0], a[2], a[3]]]])


def _with_diagonals(vertices, faces, a):
    kept = faces[np.ptp(vertices[faces][:, :, 1], axis=1) > 1e-9]
    ends = []
    for one, other in ((a[0], a[1]), (a[3], a[2])):
        of_end = [k for k in range(8) if np.isclose(vertices[k, 1], vertices[one, 1]) and k not in (one, other)]
        ends += [[one, other, k] for k in of_end]
    return np.concatenate([kept, ends])


def with_a_fin():
    vertices, faces = box()
    edge = [int(np.argmin(np.linalg.norm(vertices - c, axis=1))) for c in ((0.03, -0.025, 0.02), (0.03, 0.025, 0.02))]
    out = vertices[edge] + (0.05, 0.0, 0.0)
    return np.concatenate([vertices, out]), np.concatenate([faces, [[*edge, 9], [edge[0], 9, 8]]])


@pytest.mark.parametrize(
    ("mesh", "says"),
    [
        (moebius(), r"about \(.*\) mm has one side only, like a Moebius strip"),
        (with_inner_wall(), r"open surface is attached to a closed body at 4 edges, one at \(.*\) mm"),
        (shuffled(with_inner_wall()), r"more than two surfaces meet at 4 edges, one at \(.*\) mm"),
        (with_a_fin(), r"open surface is attached to a closed body at 1 edges, one at \(30, 0, 20\) mm"),
        (
            (ball()[0], ball()[1][1:]),
            r"3 open edges in one loop of 3 edges, .* mm across, at \(.*\) mm.*close its holes",
        ),
        ((ball()[0], ball()[1][200:]), "close its holes"),
        (
            together(box(), (np.array([(0.0, 0.0, 1.0), (1e-3, 0.0, 1.0), (0.0, 1e-3, 1.0)]), np.array([[0, 1, 2]]))),
            r"closed bodies and an open sheet \(3 open edges.*probably a leftover",
        ),
    ],
    ids=["moebius", "inner wall", "inner wall in disorder", "fin", "missing triangle", "missing cap", "leftover"],
)
def test_what_has_no_inside_is_refused_with_its_place(mesh, says):
    with pytest.raises(InputError, match=says):
        MeshSurface(*mesh)


def test_a_plate_that_lacks_a_triangle_is_no_sheet():
    vertices, faces = box((0.2, 0.2, 0.01))
    bottom = np.flatnonzero(np.all(vertices[faces][:, :, 2] < 0.0, axis=1))
    with pytest.raises(InputError, match=r"open sheet \(3 open edges.*50 % as much.*close its holes"):
        MeshSurface(vertices, np.delete(faces, bottom[0], axis=0), side=(0.0, 0.0, 1.0))


def test_winding_numbers_count_the_bodies_around_a_point():
    vertices, faces = together(box((0.1, 0.1, 0.1)), box())
    points = np.array([[0.0, 0.0, 0.0], [0.04, 0.0, 0.0], [0.06, 0.0, 0.0]])
    np.testing.assert_allclose(winding_numbers(vertices, faces, points), [2.0, 1.0, 0.0], atol=1e-12)


def crossing_tube(turns, count=240, radius=0.004):
    """A closed tube along a figure of eight or more loops, which crosses itself."""
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    path = 0.05 * np.column_stack([np.sin(turns[0] * angle), np.sin(turns[1] * angle), np.zeros(count)])
    along = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.column_stack([-along[:, 1], along[:, 0], np.zeros(count)])
    ring = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    up = np.array([0.0, 0.0, 1.0])
    vertices = path[:, None] + radius * (
        np.cos(ring)[None, :, None] * across[:, None] + np.sin(ring)[None, :, None] * up
    )
    i, j = np.meshgrid(np.arange(count), np.arange(12), indexing="ij")
    a, b = (12 * i + j).ravel(), (12 * ((i + 1) % count) + j).ravel()
    c, d = (12 * ((i + 1) % count) + (j + 1) % 12).ravel(), (12 * i + (j + 1) % 12).ravel()
    return path, (vertices.reshape(-1, 3), np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])]))


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("turns", [(1, 2), (2, 3)])
def test_a_body_that_crosses_itself_is_solid_where_it_does(turns, inverted):
    path, (vertices, faces) = crossing_tube(turns)
    shape = MeshShape.from_triangles(vertices, faces[:, ::-1] if inverted else faces)
    surface = shape.surface
    points = np.random.default_rng(7).uniform(-1.0, 1.0, (3000, 3)) * (0.06, 0.06, 0.006)
    points = np.concatenate([points, np.random.default_rng(8).uniform(-1.0, 1.0, (500, 3)) * 0.005])
    expected = np.min(np.linalg.norm(points[:, None] - path[None], axis=2), axis=1) - 0.004
    clear = np.abs(expected) > 4e-4
    np.testing.assert_array_equal((exact_distance(surface, points) < 0.0)[clear], (expected < 0.0)[clear])
    value = Tool("tube", shape).distance(points)[0]
    clear &= np.abs(expected) > 8e-4
    np.testing.assert_array_equal((value < 0.0)[clear], (expected < 0.0)[clear])
