"""Slip between sheets of different meshes, where it is known."""

import numpy as np
import pytest

from weavesim.measures.slip import interpolated, slip
from weavesim.sheet.blank import Blank

LOWER = Blank.rectangle((-0.05, -0.05), (0.05, 0.05), 0.005)
SQUARE = np.array([(-0.05, -0.05), (0.05, -0.05), (0.05, 0.05), (-0.05, 0.05)])
UPPER = Blank.fitted(SQUARE, 0.006, mesh_angle=30.0, height=0.001)


def test_linear_values_are_exact_on_any_mesh_and_there_are_none_outside():
    points = np.random.default_rng(0).uniform(-0.05, 0.05, (200, 2))
    values = UPPER.material_coordinates @ np.array([[1.0, 2.0], [-3.0, 0.5]]) + (0.1, 0.2)
    wanted = points @ np.array([[1.0, 2.0], [-3.0, 0.5]]) + (0.1, 0.2)
    assert interpolated(UPPER, points, values) == pytest.approx(wanted, abs=1e-12)
    assert np.isnan(interpolated(UPPER, np.array([(0.051, 0.0), (0.2, 0.2)]), values)).all()


def test_sheets_that_lie_still_have_not_slipped():
    found = slip(LOWER, LOWER.node_position, UPPER, UPPER.node_position)
    assert np.abs(found).max() < 1e-12


def test_a_shift_is_the_slip_and_a_distance_is_none():
    moved = UPPER.node_position + (0.003, -0.002, 0.001)
    found = slip(LOWER, LOWER.node_position, UPPER, moved)
    assert found == pytest.approx(np.tile([0.003, -0.002, 0.0], (LOWER.node_count, 1)), abs=1e-12)


def test_on_a_slope_it_is_along_the_slope():
    cosine, sine = np.cos(0.6), np.sin(0.6)
    turn = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
    shifted = (UPPER.node_position + (0.004, 0.0, 0.0)) @ turn.T
    found = slip(LOWER, LOWER.node_position @ turn.T, UPPER, shifted)
    assert found == pytest.approx(np.tile(0.004 * turn[:, 0], (LOWER.node_count, 1)), abs=1e-12)


def test_where_the_upper_sheet_does_not_reach_there_is_none():
    small = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.005, height=0.001)
    found = slip(LOWER, LOWER.node_position, small, small.node_position)
    inside = (np.abs(LOWER.material_coordinates) <= 0.02 + 1e-9).all(axis=1)
    assert np.array_equal(np.isfinite(found).all(axis=1), inside)
