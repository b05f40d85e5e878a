"""Meshes fitted to an outline: the outline's area, every element convex, the requested direction."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from weavesim.errors import InputError
from weavesim.sheet.blank import Blank
from weavesim.sheet.fitted_mesh import LEAST_QUALITY, corner_sines, fitted_mesh

cases = settings(max_examples=15, deadline=None)
STRIP = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.1], [0.0, 0.1]])


def area_of(corners: np.ndarray) -> np.ndarray:
    """Signed area of polygons (..., k, 2)."""
    x, y = corners[..., 0], corners[..., 1]
    return 0.5 * (x * np.roll(y, -1, axis=-1) - y * np.roll(x, -1, axis=-1)).sum(axis=-1)


def distance_to(outline: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distance of points (n, 2) from the sides of a polygon."""
    side = np.roll(outline, -1, axis=0) - outline
    from_start = points[:, None] - outline
    share = np.clip((from_start * side).sum(axis=2) / np.square(side).sum(axis=1), 0.0, 1.0)
    return np.linalg.norm(from_start - share[..., None] * side, axis=2).min(axis=1)


def check(outline: np.ndarray, element_size: float, **options) -> Blank:
    """A blank whose mesh fills the outline and meets its corners and sides."""
    blank = Blank.fitted(outline, element_size, **options)
    node = blank.node_position[:, :2]
    assert corner_sines(node, blank.quads).min() >= LEAST_QUALITY
    area = area_of(node[blank.quads])
    assert area.min() > 0.0
    assert area.sum() == pytest.approx(abs(area_of(outline)), rel=1e-9)
    scale = np.ptp(outline, axis=0).max()
    rim = node[blank.boundary_loop()]
    assert distance_to(outline, rim).max() < 1e-9 * scale
    assert np.linalg.norm(outline[:, None] - rim, axis=2).min(axis=1).max() < 1e-9 * scale
    return blank


@cases
@given(st.floats(-180.0, 180.0), st.floats(0.1, 0.4), st.floats(0.1, 0.3), st.integers(6, 24))
def test_rectangles_of_any_size_with_a_mesh_at_any_angle(angle, length, width, count):
    outline = np.array([[0.0, 0.0], [length, 0.0], [length, width], [0.0, width]])
    check(outline, min(length, width) / count, mesh_angle=angle)


@cases
@given(st.floats(-180.0, 180.0), st.integers(0, 2**31))
def test_convex_polygons(angle, seed):
    """Corners on a circle, an eighth of a turn or more apart."""
    random = np.random.default_rng(seed)
    gaps = random.uniform(1.0, 1.8, random.integers(3, 7))
    turn = np.cumsum(gaps) / gaps.sum() * 2.0 * np.pi
    check(0.1 * np.column_stack([np.cos(turn), np.sin(turn)]), 0.01, mesh_angle=angle)


@cases
@given(st.floats(0.0, 90.0), st.floats(0.0, 0.25), st.integers(0, 2**31))
def test_distortion_keeps_outline_and_quality(angle, distortion, seed):
    blank = check(STRIP, 0.1 / 16, mesh_angle=angle, distortion=distortion, seed=seed)
    plain = Blank.fitted(STRIP, 0.1 / 16, mesh_angle=angle)
    assert np.array_equal(blank.quads, plain.quads)
    rim = plain.boundary_loop()
    assert np.array_equal(blank.node_position[rim], plain.node_position[rim])
    moved = np.linalg.norm(blank.node_position - plain.node_position, axis=1)
    # a distortion as small as the rounding of the coordinates cannot do less than that
    rounding = np.sqrt(2.0) * np.spacing(np.abs(STRIP).max())
    assert moved.max() <= distortion * np.sqrt(2.0) * 0.1 / 16 * (1.0 + 1e-9) + rounding


@pytest.mark.parametrize("angle", [0.0, 15.0, 30.0, 45.0, 77.0])
def test_edges_inside_have_the_direction_that_was_asked_for(angle):
    size = 0.1 / 16
    blank = Blank.fitted(STRIP, size, mesh_angle=angle, yarn_angle=20.0)
    node = blank.node_position[:, :2]
    centre = blank.element_centres()[:, :2]
    inner = np.all((centre > 4 * size) & (centre < STRIP.max(axis=0) - 4 * size), axis=1)
    assert inner.sum() > 100
    corner = node[blank.quads[inner]]
    edge = np.roll(corner, -1, axis=1) - corner
    assert np.allclose(np.linalg.norm(edge, axis=2), size)
    direction = np.rad2deg(np.arctan2(edge[..., 1], edge[..., 0]))
    assert np.allclose((direction - angle + 45.0) % 90.0, 45.0, atol=1e-6)
    # the yarns do not follow the mesh
    assert np.allclose(blank.warp_direction, [np.cos(np.deg2rad(20.0)), np.sin(np.deg2rad(20.0)), 0.0])


