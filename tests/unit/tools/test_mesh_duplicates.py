"""Triangles that a mesh has more than once: removed and counted, whatever their winding and order."""

import numpy as np
import pytest

from tests.support.solids import LEFT, RIGHT, SIZE, agrees, box, notes, repeated, sheet, shuffled, together
from weavesim.tools import mesh_duplicates
from weavesim.tools.mesh_duplicates import _distinct, _triangle_numbers
from weavesim.tools.mesh_tool import MeshSurface
from weavesim.tools.sampling import exact_distance


@pytest.mark.parametrize("soup", [False, True], ids=["welded", "soup"])
@pytest.mark.parametrize(
    ("times", "flip", "part"),
    [(2, False, 1.0), (3, False, 1.0), (2, True, 1.0), (4, True, 1.0), (2, False, 0.5), (2, True, 0.5)],
)
def test_duplicates_of_a_sheet_are_removed_and_counted(times, flip, part, soup):
    vertices, faces = repeated(sheet(), times, flip, part)
    if soup:
        vertices, faces = vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)
    surface = MeshSurface(vertices, faces, side=(0.0, 0.0, 1.0))
    assert not surface.closed and len(surface.faces) == 128
    assert f"{len(faces) - 128} duplicate triangles removed" in notes(surface)
    assert ("all of other winding" in notes(surface)) == (flip and part == 1.0)
    points = np.array([[0.03, 0.01, 0.002], [0.03, 0.01, -0.002], [0.2, 0.0, -0.002]])
    np.testing.assert_allclose(exact_distance(surface, points), [0.002, -0.002, 0.1], atol=1e-6)


@pytest.mark.parametrize(("times", "flip", "part"), [(2, False, 1.0), (2, True, 1.0), (3, True, 1.0), (2, True, 0.4)])
def test_duplicates_of_a_body_are_removed(times, flip, part):
    mesh = repeated(box(cuts=1), times, flip, part)
    surface = agrees(mesh, [(SIZE, (0.0, 0.0, 0.0))])
    assert surface.closed and len(surface.faces) == 48


def test_one_of_two_bodies_twice():
    mesh = together(box(centre=LEFT), repeated(box(centre=RIGHT)))
    agrees(mesh, [(SIZE, LEFT), (SIZE, RIGHT)])
    # the same where they touch along an edge
    mesh = together(box(), repeated(box(centre=(0.06, 0.05, 0.0))))
    agrees(mesh, [(SIZE, (0.0, 0.0, 0.0)), (SIZE, (0.06, 0.05, 0.0))])


def test_a_two_sided_sheet_without_sides_is_asked_for_its_side():
    vertices, faces = sheet()
    faces = np.concatenate([faces, faces[:, ::-1]])
    surface = MeshSurface(vertices, faces)
    assert surface.side == pytest.approx((0.0, 0.0, 1.0)) and "all of other winding" in notes(surface)


@pytest.mark.parametrize("cuts", [0, 1])
def test_blocks_with_a_common_wall_in_a_file_without_order(cuts):
    """Both blocks have the same triangles there, and nothing but these tells that the blocks are two."""
    vertices, faces = box(cuts=cuts)
    mesh = shuffled(together((vertices, faces), ((0.06, 0.0, 0.0) + vertices * (-1.0, 1.0, 1.0), faces[:, ::-1])))
    surface = agrees(mesh, [(SIZE, (0.0, 0.0, 0.0)), (SIZE, (0.06, 0.0, 0.0))])
    assert f"{2 * 4**cuts} triangles between bodies that touch removed" in notes(surface)


@pytest.mark.parametrize("count", [0, 1, 500])
def test_distinct_numbers_are_those_of_numpy(count):
    numbers = np.random.default_rng(0).integers(0, 200, count)
    for found, expected in zip(_distinct(numbers), np.unique(numbers, return_counts=True), strict=True):
        np.testing.assert_array_equal(found, expected)


def test_triangles_have_the_same_numbers_in_one_step_and_in_two(monkeypatch):
    _, faces = shuffled(together(box(cuts=2), box(cuts=2)))
    faces = np.concatenate([faces, faces[::3, [1, 2, 0]], faces[::5, ::-1]])
    at_once = _triangle_numbers(faces)
    monkeypatch.setattr(mesh_duplicates, "LARGEST_CUBE", 0)
    np.testing.assert_array_equal(_triangle_numbers(faces), at_once)
