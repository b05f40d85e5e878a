"""Places between nodes, and the surface that directors describe there."""

import numpy as np
import pytest

from weavesim.sheet.samples import (
    Surfaces,
    at_places,
    corner_shares,
    sample_motion,
    sample_places,
    samples_per_side,
    surface_points,
)

SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
RADIUS, SIZE = 0.05, 0.005


def patch_on_a_sphere(distortion: float) -> tuple[np.ndarray, np.ndarray]:
    """Corners of one element on a sphere about the origin, and their normals, (4, 3) each."""
    flat = 0.5 * SIZE * (SQUARE + 2.0 * distortion * np.array([[0.6, -1.0], [-0.3, 0.8], [1.0, 0.4], [-0.9, -0.5]]))
    polar = np.linalg.norm(flat, axis=1) / RADIUS
    normal = np.column_stack([flat / RADIUS * np.sinc(polar / np.pi)[:, None], np.cos(polar)])
    return RADIUS * normal, normal


@pytest.mark.parametrize("side_count", [0, 1, 2, 3])
def test_places_lie_alike_in_all_corners(side_count):
    places = sample_places(side_count)
    assert places.shape == (side_count**2, 2)
    assert np.abs(places).max(initial=0.0) < 1.0
    if side_count:
        # all samples together rest on the four corners alike: that is what bounds their share in the stable step
        assert corner_shares(places)[0].mean(axis=0) == pytest.approx(0.25, abs=1e-15)


@pytest.mark.parametrize(("size", "radius", "count"), [(0.005, 0.0106, 2), (0.008, 0.0035, 4), (0.005, 0.0005, 5)])
def test_sharp_tools_need_more_samples(size, radius, count):
    assert samples_per_side(size, radius) == count


@pytest.mark.parametrize(("distortion", "error"), [(0.0, 0.5e-6), (0.25, 10e-6)])
def test_the_surface_of_corners_on_a_sphere_is_the_sphere(distortion, error):
    corners, directors = patch_on_a_sphere(distortion)
    places = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 9)] * 2), axis=-1).reshape(-1, 2)
    count = len(places)
    points, offset = surface_points(
        np.broadcast_to(corners, (count, 4, 3)), np.broadcast_to(directors, (count, 4, 3)), places
    )
    assert np.abs(np.linalg.norm(points, axis=1) - RADIUS).max() < error
    # the flat facet is its chord
    chord = RADIUS - np.linalg.norm(points - offset, axis=1)
    assert chord.max() == pytest.approx(SIZE**2 / (4.0 * RADIUS), rel=0.4)


def test_the_surface_of_a_plane_is_the_plane_whatever_its_corners():
    corners = np.column_stack([SQUARE + 0.3 * np.random.default_rng(0).normal(size=(4, 2)), np.zeros(4)])
    points, offset = surface_points(corners[None], np.tile([0.0, 0.0, 1.0], (1, 4, 1)), np.array([[0.3, -0.6]]))
    assert points[0, 2] == 0.0
    assert np.all(offset == 0.0)


def test_neighbours_agree_on_their_edge():
    """Both interpolate between its two nodes alone, whatever their other corners are."""
    rng = np.random.default_rng(1)
    corners, directors = rng.normal(size=(2, 2, 4, 3))
    # corners 1 and 2 of the first element are 0 and 3 of the second
    for values in (corners, directors):
        values[1, 0], values[1, 3] = values[0, 1], values[0, 2]
    here, _ = surface_points(corners[:1], directors[:1], np.array([[1.0, 0.4]]))
    there, _ = surface_points(corners[1:], directors[1:], np.array([[-1.0, 0.4]]))
    assert here == pytest.approx(there, abs=1e-14)


@pytest.mark.parametrize("side_count", [1, 2, 3])
def test_no_motion_strains_samples_more_than_its_bound(side_count):
    """Against the largest eigenvalue of the springs of one element, for corners and for directors."""
    rng = np.random.default_rng(2)
    corners = np.column_stack([0.5 * SIZE * (SQUARE + 0.2 * rng.normal(size=(4, 2))), np.zeros(4)])
    places = sample_places(side_count)
    sway, turning = sample_motion(corners[None], places)
    directors = np.tile([0.0, 0.0, 1.0], (4, 1))
    step = 1e-4
    rows = []
    for kind in (corners, directors):
        gradient = np.zeros((len(places), 12))
        for k in range(12):
            heights = []
            for sign in (1.0, -1.0):
                moved = kind.copy()
                moved.ravel()[k] += sign * step * (SIZE if kind is corners else 1.0)
                x, d = (moved, directors) if kind is corners else (corners, moved)
                many = [np.broadcast_to(values, (len(places), 4, 3)) for values in (x, d)]
                heights.append(surface_points(*many, places)[0][:, 2])
            gradient[:, k] = (heights[0] - heights[1]) / (2.0 * step * (SIZE if kind is corners else 1.0))
        rows.append(gradient)
    # lumped masses of a quarter at the corners
    largest = [4.0 * np.linalg.eigvalsh(g.T @ g / len(places))[-1] for g in rows]
    assert 0.5 * sway < largest[0] <= sway
    assert 0.2 * turning < largest[1] <= turning


@pytest.mark.parametrize("count", [1, 7, 300])
def test_surfaces_at_many_places_are_those_at_each(count):
    rng = np.random.default_rng(count)
    corners, directors = rng.normal(size=(2, count, 4, 3))
    places = np.array([(0.0, 0.0), (-1.0, 0.3), (0.5, 0.5)])
    found = Surfaces(places)(*(values.transpose(2, 1, 0) for values in (corners, directors)))
    for own, place in zip(found, places, strict=True):
        expected = surface_points(corners, directors, np.broadcast_to(place, (count, 2)))[0]
        np.testing.assert_array_equal(own, expected)


def test_vectors_of_nodes_at_places_are_shared_by_the_corners():
    quads, values = np.array([[0, 1, 4, 3], [1, 2, 5, 4]]), np.random.default_rng(1).normal(size=(6, 3))
    shares = corner_shares(np.array([(0.0, 0.0), (-1.0, -1.0), (0.5, -0.5)]))[0]
    found = at_places(shares, values, quads)
    np.testing.assert_allclose(found, np.einsum("sc,eci->sei", shares, values[quads]), rtol=1e-15, atol=1e-15)
    np.testing.assert_array_equal(found[1], values[quads[:, 0]])
