"""Draw-in, outline and the taut mid-surface of sheets whose answer is known."""

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.support.flat_blanks import FULL, HALF_IN_X, HALF_IN_Y, HALF_LENGTH, HALF_WIDTH, QUARTER, blank_of
from weavesim import measures
from weavesim.errors import InputError
from weavesim.sheet.blank import Blank


def pressed(blank):
    """Plan scaled by 0.9 in x and 0.8 in y."""
    return blank.node_position * (0.9, 0.8, 1.0)


@pytest.mark.parametrize("symmetry", [QUARTER, HALF_IN_X, HALF_IN_Y, FULL])
@pytest.mark.parametrize("element_size", [0.02, 0.0311])  # the second leaves no nodes on the lines of the full blank
def test_draw_in_and_stretch_do_not_depend_on_the_modelled_part(symmetry, element_size):
    blank = blank_of(symmetry, element_size)
    position = pressed(blank)
    assert measures.draw_in(blank, position, "x") == pytest.approx(0.1 * HALF_LENGTH)
    assert measures.draw_in(blank, position, "y") == pytest.approx(0.2 * HALF_WIDTH)
    stretch = 1.0 + 0.05 * np.abs(blank.element_centres()[:, 1])
    assert measures.integrated_yarn_stretch(blank, np.full(blank.element_count, 1.01), "x") == pytest.approx(
        0.01 * HALF_LENGTH
    )
    # Largest in the elements that hold the end of the line; half an element is left out there.
    along_y = measures.integrated_yarn_stretch(blank, stretch, "y")
    assert along_y == pytest.approx(0.025 * HALF_WIDTH**2, rel=0.15)


def test_symmetry_line_runs_by_rising_coordinate_and_interpolates():
    blank = blank_of(FULL, 0.0311)
    line = measures.symmetry_line(blank, "x")
    flat = line.of(blank.material_coordinates)
    assert np.all(np.diff(flat[:, 0]) > 0.0)
    assert np.abs(flat[:, 1]).max() < 1e-15
    assert flat[[0, -1], 0] == pytest.approx([-HALF_LENGTH, HALF_LENGTH])


def test_a_blank_away_from_the_origin_has_no_symmetry_line():
    with pytest.raises(InputError, match="does not cross the line along x"):
        measures.symmetry_line(Blank.rectangle((0.1, 0.1), (0.2, 0.2), 0.02), "x")


@pytest.mark.parametrize("symmetry", [QUARTER, HALF_IN_X, HALF_IN_Y, FULL])
def test_whole_outline_is_the_rectangle_once_around(symmetry):
    blank = blank_of(symmetry)
    outline = measures.whole_outline(blank, pressed(blank), symmetry)
    x, y = outline[:, :2].T
    area = 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)
    assert area == pytest.approx(4.0 * 0.9 * HALF_LENGTH * 0.8 * HALF_WIDTH)
    assert len(np.unique(outline.round(9), axis=0)) == len(outline) == 2 * (24 + 14)


def test_border_draw_in_is_normal_to_the_flat_border():
    blank = blank_of(QUARTER)
    border = measures.outline(blank, QUARTER)
    assert not border.closed
    flat = blank.material_coordinates[border.node]
    assert flat[[0, -1]] == pytest.approx(np.array([[HALF_LENGTH, 0.0], [0.0, HALF_WIDTH]]))
    values = measures.border_draw_in(blank, pressed(blank), border)
    right = (flat[:, 0] == HALF_LENGTH) & (flat[:, 1] < HALF_WIDTH - 1e-9)
    top = (flat[:, 1] == HALF_WIDTH) & (flat[:, 0] < HALF_LENGTH - 1e-9)
    assert values[right] == pytest.approx(np.full(right.sum(), 0.1 * HALF_LENGTH))
    assert values[top] == pytest.approx(np.full(top.sum(), 0.2 * HALF_WIDTH))


@pytest.mark.parametrize(("clearance", "expected"), [(1.2, 30.8), (2.0, 30.2), (4.0, 29.0)])
def test_taut_path_of_the_double_dome(clearance, expected):
    value = 1e3 * measures.taut_path_draw_in(0.060, 0.010, 0.060, 0.0012, 1e-3 * clearance)
    assert value == pytest.approx(expected, abs=0.05)


@pytest.mark.parametrize(
    ("punch", "die", "depth", "thickness", "clearance"),
    [(60.0, 10.0, 60.0, 1.2, 1.2), (60.0, 10.0, 35.0, 1.2, 4.0), (40.0, 6.0, 25.0, 0.5, 10.0)],
)
def test_taut_path_against_a_tangent_found_by_bisection(punch, die, depth, thickness, clearance):
    on_punch, on_die = punch + thickness / 2, die + thickness / 2
    centre_punch = np.array([0.0, thickness / 2 - depth - thickness + on_punch])  # heights above the die's face
    centre_die = np.array([punch + clearance + die, -die])

    def ends(angle):
        sine, cosine = np.sin(angle), np.cos(angle)
        return centre_punch + on_punch * np.array([sine, -cosine]), centre_die + on_die * np.array([-sine, cosine])

    def miss(angle):  # the chord between the two points of equal slope must have that slope
        start, end = ends(angle)
        return (end - start) @ np.array([-np.sin(angle), np.cos(angle)])

    grid = np.linspace(0.01, 1.55, 400)
    signs = np.sign([miss(a) for a in grid])
    first = int(np.flatnonzero(signs[:-1] != signs[1:])[0])
    angle = brentq(miss, grid[first], grid[first + 1])
    start, end = ends(angle)
    length = (on_punch + on_die) * angle + np.linalg.norm(end - start)
    result = measures.taut_path_draw_in(*(1e-3 * v for v in (punch, die, depth, thickness, clearance)))
    assert 1e3 * result == pytest.approx(length - centre_die[0], abs=1e-6)


@pytest.mark.parametrize("bad", [{"depth": -0.01}, {"clearance": 0.0001}, {"thickness": float("nan")}])
def test_taut_path_refuses_impossible_lengths(bad):
    lengths = {"punch_radius": 0.06, "die_radius": 0.01, "depth": 0.06, "thickness": 0.0012, "clearance": 0.0012}
    with pytest.raises(InputError, match="taut path"):
        measures.taut_path_draw_in(**(lengths | bad))
