"""The foot of a point on a facet, and the work of a force along its normal, against closed paths."""

import numpy as np
import pytest
import warp as wp

from weavesim.kernels.lane_types import lane_types
from weavesim.kernels.lanes import dot, square_root
from weavesim.kernels.plies.facet import find_foot, normal_at, patch_functions, sagitta

REAL = wp.float64
_types = lane_types(REAL, 1)
lanes, lanes3, vec3 = _types.lanes, _types.lanes3, _types.vec3
*_, patch_of = patch_functions(REAL, 1)


@wp.func
def column(v: vec3):
    result = lanes3()
    for c in range(3):
        result[c, 0] = v[c]
    return result


@wp.func
def patch_from(corner: wp.array(dtype=vec3), origin: vec3):
    return patch_of(
        column(corner[0] - origin), column(corner[1] - origin), column(corner[2] - origin), column(corner[3] - origin)
    )


@wp.kernel
def stand(
    corner: wp.array(dtype=vec3),
    normal: wp.array(dtype=vec3),
    point: wp.array(dtype=vec3),
    found: wp.array2d(dtype=REAL),  # [xi, eta, gap, normal], point
):
    i = wp.tid()
    x = patch_from(corner, point[i])
    d = patch_from(normal, vec3())
    xi, eta, g = find_foot(x, d, lanes(), lanes(), 20)
    n = normal_at(x, d, xi, eta)
    length = square_root(dot(n, n))
    gap = wp.cw_mul(g, length) - wp.cw_div(sagitta(x, d, xi, eta), length)
    found[0, i] = xi[0]
    found[1, i] = eta[0]
    found[2, i] = gap[0]
    for c in range(3):
        found[3 + c, i] = n[c, 0] / length[0]


def feet(corner: np.ndarray, normal: np.ndarray, points: np.ndarray) -> np.ndarray:
    """xi, eta, gap and normal of every point, (6, n)."""
    found = wp.zeros((6, len(points)), dtype=REAL, device="cpu")
    arrays = [wp.array(each, dtype=vec3, device="cpu") for each in (corner, normal, points)]
    wp.launch(stand, dim=len(points), inputs=arrays, outputs=[found], device="cpu")
    return found.numpy()


def kinked_strip(angle: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """Corners and normals of two facets of side 1 that meet at a kink, (4, 3) each; the others continue them flat."""
    cosine, sine = np.cos(angle), np.sin(angle)
    line = np.array([[-1.0, 0.0], [0.0, 0.0], [cosine, -sine]])
    lean = np.array([0.0, 0.5 * angle, angle])
    normals = np.column_stack([np.sin(lean), np.cos(lean)])

    def corners(values: np.ndarray, width: float) -> np.ndarray:
        first, second = np.insert(values, 1, 0.0, axis=1)
        across = np.array([0.0, width, 0.0])
        return np.array([first, second, second + across, first + across])

    return [(corners(line[k : k + 2], 1.0), corners(normals[k : k + 2], 0.0)) for k in (0, 1)]


def height_path(middle: float, height: float, count: int = 801) -> np.ndarray:
    """Points over a half of the first facet, (count, 3)."""
    x = np.linspace(middle - 0.25, middle + 0.25, count)
    return np.column_stack([x, np.full(count, 0.5), np.full(count, height)])


@pytest.mark.parametrize("degrees", [0.0, 15.0, 30.0, 45.0])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("middle", [-0.5, -1.0])
def test_a_node_that_slides_over_a_facet_and_back_gains_nothing(degrees, side, middle):
    """Deeper on its way back, where a crease begins: the work around that path, of the energy that the spring holds.

    Also beyond a free edge. With bilinear normals it was 0.2 to 2.2 times that energy.
    """
    facets = kinked_strip(np.radians(degrees))
    thickness, depth = 0.2, 0.02
    out = height_path(middle, side * (thickness - 3.0 * depth))
    back = height_path(middle, side * (thickness - 5.0 * depth))[::-1]
    points = np.concatenate([out, back, out[:1]])
    xi, eta, gap, *normal = feet(*facets[0], points)
    assert np.abs(eta).max() < 1e-9 and np.abs(xi).max() < 1.6
    penetration = thickness - side * gap
    force = side * penetration * np.array(normal)
    work = np.einsum("cn,nc->", 0.5 * (force[:, 1:] + force[:, :-1]), np.diff(points, axis=0))
    assert abs(work) < 0.03 * 0.5 * np.square(penetration).max()


def test_gap_and_normal_do_not_jump_where_facets_meet():
    facets = kinked_strip(np.radians(45.0))
    edge = np.column_stack([np.zeros(5), np.linspace(0.1, 0.9, 5), np.full(5, 0.0)])
    lean = np.array([np.sin(np.pi / 8.0), 0.0, np.cos(np.pi / 8.0)])
    points = edge + 0.3 * lean
    first, second = (feet(*each, points) for each in facets)
    np.testing.assert_allclose(first[0], 1.0, atol=1e-12)
    np.testing.assert_allclose(second[0], -1.0, atol=1e-12)
    np.testing.assert_allclose(first[1:], second[1:], atol=1e-12)
    np.testing.assert_allclose(first[2], 0.3, atol=1e-12)
