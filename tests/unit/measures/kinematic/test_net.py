"""The net of inextensible yarns: hemisphere, cylinder, cone and saddle, whose answers are known."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from weavesim.errors import InputError
from weavesim.measures.kinematic.net import lay_net

RADIUS = 0.1


def ball(points):
    size = np.linalg.norm(points, axis=1)
    return size - RADIUS, points / size[:, None]


def cylinder(points):
    """Along y."""
    size = np.hypot(points[:, 0], points[:, 2])
    return size - RADIUS, points * [1.0, 0.0, 1.0] / size[:, None]


def cone(points):
    """About z, its tip above, at 30 degrees to its axis."""
    out = np.hypot(points[:, 0], points[:, 1])
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    normal = np.column_stack([c * points[:, 0] / out, c * points[:, 1] / out, np.full(len(points), s)])
    return c * out + s * (points[:, 2] - 0.2), normal


def saddle(points):
    """z = x y / 0.2, its height over the length of its gradient: the same surface at zero."""
    x, y, z = points.T
    gradient = np.column_stack([-y / 0.2, -x / 0.2, np.ones(len(points))])
    size = np.linalg.norm(gradient, axis=1)
    return (z - x * y / 0.2) / size, gradient / size[:, None]


def chebyshev(product):
    """The shear angle of the exact net at u v / R^2: (s g')' = cos g, g(0) = 0."""
    found = solve_ivp(
        lambda s, y: [y[1] / s, np.cos(y[0])], (1e-9, 1.0 + product.max()), [1e-9, 1e-9], rtol=1e-9, atol=1e-12,
        dense_output=True,
    )  # fmt: skip
    return found.sol(product)[0]


def test_the_hemisphere_has_its_exact_net():
    side, count = 0.002, 70
    net = lay_net(ball, np.array([0.0, 0.0, RADIUS]), np.array([1.0, 0.0, 0.0]), side, ((-count, count),) * 2)
    node = net.position[count + 1 :, count + 1 :]
    lengths = side * (np.arange(count) + 0.5)
    u, v = np.meshgrid(lengths, lengths, indexing="ij")
    angle = np.abs(net.shear_angle[count:, count:])
    known = np.isfinite(angle) & (angle < np.deg2rad(60.0))
    assert known.sum() > 2000
    error = np.rad2deg(angle[known] - chebyshev(u[known] * v[known] / RADIUS**2))
    assert np.abs(error).max() < 0.4
    # the table of the meridian at 45 degrees, by the angle from the pole
    diagonal = np.array([node[k, k] for k in range(count)])
    theta = np.rad2deg(np.arccos(diagonal[:, 2] / RADIUS))
    own = np.rad2deg(np.array([angle[k, k] for k in range(count)]))
    good = np.isfinite(theta[1:]) & np.isfinite(own[1:])
    centre = 0.5 * (theta[:-1] + theta[1:])[good]
    for at, wanted in ((15.0, 1.94), (30.0, 7.52), (45.0, 16.11), (60.0, 26.95), (75.0, 39.27), (90.0, 52.42)):
        assert np.interp(at, centre, own[1:][good]) == pytest.approx(wanted, abs=0.5)


def test_the_four_quarters_of_a_hemisphere_are_alike():
    net = lay_net(ball, np.array([0.0, 0.0, RADIUS]), np.array([1.0, 0.0, 0.0]), 0.005, ((-20, 20),) * 2)
    angle = net.shear_angle
    np.testing.assert_allclose(angle, -angle[::-1], atol=1e-5)
    np.testing.assert_allclose(angle, angle.T, atol=1e-5)


@pytest.mark.parametrize("turn", [0.0, 30.0, 45.0])
def test_on_a_cylinder_no_yarn_shears(turn):
    turn = np.deg2rad(turn)
    warp = np.array([np.cos(turn), np.sin(turn), 0.0])
    net = lay_net(cylinder, np.array([0.0, 0.0, RADIUS]), warp, 0.004, ((-25, 25),) * 2)
    angle = np.rad2deg(net.shear_angle)
    assert np.isfinite(angle).all()
    # chords are shorter than arcs by (side/R)^2/24, more for one yarn than for the other
    assert np.abs(angle).max() < (1e-4 if turn == 0.0 else 0.2)


def test_on_a_cone_no_yarn_shears():
    net = lay_net(cone, np.array([0.06, 0.0, 0.1]), np.array([0.0, 1.0, 0.0]), 0.002, ((-12, 12),) * 2)
    angle = np.rad2deg(net.shear_angle)
    assert np.isfinite(angle).all() and np.abs(angle).max() < 0.3


def test_on_a_saddle_the_sense_of_shear_is_the_other():
    """Gauss curvature below zero: what opens on a dome closes here; its two straight lines are yarns."""
    net = lay_net(saddle, np.zeros(3), np.array([1.0, 0.0, 0.0]), 0.004, ((-20, 20),) * 2)
    dome = lay_net(ball, np.array([0.0, 0.0, RADIUS]), np.array([1.0, 0.0, 0.0]), 0.004, ((-20, 20),) * 2)
    assert np.allclose(net.position[:, 20, 1:], 0.0, atol=1e-9)
    quarter, other = net.shear_angle[20:, 20:], dome.shear_angle[20:, 20:]
    assert (np.sign(quarter[5:, 5:]) == -np.sign(other[5:, 5:])).all()
    # small: -K u v at the middle, K = -1/0.2^2
    assert quarter[3, 3] == pytest.approx(np.sign(quarter[3, 3]) * (0.004 * 3.5 / 0.2) ** 2, rel=0.05)


def test_sides_are_as_long_as_they_shall_be_and_lie_on_the_surface():
    net = lay_net(
        ball, np.array([0.01, 0.0, 0.12]), np.array([1.0, 0.3, 0.0]), 0.005, ((-10, 10), (-5, 8)), height=0.001
    )
    for axis in (0, 1):
        length = np.linalg.norm(np.diff(net.position, axis=axis), axis=2)
        assert length[np.isfinite(length)] == pytest.approx(0.005, rel=1e-6)
    size = np.linalg.norm(net.position, axis=2)
    assert size[np.isfinite(size)] == pytest.approx(RADIUS + 0.001, rel=1e-6)


def test_angles_are_found_by_lengths_along_the_yarns():
    net = lay_net(ball, np.array([0.0, 0.0, RADIUS]), np.array([1.0, 0.0, 0.0]), 0.005, ((-4, 4),) * 2)
    found = net.angle_at(np.array([[0.0125, 0.0125], [-0.0125, 0.0125], [0.5, 0.0]]))
    assert found[0] == pytest.approx(-found[1]) and np.isnan(found[2])


def test_a_warp_that_stands_on_the_surface_is_told():
    with pytest.raises(InputError, match="the warp stands on the surface"):
        lay_net(ball, np.array([0.0, 0.0, RADIUS]), np.array([0.0, 0.0, 1.0]), 0.005, ((0, 1), (0, 1)))
