"""Laws of the sheet on their own: the shear curve's table on the device against the curve itself."""

import numpy as np
import pytest
import scipy.integrate
import warp as wp

from weavesim.fabric import SHEAR_KNOT_COUNT, LinearShear, MomentCurve, Stabilisation, glass_polypropylene
from weavesim.kernels.lanes import lane_types
from weavesim.kernels.sheet import shear_curve_energy, shear_moment, sheet_struct
from weavesim.model import hourglass_coefficients, shear_table

TYPES = lane_types(wp.float64, 1)
SPACING = 0.5 * np.pi / SHEAR_KNOT_COUNT


@wp.kernel(module="unique", enable_backward=False)
def evaluate(
    laws: sheet_struct(wp.float64),
    angle: wp.array(dtype=TYPES.lanes),
    moment: wp.array(dtype=TYPES.lanes),
    tangent: wp.array(dtype=TYPES.lanes),
    energy: wp.array(dtype=TYPES.lanes),
):
    i = wp.tid()
    m, t = shear_moment(laws, angle[i])
    moment[i] = m
    tangent[i] = t
    energy[i] = shear_curve_energy(laws, angle[i])


def on_device(law: MomentCurve, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Moment, tangent and energy of the kernels' table."""
    coefficients, energy = shear_table(law, 1.2e-3, SPACING)
    laws = sheet_struct(wp.float64)()
    laws.shear_knot_spacing = SPACING
    laws.shear_moment = wp.array(coefficients, dtype=TYPES.vec4, device="cpu")
    laws.shear_energy = wp.array(energy, dtype=wp.float64, device="cpu")
    rows = [wp.zeros(len(angle), dtype=TYPES.lanes, device="cpu") for _ in range(3)]
    inputs = [laws, wp.array(angle.reshape(-1, 1), dtype=TYPES.lanes, device="cpu")]
    wp.launch(evaluate, dim=len(angle), inputs=inputs, outputs=rows, device="cpu")
    return tuple(row.numpy().ravel() for row in rows)


@pytest.fixture
def curve() -> MomentCurve:
    return glass_polypropylene().shear


def test_table_follows_the_curve(curve):
    angle = np.linspace(-1.5, 1.5, 1001)
    moment, tangent, _ = on_device(curve, angle)
    expected = curve.moment(angle)
    assert np.abs(moment - expected).max() < 1e-5 * np.abs(expected).max()
    slope = (curve.moment(angle + 1e-6) - curve.moment(angle - 1e-6)) / 2e-6
    # the slope has a kink where the locking branch has reached its own
    assert np.abs(tangent - slope).max() < 3e-3 * np.abs(slope).max()


def test_energy_is_the_integral_of_the_moment(curve):
    angle = np.array([0.01, 0.3, -0.3, 0.9, 1.2, 1.5])
    _, _, energy = on_device(curve, angle)
    for found, end in zip(energy, angle, strict=True):
        points = [p for p in (*curve.angle[::20], curve.locking_angle) if p < abs(end)]
        expected, _ = scipy.integrate.quad(
            lambda g: float(curve.moment(np.array(g))), 0.0, abs(end), points=points, limit=500
        )
        assert found == pytest.approx(expected, rel=1e-5)


def test_moment_is_odd_and_energy_even(curve):
    angle = np.linspace(0.01, 1.5, 100)
    plus, minus = on_device(curve, angle), on_device(curve, -angle)
    assert np.array_equal(plus[0], -minus[0])
    assert np.array_equal(plus[1], minus[1])
    assert np.array_equal(plus[2], minus[2])


def test_angles_that_are_no_angles_read_nothing_outside_the_table(curve):
    """NaN and infinity must come back as such, or as any number, but never end the process."""
    moment, _, energy = on_device(curve, np.array([np.nan, np.inf, -np.inf, 1e300, 0.5]))
    assert np.isnan(moment[0]) and np.isnan(energy[0])
    assert moment[4] == pytest.approx(float(curve.moment(np.array(0.5))), rel=1e-5)


def test_locking_branch_keeps_stiffening(curve):
    beyond = np.linspace(curve.locking_angle + curve.locking_width, 1.55, 50)
    _, tangent, _ = on_device(curve, beyond)
    assert tangent.min() >= curve.locking_stiffness * (1.0 - 1e-6)


def test_linear_law_is_equation_four():
    """Half of t G_12 sin cos: the tensor component of the strain, not the angle."""
    law = LinearShear(modulus=3.0e6)
    assert law.moment(np.array(0.3), 1e-3) == pytest.approx(0.5 * 1e-3 * 3.0e6 * np.sin(0.3) * np.cos(0.3))
    assert law.moment(np.array(1e-6), 1e-3) == pytest.approx(0.5 * 1e-3 * 3.0e6 * 1e-6)


def test_in_plane_stabilisation_knows_nothing_of_the_yarns():
    fabric = glass_polypropylene()
    stiffer = fabric.unit_cell.model_copy(update={"warp_modulus": 100.0 * fabric.unit_cell.warp_modulus})
    changed = fabric.model_copy(update={"unit_cell": stiffer})
    assert hourglass_coefficients(changed) == hourglass_coefficients(fabric)
    shear = fabric.with_linear_shear(1.0e6), fabric.with_linear_shear(2.0e6)
    assert hourglass_coefficients(shear[1])[0] == pytest.approx(2.0 * hourglass_coefficients(shear[0])[0])
    none = fabric.model_copy(update={"stabilisation": Stabilisation(in_plane=0.0, warping=0.0, director=0.0)})
    assert hourglass_coefficients(none) == (0.0, 0.0, 0.0)
