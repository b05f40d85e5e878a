"""Measures of a formed sheet against sheets whose answer is known."""

import numpy as np
import pytest
from scipy.optimize import brentq

from weavesim import measures
from weavesim.errors import InputError
from weavesim.sheet.blank import Blank

HALF_LENGTH, HALF_WIDTH = 0.24, 0.14
QUARTER, FULL = ("x", "y"), ()


def blank_of(symmetry, element_size=0.02, **settings):
    lower = (0.0 if "x" in symmetry else -HALF_LENGTH, 0.0 if "y" in symmetry else -HALF_WIDTH)
    return Blank.rectangle(lower, (HALF_LENGTH, HALF_WIDTH), element_size, **settings)


def pressed(blank):
    """Plan scaled by 0.9 in x and 0.8 in y."""
    return blank.node_position * (0.9, 0.8, 1.0)


def odd_angle(blank, factor=30.0):
    return factor * np.prod(blank.element_centres()[:, :2], axis=1)


# ------------------------------------------------------------------------------------------------ angles at points


def test_ten_points_divide_the_line_into_nine_parts():
    points = measures.ten_points(0.235, 0.135)
    assert points.shape == (10, 2)
    assert points[0].tolist() == [0.235, 0.0] and points[-1].tolist() == [0.0, 0.135]
    assert np.ptp(np.diff(points, axis=0), axis=0).max() < 1e-15


@pytest.mark.parametrize("symmetry", [QUARTER, ("y",), ("x",), FULL])
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
    blank = blank_of(("x",), yarn_angle=45.0)
    even = np.full(blank.element_count, 0.3)
    nodal = measures.nodal_shear_angle(blank, even, ("x",))
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


def test_yarn_vectors_follow_an_affine_deformation():
    blank = blank_of(FULL, yarn_angle=25.0, distortion=0.2)
    gradient = np.array([[1.1, 0.3, 0.0], [-0.2, 0.9, 0.0], [0.4, 0.1, 1.0]])
    warp, weft = measures.yarn_vectors(blank, blank.node_position @ gradient.T)
    for vector, start in ((warp, blank.warp_direction[0]), (weft, blank.weft_direction[0])):
        expected = gradient @ start / np.linalg.norm(gradient @ start)
        assert vector == pytest.approx(np.tile(expected, (blank.element_count, 1)), abs=1e-12)


# ---------------------------------------------------------------------------------------------- draw-in and outline


@pytest.mark.parametrize("symmetry", [QUARTER, ("x",), ("y",), FULL])
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


def test_a_blank_beside_the_origin_has_no_symmetry_line():
    with pytest.raises(InputError, match="does not meet the line along x"):
        measures.symmetry_line(Blank.rectangle((0.1, 0.1), (0.2, 0.2), 0.02), "x")


@pytest.mark.parametrize("symmetry", [QUARTER, ("x",), ("y",), FULL])
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


# ---------------------------------------------------------------------------------------------------- taut mid-surface


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


# -------------------------------------------------------------------------------------------------- quality of a sheet


@pytest.mark.parametrize("distortion", [0.0, 0.25])
def test_checkerboard_finds_a_zigzag_of_known_height(distortion):
    blank = blank_of(FULL, distortion=distortion)
    column = np.arange(blank.element_count) // 14
    row = np.arange(blank.element_count) % 14
    zigzag = np.deg2rad(2.0) * (-1.0) ** (column + row)
    found = measures.checkerboard(blank, 0.2 + zigzag)
    assert (found.rms, found.maximum) == pytest.approx((2.0, 2.0))
    stripes = measures.checkerboard(blank, np.deg2rad(2.0) * (-1.0) ** column)
    assert stripes.maximum < 1e-12


def test_checkerboard_of_a_smooth_field_is_small_and_names_the_worst_node():
    blank = blank_of(FULL)
    centre = blank.element_centres()
    assert measures.checkerboard(blank, centre[:, 0] + 2.0 * centre[:, 1]).maximum < 1e-12
    angle = np.zeros(blank.element_count)
    angle[100] = np.deg2rad(8.0)
    found = measures.checkerboard(blank, angle)
    assert found.maximum == pytest.approx(2.0)
    assert found.node in blank.quads[100]


def test_checkerboard_without_blocks():
    blank = Blank.rectangle((0.0, 0.0), (1.0, 0.1), 0.1)
    assert measures.checkerboard(blank, np.ones(blank.element_count)) == (0.0, 0.0, -1)


def rim_position(blank, radius):
    """Nodes at a distance from the axis that depends on the way along the sides of the square, from 0 to 2 pi."""
    x, y = blank.material_coordinates.T
    polar = np.arctan2(y, x)
    side = np.round(polar / (np.pi / 2))
    distance = radius((side + 0.5 * np.tan(polar - side * np.pi / 2)) * np.pi / 2)
    return np.column_stack([distance * np.cos(polar), distance * np.sin(polar), -np.hypot(x, y)])


