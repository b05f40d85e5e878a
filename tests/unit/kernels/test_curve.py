"""Curves and sliders on the device: tables against the curves, friction against its path on the host."""

import numpy as np
import pytest
import scipy.integrate
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from weavesim.fabric.bending import BendingCurve
from weavesim.fabric.curve import CURVE_PIECE_COUNT, tabulate
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.shear import LARGEST_SHEAR_ANGLE, MomentCurve, ShearFriction
from weavesim.kernels.curve import curve_energy, curve_struct, odd_curve, slide
from weavesim.kernels.lane_types import lane_types

TYPES = lane_types(wp.float64, 1)


@wp.kernel(module="unique", enable_backward=False)
def evaluate(
    curve: curve_struct(wp.float64),
    x: wp.array(dtype=TYPES.lanes),
    value: wp.array(dtype=TYPES.lanes),
    tangent: wp.array(dtype=TYPES.lanes),
    energy: wp.array(dtype=TYPES.lanes),
):
    i = wp.tid()
    v, t = odd_curve(curve, x[i])
    value[i] = v
    tangent[i] = t
    energy[i] = curve_energy(curve, x[i])


def on_device(function, end: float, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Value, tangent and energy of the kernels' table of an odd function."""
    spacing = end / CURVE_PIECE_COUNT
    coefficient, integral = tabulate(function, spacing, CURVE_PIECE_COUNT)
    curve = curve_struct(wp.float64)()
    curve.knot_spacing = spacing
    curve.knots_per_unit = 1.0 / spacing
    curve.coefficient = wp.array(coefficient, dtype=TYPES.vec4, device="cpu")
    curve.integral = wp.array(integral, dtype=wp.float64, device="cpu")
    rows = [wp.zeros(len(x), dtype=TYPES.lanes, device="cpu") for _ in range(3)]
    inputs = [curve, wp.array(x.reshape(-1, 1), dtype=TYPES.lanes, device="cpu")]
    wp.launch(evaluate, dim=len(x), inputs=inputs, outputs=rows, device="cpu")
    return tuple(row.numpy().ravel() for row in rows)


@pytest.fixture
def curve() -> MomentCurve:
    return glass_polypropylene().shear


BENDING = BendingCurve(curvature=(0.0, 5.0, 20.0, 60.0), moment_values=(0.0, 0.05, 0.1, 0.14))


def test_table_follows_the_shear_curve(curve):
    angle = np.linspace(-1.5, 1.5, 1001)
    moment, tangent, _ = on_device(curve.moment, LARGEST_SHEAR_ANGLE, angle)
    expected = curve.moment(angle)
    assert np.abs(moment - expected).max() < 1e-5 * np.abs(expected).max()
    slope = (curve.moment(angle + 1e-6) - curve.moment(angle - 1e-6)) / 2e-6
    # the slope has a kink where the locking branch has reached its own
    assert np.abs(tangent - slope).max() < 3e-3 * np.abs(slope).max()


def test_table_follows_the_bending_curve_beyond_its_end():
    curvature = np.linspace(-150.0, 150.0, 1001)
    moment, tangent, energy = on_device(BENDING.moment, BENDING.curvature[-1], curvature)
    expected = BENDING.moment(curvature)
    assert np.abs(moment - expected).max() < 1e-5 * np.abs(expected).max()
    end_slope = (BENDING.moment(np.array(150.0)) - BENDING.moment(np.array(100.0))) / 50.0
    assert tangent[-1] == pytest.approx(float(end_slope), rel=1e-3)
    integral = np.trapezoid(expected[500:], curvature[500:])
    assert energy[-1] == pytest.approx(integral, rel=1e-4)


def test_energy_is_the_integral_of_the_moment(curve):
    angle = np.array([0.01, 0.3, -0.3, 0.9, 1.2, 1.5])
    _, _, energy = on_device(curve.moment, LARGEST_SHEAR_ANGLE, angle)
    for found, end in zip(energy, angle, strict=True):
        points = [p for p in (*curve.angle[::20], curve.locking_angle) if p < abs(end)]
        expected, _ = scipy.integrate.quad(
            lambda g: float(curve.moment(np.array(g))), 0.0, abs(end), points=points, limit=500
        )
        assert found == pytest.approx(expected, rel=1e-5)


def test_moment_is_odd_and_energy_even(curve):
    angle = np.linspace(0.01, 1.5, 100)
    plus = on_device(curve.moment, LARGEST_SHEAR_ANGLE, angle)
    minus = on_device(curve.moment, LARGEST_SHEAR_ANGLE, -angle)
    assert np.array_equal(plus[0], -minus[0])
    assert np.array_equal(plus[1], minus[1])
    assert np.array_equal(plus[2], minus[2])


def test_angles_that_are_no_angles_read_nothing_outside_the_table(curve):
    """NaN and infinity must come back as such, or as any number, but never end the process."""
    moment, _, energy = on_device(curve.moment, LARGEST_SHEAR_ANGLE, np.array([np.nan, np.inf, -np.inf, 1e300, 0.5]))
    assert np.isnan(moment[0]) and np.isnan(energy[0])
    assert moment[4] == pytest.approx(float(curve.moment(np.array(0.5))), rel=1e-5)


def test_locking_branch_keeps_stiffening(curve):
    beyond = np.linspace(curve.locking_angle + curve.locking_width, 1.55, 50)
    _, tangent, _ = on_device(curve.moment, LARGEST_SHEAR_ANGLE, beyond)
    assert tangent.min() >= curve.locking_stiffness * (1.0 - 1e-6)


WIDE = lane_types(wp.float64, 16)


@wp.kernel(module="unique", enable_backward=False)
def slide_along(
    strain: wp.array2d(dtype=WIDE.lanes),  # [step, block]
    stiffness: wp.float64,
    limit: wp.array2d(dtype=WIDE.lanes),
    slip: wp.array(dtype=WIDE.lanes),
    force: wp.array2d(dtype=WIDE.lanes),
    lost: wp.array2d(dtype=WIDE.lanes),
):
    i = wp.tid()
    before = WIDE.lanes()
    for k in range(strain.shape[0]):
        s, spring, loss = slide(strain[k, i], slip[i], before, stiffness, limit[k, i], wp.float64(1.0e-15))
        slip[i] = s
        before = spring
        force[k, i] = stiffness * spring
        lost[k, i] = loss


def device_path(strain: np.ndarray, stiffness: float, limit: np.ndarray):
    """Forces and losses (steps, 16) of 16 sliders with strains and limits (steps, 16)."""
    shape = (len(strain), 1)
    arrays = [wp.array(a.reshape(*shape, 16), dtype=WIDE.lanes, device="cpu") for a in (strain, limit)]
    outputs = [wp.zeros(1, dtype=WIDE.lanes, device="cpu")]
    outputs += [wp.zeros(shape, dtype=WIDE.lanes, device="cpu") for _ in range(2)]
    wp.launch(slide_along, dim=1, inputs=[arrays[0], stiffness, arrays[1]], outputs=outputs, device="cpu")
    return outputs[1].numpy()[:, 0], outputs[2].numpy()[:, 0]


@settings(max_examples=50, deadline=None)
@given(
    turns=st.lists(st.floats(-0.8, 0.8), min_size=2, max_size=6),
    stiffness=st.floats(1.0, 1e4),
    limit=st.floats(0.0, 10.0),
    lever=st.floats(0.0, 1e-3),
    pressure=st.floats(0.0, 1e5),
)
def test_slider_follows_its_path_and_never_creates_energy(turns, stiffness, limit, lever, pressure):
    """Any path of angles, with a pressure that swings: device against host, and dissipation that is never negative."""
    limit = limit if limit + lever > 0.0 else 1.0
    law = ShearFriction(stiffness=stiffness, limit=(limit,), crossover_friction_length=lever)
    path = np.concatenate([np.linspace(a, b, 40) for a, b in zip([0.0, *turns[:-1]], turns, strict=True)])
    swing = pressure * (1.0 + np.sin(np.arange(len(path)) / 7.0))
    expected = law.moment_along(path, swing)
    strain = np.tile(path[:, None], 16)
    moments, lost = device_path(strain, stiffness, np.tile((limit + lever * swing)[:, None], 16))
    scale = max(np.abs(expected).max(), stiffness * 1e-6)
    assert np.abs(moments - expected[:, None]).max() < 1e-9 * scale
    # to the last digit: what is lost and stored is the work of the mean forces, whatever the limit does meanwhile
    steps = 0.5 * (moments[1:, 0] + moments[:-1, 0]) * np.diff(path)
    work = np.concatenate([[0.0], np.cumsum(steps)])
    balance = lost[:, 0].cumsum() + 0.5 * moments[:, 0] ** 2 / stiffness - work
    assert np.abs(balance).max() <= 1e-11 * max(np.abs(work).max(), lost[:, 0].sum(), 1e-12)
    assert lost.sum() >= -1e-12 * scale


def test_loop_loses_twice_the_limit_times_the_slip():
    """Up to 0.5, back to 0: the slider slips 0.5 - y and back 0.5 - 2 y, with y = limit/stiffness."""
    path = np.concatenate([np.linspace(0.0, 0.5, 500), np.linspace(0.5, 0.0, 500)])
    stiffness, limit = 40.0, 2.0
    free = limit / stiffness
    _, lost = device_path(np.tile(path[:, None], 16), stiffness, np.full((1000, 16), limit))
    assert lost.sum(axis=0) == pytest.approx(
        limit * ((0.5 - free) + (0.5 - 2.0 * free)), rel=1e-5
    )  # a step is a thousandth


def test_same_strain_twice_is_no_slip():
    rng = np.random.default_rng(3)
    strain = np.repeat(np.cumsum(rng.normal(size=(200, 16)), axis=0), 2, axis=0)
    force, lost = device_path(strain, 17.3, np.full(strain.shape, 0.7))
    assert np.array_equal(force[0::2], force[1::2])
    assert not lost[1::2].any()
    assert lost[0::2].sum() > 100.0