ANGLE = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.08], [0.08, 0.08], [0.08, 0.2], [0.0, 0.2]])
TURN = np.linspace(0.0, 2.0 * np.pi, 11)[:-1, None]
STAR = np.where(np.arange(10)[:, None] % 2, 0.09, 0.15) * np.column_stack([np.cos(TURN), np.sin(TURN)])


@pytest.mark.parametrize("angle", [0.0, 10.0, 45.0, 60.0])
@pytest.mark.parametrize("outline", [ANGLE, STAR], ids=["angle", "star"])
def test_outlines_with_corners_that_point_inwards(outline, angle):
    check(outline, 0.006, mesh_angle=angle)


@pytest.mark.parametrize("angle", [0.0, 30.0, 45.0])
def test_holes(angle):
    side = np.array([[0.03, 0.01], [0.08, 0.01], [0.08, 0.06], [0.03, 0.06]])
    ring = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    disc = (0.14, 0.04) + 0.025 * np.column_stack([np.cos(ring), np.sin(ring)])
    node, quads = fitted_mesh(STRIP - (0.0, 0.01), 0.004, holes=[side, disc], mesh_angle=angle)
    assert corner_sines(node, quads).min() >= LEAST_QUALITY
    whole = 0.2 * 0.1 - 0.05 * 0.05 - np.pi * 0.025**2
    assert area_of(node[quads]).sum() == pytest.approx(whole, rel=2e-3)
    assert np.linalg.norm(node[:, None] - side, axis=2).min(axis=0).max() < 1e-9


def test_aligned_rectangle_is_the_regular_grid():
    fitted, grid = Blank.fitted(STRIP, 0.00625), Blank.rectangle((0.0, 0.0), (0.2, 0.1), 0.00625)
    assert fitted.element_count == grid.element_count
    order = [np.lexsort(blank.node_position.round(9).T) for blank in (fitted, grid)]
    assert np.allclose(fitted.node_position[order[0]], grid.node_position[order[1]], atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 15.0, 45.0])
def test_disc(angle):
    blank = Blank.disc(0.1, 0.01, mesh_angle=angle, height=0.02)
    node = blank.node_position
    assert np.allclose(node[:, 2], 0.02)
    # nodes lie on the 720 sides
    radius = np.linalg.norm(node[blank.boundary_loop(), :2], axis=1)
    assert np.all((radius <= 0.1 * (1 + 1e-12)) & (radius >= 0.1 * np.cos(np.pi / 720) * (1 - 1e-12)))
    area = area_of(node[blank.quads][:, :, :2])
    # its rim is a polygon of chords
    chord = np.linalg.norm(np.diff(node[np.append(blank.boundary_loop(), blank.boundary_loop()[0])], axis=0), axis=1)
    assert area.sum() == pytest.approx(np.pi * 0.01 - (chord**3).sum() / (12 * 0.1), rel=1e-4)


@pytest.mark.parametrize(
    ("outline", "options", "message"),
    [
        (STRIP[:2], {}, r"\(k, 2\)"),
        (STRIP[[0, 2, 1, 3]], {}, "sides .* cross"),
        (STRIP[[0, 1, 1, 2, 3]], {}, "coincide"),
        (STRIP * np.nan, {}, "finite"),
        (STRIP, {"element_size": 0.05}, "quarter of its width|too close|use smaller"),
        (STRIP, {"element_size": -1.0}, "element_size = -1.0: a finite number above 0 is needed"),
        (STRIP, {"distortion": 0.5}, "distortion = 0.5: a number from 0 to 0.4 is needed"),
        (STRIP, {"mesh_angle": np.inf}, "mesh_angle = inf: a finite number is needed"),
        (STRIP, {"holes": [STRIP + 0.02]}, "hole 0 is not within the outline"),
        (STRIP, {"holes": [0.01 * STRIP + 0.02]}, "a hole is too small"),
        (np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.02]]), {}, "use smaller"),
    ],
)
def test_what_cannot_be_filled_is_refused(outline, options, message):
    with pytest.raises(InputError, match=message):
        fitted_mesh(outline, **({"element_size": 0.01} | options))
