"""Quadrilaterals and polygons are covered by their triangles, once."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.mesh_files import area_of
from weavesim.meshes.triangles import Crossing, polygon_triangles, quad_triangles, without_repeats

SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)


def star(angles: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Corners around a centre that sees all of them."""
    return np.column_stack([radii * np.cos(angles), radii * np.sin(angles), 0.0 * angles])


def check_covers(nodes: np.ndarray, triangles: np.ndarray) -> None:
    """All areas positive, their sum that of the outline, and every edge of the outline in one triangle."""
    x, y = nodes[:, 0], nodes[:, 1]
    whole = 0.5 * (x * np.roll(y, -1) - np.roll(x, -1) * y).sum()
    areas = area_of(nodes, triangles)[:, 2]
    assert areas.sum() == pytest.approx(whole, rel=1e-9)
    assert np.all(areas > -1e-9 * whole)
    assert len(triangles) == len(nodes) - 2
    edges = {(int(a), int(b)) for t in triangles for a, b in zip(t, np.roll(t, -1), strict=True)}
    assert all((k, (k + 1) % len(nodes)) in edges for k in range(len(nodes)))


@pytest.mark.parametrize("turn", range(4))
@pytest.mark.parametrize("dent", [0.1, 0.3, 0.49])
def test_a_concave_quadrilateral_is_split_inside(turn, dent):
    nodes = np.roll(np.where(np.arange(4)[:, None] == 2, (dent, dent, 0.0), SQUARE), turn, axis=0)
    check_covers(nodes, quad_triangles(nodes, np.arange(4)[None]))


def test_the_shorter_diagonal_is_taken():
    long = SQUARE + np.array([(0, 0, 0), (0, 0, 0), (1, 1, 0), (0, 0, 0)])
    assert quad_triangles(long, np.arange(4)[None]).tolist() == [[0, 1, 3], [1, 2, 3]]
    assert quad_triangles(SQUARE, np.arange(4)[None]).tolist() == [[0, 1, 2], [0, 2, 3]]


def test_a_warped_quadrilateral_is_split():
    warped = SQUARE + np.array([(0, 0, 0.3), (0, 0, 0), (0, 0, 0.3), (0, 0, 0)])
    assert area_of(warped, quad_triangles(warped, np.arange(4)[None]))[:, 2].sum() == pytest.approx(1.0)


@pytest.mark.parametrize("order", [(0, 2, 1, 3), (0, 1, 3, 2)])
def test_a_crossed_quadrilateral_is_found(order):
    with pytest.raises(Crossing) as error:
        quad_triangles(SQUARE * (1.0, 1.2, 1.0), np.array([(0, 1, 2, 3), order]))
    assert error.value.row == 1


@given(
    st.lists(st.tuples(st.floats(0.2, 1.0), st.floats(0.3, 1.0)), min_size=5, max_size=40),
    st.integers(0, 2**32 - 1),
)
@settings(max_examples=150, deadline=None)
def test_polygons_of_any_shape(rows, seed):
    """Star-shaped outlines, in any plane, from any corner."""
    step, radius = np.array(rows).T
    angles = 2.0 * np.pi * np.cumsum(step) / step.sum()
    flat = star(angles, radius)
    triangles = polygon_triangles(flat, np.arange(len(flat))[None])
    check_covers(flat, triangles)
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    moved = 37.0 + 1e3 * flat @ turn.T
    again = polygon_triangles(moved, np.arange(len(flat))[None])
    assert np.linalg.norm(area_of(moved, again).sum(axis=0)) == pytest.approx(
        1e6 * area_of(flat, triangles)[:, 2].sum(), rel=1e-9
    )


@pytest.mark.parametrize("count", [2, 5])
def test_corners_on_straight_sides_are_kept(count):
    """Neighbours may be joined to them."""
    corner = np.array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)], dtype=float)
    share = np.arange(count)[:, None] / count
    plan = np.concatenate([a + share * (b - a) for a, b in zip(corner, np.roll(corner, -1, axis=0), strict=True)])
    nodes = np.column_stack([plan, np.zeros(len(plan))])
    check_covers(nodes, polygon_triangles(nodes, np.arange(len(nodes))[None]))


def test_a_comb_of_a_thousand_teeth():
    x = np.arange(2001.0)
    upper = np.column_stack([x, 1.0 + x % 2, 0.0 * x])[::-1]
    nodes = np.concatenate([[(0, 0, 0), (2000, 0, 0)], upper])
    check_covers(nodes, polygon_triangles(nodes, np.arange(len(nodes))[None]))


@pytest.mark.parametrize("order", [(0, 2, 4, 1, 3), (0, 1, 3, 2, 4), (0, 3, 1, 2, 4)])
def test_a_crossed_polygon_is_found(order):
    angles = 2.0 * np.pi * np.arange(5) / 5
    nodes = star(angles, 1.0 + 0.1 * np.arange(5))
    with pytest.raises(Crossing) as error:
        polygon_triangles(nodes, np.array([range(5), order]))
    assert error.value.row == 1


def test_repeated_corners_are_left_out():
    repeated, shorter = without_repeats(
        np.array([(0, 1, 2, 3), (0, 1, 1, 2), (0, 1, 2, 0), (4, 4, 4, 4), (0, 0, 1, 1)])
    )
    assert repeated.tolist() == [False, True, True, True, True]
    assert [row for row, _ in shorter] == [1, 2, 3, 4]
    assert [sorted(nodes.tolist()) for _, nodes in shorter] == [[0, 1, 2], [0, 1, 2], [4, 4, 4], [0, 1, 1]]