@pytest.mark.parametrize(("symmetry", "count"), [(FULL, 7), (QUARTER, 8), (("x",), 6)])
def test_folds_of_a_fluted_rim_are_counted(symmetry, count):
    half = 0.2
    lower = [0.0 if axis in symmetry else -half for axis in "xy"]
    blank = Blank.rectangle(lower, (half, half), 0.005)
    folds = measures.rim_folds(blank, rim_position(blank, lambda p: 0.1 + 0.008 * np.cos(count * p)), symmetry)
    assert folds.fold_count == count
    assert folds.amplitude == pytest.approx(0.008, rel=0.02)


def test_a_wrapped_cloth_has_no_folds_and_a_flat_one_is_not_wrapped():
    from weavesim.scenes.hemisphere import smooth_radius

    blank = Blank.rectangle((-0.2, -0.2), (0.2, 0.2), 0.01)
    smooth = smooth_radius(blank, 0.1)
    flat = blank.node_position
    wrapped = flat * (smooth / np.maximum(np.linalg.norm(flat, axis=1), 1e-12))[:, None]
    folds = measures.rim_folds(blank, wrapped, smooth_radius=smooth)
    assert folds.fold_count == 0 and folds.amplitude < 1e-12
    angle = np.arctan2(flat[:, 1], flat[:, 0])
    fluted = wrapped * (1.0 + 0.1 * np.cos(6 * angle))[:, None]
    folds = measures.rim_folds(blank, fluted, smooth_radius=smooth)
    assert folds.fold_count == 6
    assert folds.amplitude == pytest.approx(0.01, rel=0.02)


def test_a_smooth_rim_has_no_folds_and_noise_does_not_count():
    blank = Blank.rectangle((-0.2, -0.2), (0.2, 0.2), 0.005)
    still = measures.rim_folds(blank, rim_position(blank, lambda p: 0.1 + 0.0 * p))
    assert still.fold_count == 0 and still.amplitude < 1e-12
    noise = rim_position(blank, lambda p: 0.1 + 0.0005 * np.sin(31 * p))
    assert measures.rim_folds(blank, noise).fold_count == 0
    assert measures.rim_folds(blank, noise, threshold=0.0005).fold_count == 31


def sampled_gaps(position, quads):
    """Distance of every node from a dense set of points of every element, (node_count, element_count)."""
    u, v = (g.ravel() for g in np.meshgrid(*2 * (np.linspace(0.0, 1.0, 41),)))
    inside = u + v <= 1.0
    weights = np.stack([1.0 - u - v, u, v], axis=1)[inside]
    gaps = np.full((len(position), len(quads)), np.inf)
    for element, corners in enumerate(position[quads]):
        for triangle in ((0, 1, 2), (0, 2, 3)):
            points = weights @ corners[list(triangle)]
            gap = np.linalg.norm(position[:, None] - points[None], axis=2).min(axis=1)
            gaps[:, element] = np.minimum(gaps[:, element], gap)
    near = np.eye(len(position), dtype=bool)
    for i in range(4):
        near[quads[:, i], quads[:, (i + 1) % 4]] = near[quads[:, (i + 1) % 4], quads[:, i]] = True
    within_two = (near.astype(int) @ near.astype(int)) > 0
    gaps[within_two[:, quads].any(axis=2)] = np.inf
    return gaps


@pytest.mark.parametrize("seed", range(3))
def test_close_pairs_against_a_dense_sampling(seed):
    blank = Blank.rectangle((0.0, 0.0), (0.08, 0.08), 0.01)
    rng = np.random.default_rng(seed)
    position = blank.node_position * (1.0, 0.3, 1.0) + rng.normal(0.0, 0.01, blank.node_position.shape)
    gaps = sampled_gaps(position, blank.quads)
    for distance in (0.002, 0.005, 0.01):
        # the sampling sees every distance at most this much too large
        slack = 1.0e-4 + 0.05 * distance
        found = measures.close_pairs(position, blank.quads, distance)
        assert (gaps < distance).sum() <= found <= (gaps < distance + slack).sum()
    assert found > 0


@pytest.mark.parametrize("stagger", [0.0, 0.005])
def test_close_pairs_of_a_flat_and_of_a_folded_sheet(stagger):
    blank = Blank.rectangle((-0.1, 0.0), (0.1, 0.1), 0.01)
    assert measures.close_pairs(blank.node_position, blank.quads, 0.015) == 0
    folded = np.array(blank.node_position)
    upper = folded[:, 0] > 0.0
    folded[upper, 0] = stagger - folded[upper, 0]
    folded[upper, 1] += stagger
    folded[upper, 2] = 0.0004
    # layers whose nodes lie between each other are as close as those whose nodes face each other
    assert measures.close_pairs(folded, blank.quads, 0.0006) >= 2 * 8 * 9
    assert measures.close_pairs(folded, blank.quads, 0.0003) == 0
    with pytest.raises(InputError, match="must be positive"):
        measures.close_pairs(folded, blank.quads, 0.0)
