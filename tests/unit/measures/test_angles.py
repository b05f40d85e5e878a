"""Shear angles and yarns of sheets whose answer is known."""

import numpy as np
import pytest

from tests.support.flat_blanks import FULL, HALF_IN_X, HALF_IN_Y, HALF_LENGTH, HALF_WIDTH, QUARTER, blank_of
from weavesim import measures
from weavesim.errors import InputError
from weavesim.measures.angles import located


def odd_angle(blank, factor=30.0):
    return factor * np.prod(blank.element_centres()[:, :2], axis=1)


def test_ten_points_divide_the_line_into_nine_parts():
    points = measures.ten_points(0.235, 0.135)
    assert points.shape == (10, 2)
    assert points[0].tolist() == [0.235, 0.0] and points[-1].tolist() == [0.0, 0.135]
    assert np.ptp(np.diff(points, axis=0), axis=0).max() < 1e-15


@pytest.mark.parametrize("symmetry", [QUARTER, HALF_IN_Y, HALF_IN_X, FULL])
def test_angle_of_an_odd_field_vanishes_on_symmetry_lines_and_is_exact_inside(symmetry):
    blank = blank_of(symmetry)
    points = np.array([[HALF_LENGTH, 0.0], [0.0, HALF_WIDTH], [0.1, 0.0], [0.11, 0.067], [0.0, 0.0], [0.04, 0.033]])
    angles = measures.shear_angle_at(blank, odd_angle(blank), points, symmetry)
    expected = np.abs(np.rad2deg(30.0 * points[:, 0] * points[:, 1]))
    assert angles == pytest.approx(expected, abs=1e-9)


def test_forgetting_the_symmetry_shows_at_the_corner_points():
    blank = blank_of(QUARTER)
    corner = [[HALF_LENGTH, 0.0]]
    assert measures.shear_angle_at(blank, odd_angle(blank), corner)[0] > 1.0


def test_a_mirror_that_swaps_the_yarns_keeps_the_sign():
    blank = blank_of(HALF_IN_X, yarn_angle=45.0)
    even = np.full(blank.element_count, 0.3)
    nodal = measures.smoothed_shear_angle(blank, even, HALF_IN_X)
    assert nodal == pytest.approx(np.full(blank.node_count, 0.3))


@pytest.mark.parametrize("distortion", [0.0, 0.3])
def test_located_weights_give_the_point_back(distortion):
    blank = blank_of(FULL, distortion=distortion, seed=3)
    points = np.random.default_rng(1).uniform((-HALF_LENGTH, -HALF_WIDTH), (HALF_LENGTH, HALF_WIDTH), (50, 2))
    element, weight = measures.locate(blank, points)
    corners = blank.material_coordinates[blank.quads[element]]
    assert np.einsum("kc,kcx->kx", weight, corners) == pytest.approx(points, abs=1e-12)
    assert weight.min() >= -1e-9


def test_a_point_outside_the_blank_is_named():
    with pytest.raises(InputError, match=r"\(0.5, 0\) m lies outside the blank"):
        measures.locate(blank_of(QUARTER), np.array([[0.5, 0.0]]))


def test_points_that_may_lie_outside_are_found_apart():
    blank = blank_of(QUARTER)
    inside = 0.5 * (blank.material_coordinates.min(axis=0) + blank.material_coordinates.max(axis=0))
    element, weight = located(blank, np.array([[0.5, 0.0], inside, [np.nan, 0.0]]))
    assert element.tolist() == [-1, measures.locate(blank, inside)[0][0], -1]
    assert not weight[[0, 2]].any() and weight[1].sum() == pytest.approx(1.0)


def test_yarn_vectors_follow_an_affine_deformation():
    blank = blank_of(FULL, yarn_angle=25.0, distortion=0.2)
    gradient = np.array([[1.1, 0.3, 0.0], [-0.2, 0.9, 0.0], [0.4, 0.1, 1.0]])
    warp, weft = measures.yarn_vectors(blank, blank.node_position @ gradient.T)
    for vector, start in ((warp, blank.warp_direction[0]), (weft, blank.weft_direction[0])):
        expected = gradient @ start / np.linalg.norm(gradient @ start)
        assert vector == pytest.approx(np.tile(expected, (blank.element_count, 1)), abs=1e-12)
