"""Folded and turned-over elements, and nodes beyond a symmetry plane, on shapes that are known."""

import numpy as np
import pytest

from weavesim.measures.folding import (
    beyond_symmetry,
    directors_apart,
    facing,
    folded_elements,
    folded_pairs,
    neighbours,
)
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import Symmetry

BLANK = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)


def one_quad(angle: float, diagonal: int) -> np.ndarray:
    """A unit square folded along a diagonal by an angle [degrees]."""
    square = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    start, end, moved = (square[0], square[2], 1) if diagonal == 0 else (square[1], square[3], 2)
    axis = (end - start) / np.linalg.norm(end - start)
    foot = start + ((square[moved] - start) @ axis) * axis
    out, turn = square[moved] - foot, np.deg2rad(angle)
    square[moved] = foot + np.cos(turn) * out + np.sin(turn) * np.linalg.norm(out) * np.array([0.0, 0.0, 1.0])
    return square


@pytest.mark.parametrize("diagonal", [0, 1])
@pytest.mark.parametrize(("angle", "folded"), [(0.0, False), (60.0, False), (89.0, False), (91.0, True), (179.0, True)])
def test_an_element_is_folded_beyond_a_right_angle(diagonal, angle, folded):
    assert folded_elements(one_quad(angle, diagonal), np.array([[0, 1, 2, 3]])).tolist() == [folded]


@pytest.mark.parametrize(
    ("angle", "folded"), [(0.0, False), (90.0, False), (169.0, False), (171.0, True), (180.0, True)]
)
def test_neighbours_are_folded_onto_each_other_by_nearly_half_a_turn(angle, folded):
    turn = np.deg2rad(180.0 - angle)
    x = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0], [np.cos(turn), 0.0, np.sin(turn)]])
    position = np.concatenate([x, x + (0.0, 1.0, 0.0)])
    quads = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
    pairs = neighbours(quads)
    assert pairs.tolist() == [[0, 1]] and folded_pairs(position, quads, pairs).tolist() == [folded]


def test_neighbours_are_those_with_a_common_edge():
    pairs = neighbours(BLANK.quads)
    assert len(pairs) == 2 * 4 * 3
    assert all(len(set(BLANK.quads[a]) & set(BLANK.quads[b])) == 2 for a, b in pairs)


def test_directors_are_apart_where_they_swing_and_not_where_the_sheet_bends():
    """Normals of a cylinder and of a saddle are the same at both diagonals; those that swing by 20 degrees are not."""
    x, y, _ = BLANK.node_position.T
    zero, one = np.zeros_like(x), np.ones_like(x)
    bent = np.column_stack([np.sin(80.0 * x), zero, np.cos(80.0 * x)])
    twisted = np.column_stack([-30.0 * y, -30.0 * x, one])
    for director in (bent, twisted / np.linalg.norm(twisted, axis=1)[:, None]):
        assert directors_apart(director, BLANK.quads).max() < 0.02
    sign = np.where(np.round((x + y) / 0.005).astype(int) % 2, 1.0, -1.0)
    swing = np.deg2rad(20.0)
    swung = np.column_stack([zero, np.sin(swing) * sign, np.cos(swing) * one])
    np.testing.assert_allclose(directors_apart(swung, BLANK.quads), 2.0 * swing, rtol=1e-12)


def inverted(position: np.ndarray, director: np.ndarray) -> np.ndarray:
    """Which elements are turned over against their directors."""
    flat = facing(BLANK.node_position, BLANK.initial_director, BLANK.quads)
    return facing(position, director, BLANK.quads) * flat < 0.0


def test_what_is_turned_over_against_its_directors_is_inverted():
    up = BLANK.initial_director
    assert not inverted(BLANK.node_position, up).any()
    over = BLANK.node_position * (1.0, -1.0, -1.0)  # half a turn about x
    assert not inverted(over, up * (1.0, -1.0, -1.0)).any()
    assert inverted(over, up).all()
    moved = BLANK.node_position.copy()
    moved[0, :2] = 0.009  # past the opposite corner
    assert np.flatnonzero(inverted(moved, up)).tolist() == [0]


@pytest.mark.parametrize(("planes", "beyond"), [((), 0.0), (("x",), 0.003), (("y",), 0.001), (("x", "y"), 0.003)])
def test_nodes_beyond_a_plane_are_measured(planes, beyond):
    position = BLANK.node_position.copy()
    position[7] = (-0.003, -0.001, 0.0)
    found = beyond_symmetry(position, BLANK, Symmetry(planes))
    assert found.max() == pytest.approx(beyond) and found[np.arange(25) != 7].max() == 0.0


def test_the_side_of_a_plane_is_that_of_the_blank():
    blank = Blank.rectangle((-0.02, 0.0), (0.0, 0.02), 0.005)
    position = blank.node_position.copy()
    position[:, 0] += 0.002
    assert beyond_symmetry(position, blank, Symmetry(("x",))).max() == pytest.approx(0.002)
