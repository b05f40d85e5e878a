"""Newton's method for an energy's unknowns: springs and wells with known equilibria, and matrices by NumPy."""

import numpy as np
import pytest
import warp as wp

from weavesim.device import initialise
from weavesim.kernels.cell.energy_cell import cell_energy, parameter_struct
from weavesim.kernels.cell.newton import cholesky_functions, condensed_tangent_function, equilibrium_function

square, pair = wp.types.matrix((2, 2), wp.float64), wp.types.vector(2, wp.float64)
cholesky, solved = cholesky_functions(2, square, pair)
Parameters = parameter_struct("Springs", (("first", 1), ("second", 1), ("well", 1)))
vector = wp.types.vector(5, wp.float64)


@wp.func
def springs_energy(p: Parameters, warp_stretch: wp.float64, weft_stretch: wp.float64, angle: wp.float64, q: pair):
    """Two springs one behind the other along the warp, q[0] the joint; q[1] in a well with minima at +-1."""
    e = warp_stretch - wp.float64(1.0)
    springs = p.first * (e - q[0]) * (e - q[0]) + p.second * q[0] * q[0]
    well = (q[1] * q[1] - wp.float64(1.0)) * (q[1] * q[1] - wp.float64(1.0))
    return wp.float64(0.5) * springs + p.well * well + wp.float64(0.5) * angle * angle


SPRINGS = cell_energy(Parameters, 2, springs_energy, None)
equilibrium, condensed = equilibrium_function(SPRINGS), condensed_tangent_function(SPRINGS)


@wp.kernel(module="unique", enable_backward=False)
def settle(p: Parameters, start: wp.array(dtype=vector), found: wp.array2d(dtype=wp.float64)):
    i = wp.tid()
    x, _gradient, residual, count = equilibrium(p, start[i])
    tangent = condensed(p, x)
    for k in range(5):
        found[i, k] = x[k]
    for k in range(6):
        found[i, 5 + k] = tangent[k]
    found[i, 11] = residual
    found[i, 12] = count


@wp.kernel(module="unique", enable_backward=False)
def factor_and_solve(h: wp.array(dtype=square), b: pair, factor: wp.array(dtype=square), x: wp.array(dtype=pair)):
    i = wp.tid()
    factor[i] = cholesky(h[i], wp.float64(1.0e-12))
    x[i] = solved(factor[i], b)


def settled(*starts):
    initialise()
    p = Parameters()
    p.first, p.second, p.well = 300.0, 100.0, 5.0
    p.tolerance, p.force_floor, p.resolution = 1e-10, 1e-3, 0.0
    found = wp.zeros((len(starts), 13), dtype=wp.float64, device="cpu")
    inputs = [p, wp.array(np.array(starts), dtype=vector, device="cpu")]
    wp.launch(settle, dim=len(starts), inputs=inputs, outputs=[found], device="cpu")
    return found.numpy()


def test_springs_in_series_share_the_stretch_and_the_well_is_found_on_the_side_of_the_start():
    found = settled((0.02, 0.0, 0.1, 0.0, 0.7), (0.02, 0.0, 0.1, 0.9, -0.05))
    np.testing.assert_allclose(found[:, 3], 0.02 * 0.75, rtol=1e-9)
    np.testing.assert_allclose(found[:, 4], [1.0, -1.0], rtol=1e-7)  # from the second start past a negative curvature
    assert np.all(found[:, 11] <= 1e-10) and np.all(found[:, 12] < 20)


def test_condensed_tangent_is_that_of_springs_in_series():
    c11, c12, c22, c13, c23, c33 = settled((0.02, 0.0, 0.1, 0.015, 1.0))[0, 5:11]
    assert c11 == pytest.approx(300.0 * 100.0 / 400.0, rel=1e-6)
    assert c33 == pytest.approx(1.0, rel=1e-6)
    np.testing.assert_allclose([c12, c22, c13, c23], 0.0, atol=1e-5)


def test_factor_is_that_of_the_matrix_or_of_the_first_shift_that_makes_it_definite():
    initialise()
    definite, indefinite = np.array([[4.0, 1.0], [1.0, 3.0]]), np.array([[1.0, 2.0], [2.0, 1.0]])
    factor = wp.zeros(2, dtype=square, device="cpu")
    x = wp.zeros(2, dtype=pair, device="cpu")
    h = wp.array(np.array([definite, indefinite]), dtype=square, device="cpu")
    wp.launch(factor_and_solve, dim=2, inputs=[h, pair(1.0, 2.0)], outputs=[factor, x], device="cpu")
    np.testing.assert_allclose(factor.numpy()[0], np.linalg.cholesky(definite), rtol=1e-14)
    np.testing.assert_allclose(x.numpy()[0], np.linalg.solve(definite, [1.0, 2.0]), rtol=1e-14)
    # H + tau diag |H| with tau = 1e-3 2^k: 1.024 is the first above 1
    shifted = indefinite + 1.024 * np.eye(2)
    np.testing.assert_allclose(factor.numpy()[1], np.linalg.cholesky(shifted), rtol=1e-12)
