"""Measured curves: shape-preserving, merged, smoothed, and as the table of the kernels."""

import math

import numpy as np
import pytest
import scipy.interpolate
from hypothesis import given, settings
from hypothesis import strategies as st

from weavesim.errors import InputError
from weavesim.fabric import BendingCurve, MomentCurve, ShearFriction, glass_polypropylene, load_fabric
from weavesim.fabric.curve import (
    CURVE_PIECE_COUNT,
    LARGEST_TABLE_ERROR,
    MeasuredCurve,
    limited_slopes,
    merged,
    noise,
    table_error,
    tabulate,
)
from weavesim.fabric.shear import LARGEST_SHEAR_ANGLE

PRESET = glass_polypropylene().shear


def test_a_smooth_curve_keeps_its_three_point_slopes():
    """The preset's curve is the same as without limits, bit for bit."""
    angle, values = np.array(PRESET.angle), np.array(PRESET.moment_values)
    slopes = np.gradient(values, angle, edge_order=2)
    assert np.array_equal(PRESET.measured.slopes, slopes)
    assert np.array_equal(PRESET.measured.knots, angle) and np.array_equal(PRESET.measured.values, values)
    assert PRESET.measured.slope_beyond == slopes[-1]


def test_it_is_cubic_between_the_points():
    x = np.linspace(0.0, 1.0, 9)
    curve = MeasuredCurve.through(x, x**2)
    fine = np.linspace(0.0, 1.0, 301)
    assert np.allclose(curve(fine), fine**2, atol=1e-12)
    reference = scipy.interpolate.CubicHermiteSpline(x, curve.values, curve.slopes)
    assert np.allclose(curve(fine), reference(fine), atol=1e-14)
    assert curve.energy == pytest.approx(float(reference.integrate(0.0, 1.0)), rel=1e-13)


@pytest.mark.parametrize("seed", range(20))
def test_a_monotone_curve_is_monotone_and_close_to_pchip(seed):
    random = np.random.default_rng(seed)
    x = np.concatenate([[0.0], np.cumsum(random.uniform(0.01, 1.0, 30))])
    y = np.concatenate([[0.0], np.cumsum(random.exponential(1.0, 30) ** 3)])
    curve, pchip = MeasuredCurve.through(x, y), scipy.interpolate.PchipInterpolator(x, y)
    fine = np.linspace(0.0, x[-1], 20001)
    assert np.diff(curve(fine)).min() >= -1e-9 * y[-1]
    assert np.abs(curve(fine) - pchip(fine)).max() < np.diff(y).max()
    assert curve.energy == pytest.approx(float(pchip.integrate(0.0, x[-1])), rel=0.1)


points = st.lists(st.floats(0.0, 100.0).map(lambda value: round(value, 6)), min_size=2, max_size=40)
gaps = st.lists(st.floats(1e-6, 1.0), min_size=40, max_size=40)


@settings(max_examples=300, deadline=None)
@given(points, gaps)
def test_no_curve_leaves_the_band_between_neighbouring_points(values, steps):
    x = np.concatenate([[0.0], np.cumsum(steps[: len(values) - 1])])
    y = np.array(values)
    curve = MeasuredCurve.through(x, y)
    for share in np.linspace(0.0, 1.0, 23):
        between = curve(x[:-1] + share * np.diff(x))
        slack = 1e-9 * (1.0 + np.abs(y).max())
        assert np.all(between >= np.minimum(y[:-1], y[1:]) - slack)
        assert np.all(between <= np.maximum(y[:-1], y[1:]) + slack)
    assert curve.slope_beyond >= 0.0


def noisy_test(seed: int, *, share: float = 0.01, close: float = 0.004) -> tuple[np.ndarray, np.ndarray]:
    """A picture-frame test as machines write it: noise of a share of the peak, jittered angles, two close points."""
    random = np.random.default_rng(seed)
    count = int(random.integers(40, 140))
    angle = np.sort(random.uniform(0.0, math.radians(50.0), count))
    angle[0] = 0.0
    k = int(random.integers(2, count - 1))
    angle = np.unique(np.append(angle, angle[k] + math.radians(close)))
    moment = PRESET.moment(angle)
    moment = np.abs(moment + share * moment.max() * random.normal(size=len(angle)))
    moment[0] = 0.0
    return angle, moment


@settings(max_examples=300, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([0.001, 0.005, 0.01]), st.sampled_from([1e-7, 0.0004, 0.004, 0.1]))
def test_noisy_tests_stay_in_their_band_or_are_refused_with_a_reason(seed, share, close):
    angle, moment = noisy_test(seed, share=share, close=close)
    try:
        law = MomentCurve(angle=tuple(angle), moment_values=tuple(moment))
    except InputError as error:
        assert "smoothing" in str(error) or "merging" in str(error)
        return
    x = np.linspace(0.0, angle[-1], 4001)
    assert law.moment(x).min() >= 0.0
    assert law.moment(x).max() <= moment.max() * (1.0 + 1e-12)
    assert np.trapezoid(law.moment(x), x) == pytest.approx(np.trapezoid(moment, angle), rel=0.03)
    # what a run reads
    spacing = LARGEST_SHEAR_ANGLE / CURVE_PIECE_COUNT
    coefficient, _ = tabulate(law.moment, spacing, CURVE_PIECE_COUNT)
    inside = int(angle[-1] / spacing)
    for s in np.linspace(0.0, spacing, 9):
        table = coefficient[:inside] @ np.array([1.0, s, s**2, s**3])
        assert table.min() >= -1e-9 * moment.max() and table.max() <= moment.max() * (1.0 + 1e-9)


def test_few_noisy_tests_are_refused():
    refused = 0
    for seed in range(300):
        angle, moment = noisy_test(seed)
        try:
            MomentCurve(angle=tuple(angle), moment_values=tuple(moment))
        except InputError:
            refused += 1
    assert refused <= 15


CASE_15 = "\n".join(
    f"{angle:.3f},{force:.3f}"
    for angle, force in zip(
        (0.0, 0.402, 0.974, 1.75, 2.099, 2.254, 2.999, 5.036, 8.213, 10.402, 11.983, 12.722, 12.726, 13.5, 13.866,
         14.616, 14.682, 15.448, 17.148, 19.97, 21.394, 25.457, 28.116, 30.025, 33.047, 33.351, 34.182, 37.278,
         40.354, 42.345, 42.364, 43.151, 44.778, 46.895, 48.525, 49.578),
        (0.0, 0.004, 0.013, 0.089, 0.081, 0.063, 0.1, 0.168, 0.224, 0.291, 0.353, 0.363, 0.261, 0.303, 0.334, 0.379,
         0.29, 0.319, 0.387, 0.482, 0.501, 0.615, 0.701, 0.752, 0.99, 0.854, 1.051, 1.451, 1.87, 2.256, 2.112, 2.517,
         2.875, 3.517, 4.213, 4.642),
        strict=True,
    )
)  # fmt: skip


def test_the_field_case_stays_between_zero_and_ten(tmp_path):
    """Data 0 to 10 N/m gave a curve of -10.3 to 12.3 N/m."""
    (tmp_path / "frame.csv").write_text(f"angle_deg,force_n\n{CASE_15}\n")
    (tmp_path / "fab.toml").write_text(
        'based_on = "glass-polypropylene"\n[shear]\nkind = "MomentCurve.from_picture_frame"\n'
        'angle = {csv = "frame.csv", column = "angle_deg", scale = 0.0174532925}\n'
        'machine_force = {csv = "frame.csv", column = "force_n"}\n'
        "frame_side = 0.25\nfabric_side = 0.20\nlocking_angle = 0.96\nlocking_stiffness = 1000.0\n"
    )
    law = load_fabric(tmp_path / "fab.toml").shear
    x = np.linspace(0.0, law.angle[-1], 20001)
    assert law.moment(x).min() >= 0.0 and law.moment(x).max() <= max(law.moment_values) < 10.1
    assert np.trapezoid(law.moment(x), x) == pytest.approx(np.trapezoid(law.moment_values, law.angle), rel=0.02)
    assert table_error(law.measured, LARGEST_SHEAR_ANGLE, law.angle[-1]) < LARGEST_TABLE_ERROR


def test_close_points_count_as_one():
    x, y = merged(np.array([0.0, 0.1, 0.1001, 0.1002, 0.5, 0.50001]), np.array([0.0, 1.0, 2.0, 3.0, 5.0, 7.0]), 0.01)
    assert x.tolist() == pytest.approx([0.0, 0.1001, 0.50001]) and y.tolist() == pytest.approx([0.0, 2.0, 6.0])
    far = np.array([0.0, 0.1, 0.2]), np.array([0.0, 1.0, 2.0])
    assert merged(*far, 0.1)[0] is far[0]


@pytest.mark.parametrize("share", [0.005, 0.02, 0.05])
def test_smoothing_stays_within_its_tolerance(share):
    for seed in range(5):
        angle, moment = noisy_test(seed, share=share)
        tolerance = 1.2 * share * PRESET.moment(angle).max()
        law = MomentCurve(angle=tuple(angle), moment_values=tuple(moment), smoothing=tolerance)
        assert np.sqrt(np.mean((law.measured(angle) - moment) ** 2)) < 1.1 * tolerance
        exact = PRESET.moment(angle)
        assert np.abs(law.measured(angle) - exact).max() < 2.5 * tolerance
        fine = np.linspace(0.0, angle[-1], 2001)
        assert law.moment(fine).min() >= 0.0 and law.moment(0.0) == 0.0
        assert np.trapezoid(law.moment(fine), fine) == pytest.approx(np.trapezoid(exact, angle), rel=0.05)
        assert MomentCurve.from_json(law.to_json()) == law


def test_smoothing_that_changes_the_energy_is_refused():
    """Many points at small angles outweigh the few that carry the load."""
    angle = np.append(np.linspace(0.0, 0.3, 100), [0.4, 0.6, 0.8])
    moment = np.where(angle > 0.3, 60.0 * angle**2, 0.0)
    with pytest.raises(InputError, match="smoothing = 4 changes the area .* give a smaller one"):
        MomentCurve(angle=tuple(angle), moment_values=tuple(moment), smoothing=4.0)
    with pytest.raises(InputError, match="too few to be smoothed"):
        MomentCurve(angle=(0.0, 0.5, 0.9), moment_values=(0.0, 5.0, 20.0), smoothing=0.1)


def test_negative_noise_is_named_and_can_be_smoothed():
    angle, moment = noisy_test(11)
    moment[3] = -0.02
    with pytest.raises(InputError, match=r"must not be negative .*smoothing = 1\.\d"):
        MomentCurve(angle=tuple(angle), moment_values=tuple(moment))
    law = MomentCurve(angle=tuple(angle), moment_values=tuple(moment), smoothing=2.0)
    assert law.moment(np.linspace(0.0, 1.5, 1001)).min() >= 0.0
    with pytest.raises(InputError, match="subtract the machine's own force"):
        MomentCurve(angle=tuple(angle), moment_values=(0.0, *(moment[1:] - 25.0)), smoothing=2.0)


def test_a_curve_that_the_table_cannot_follow_is_refused_with_a_way_out():
    angle = np.radians(np.arange(0.0, 50.0, 0.19))
    moment = 10.0 * angle / angle[-1] + 0.8 * (np.arange(len(angle)) % 2)
    moment[0] = 0.0
    with pytest.raises(InputError, match=r"spacing of the table.*smoothing = 0\.\d+ is about its noise"):
        MomentCurve(angle=tuple(angle), moment_values=tuple(moment))
    curvature = np.linspace(0.0, 100.0, 500)
    bending = 1e-3 * curvature + 8e-3 * (np.arange(500) % 2) * (curvature > 0.0)
    with pytest.raises(InputError, match="spacing of the table"):
        BendingCurve(curvature=tuple(curvature), moment_values=tuple(bending))
    with pytest.raises(InputError, match="spacing of the table"):
        ShearFriction(stiffness=10.0, angle=tuple(angle), limit=tuple(0.5 + 0.4 * (np.arange(len(angle)) % 2)))


def test_noise_is_estimated():
    random = np.random.default_rng(1)
    x = np.linspace(0.0, 1.0, 2000)
    assert noise(x, 3.0 * x + 0.1 * random.normal(size=2000)) == pytest.approx(0.1, rel=0.05)
    assert noise(x, 3.0 * x) < 1e-12


def test_bending_curves_do_not_overshoot_either():
    curvature, moment = (0.0, 10.0, 10.01, 50.0, 100.0), (0.0, 0.05, 0.052, 0.1, 0.1)
    law = BendingCurve(curvature=curvature, moment_values=moment)
    fine = np.linspace(0.0, 100.0, 10001)
    assert law.moment(fine).min() >= 0.0 and law.moment(fine).max() <= 0.1 * (1.0 + 1e-12)


@pytest.mark.parametrize(
    ("angle", "moment", "message"),
    [
        ((0.0, 0.1, 0.1, 0.2), (0.0, 1.0, 1.1, 2.0), "entry 2 is 0.1, entry 3 is 0.1: keep one point"),
        ((0.0, 0.2, 0.1, 0.3), (0.0, 1.0, 1.1, 2.0), "entry 2 is 0.2, entry 3 is 0.1: sort"),
        ((0.0, 0.1, 0.2, 0.3, 0.2, 0.1, 0.0), (0.0, 1, 2, 3, 2, 1, 0), "loading and unloading in one column"),
        ((0.3, 0.2, 0.1, 0.0), (3.0, 2.0, 1.0, 0.0), "increase.*they decrease all along; .*reverse order"),
        ((0.0, 0.1, 0.2), (0.0, -1.0, -2.0), "all are .down to -2 N/m.: change the sign"),
        ((0.0, 0.1, 0.2), (-0.0, -1.0, 0.0), "change the sign"),
        ((0.02, 0.1, 0.2), (0.0, 1.0, 2.0), r"the first is 0.02: add the point \(0, 0\)"),
        ((0.0, 0.1, 0.2), (0.4, 1.0, 2.0), "the first is 0.4: subtract what the machine reads"),
    ],
)
def test_points_that_are_no_curve_are_named(angle, moment, message):
    with pytest.raises(InputError, match=message):
        MomentCurve(angle=angle, moment_values=moment)


@pytest.mark.parametrize(
    ("extrapolation", "slope", "trusted"), [("end slope", True, 0.5), ("constant", False, 0.5), ("trusted", True, None)]
)
def test_what_comes_beyond_the_data_is_a_choice(extrapolation, slope, trusted):
    law = MomentCurve(angle=(0.0, 0.25, 0.5), moment_values=(0.0, 4.0, 10.0), extrapolation=extrapolation)
    assert law.trusted_angle == trusted
    beyond = law.moment(np.array([0.5, 1.0]))
    assert beyond[0] == pytest.approx(10.0)
    assert beyond[1] == pytest.approx(10.0 + 0.5 * 28.0 * slope)
    bending = BendingCurve(curvature=(0.0, 25.0, 50.0), moment_values=(0.0, 0.4, 1.0), extrapolation=extrapolation)
    assert bending.trusted_curvature == (None if trusted is None else 50.0)
    assert bending.moment(np.array([100.0]))[0] == pytest.approx(1.0 + 50.0 * 0.028 * slope)
    table = tabulate(law.moment, LARGEST_SHEAR_ANGLE / CURVE_PIECE_COUNT, CURVE_PIECE_COUNT)[0]
    assert (table[-1, 1] > 1.0) == slope


def test_the_end_slope_is_never_that_of_noise_alone():
    """The last two points, 0.2 degrees apart, differ by 5 %: 60 times the slope of the curve."""
    angle = np.radians([*np.arange(0.0, 40.0, 2.0), 39.8])
    moment = 10.0 * angle
    moment[-1] += 2.0
    law = MomentCurve(angle=tuple(angle), moment_values=tuple(moment))
    assert law.measured.slope_beyond < 3.0 * (moment[-1] - moment[-3]) / (angle[-1] - angle[-3])
    falling = MomentCurve(angle=(0.0, 0.25, 0.5), moment_values=(0.0, 4.0, 3.0))
    assert falling.measured.slope_beyond == 0.0


def test_constants_hold_at_any_curvature():
    assert BendingCurve.straight(1e-3).trusted_curvature is None
    assert BendingCurve.from_kawabata(1e-3, 2e-3).trusted_curvature is None


def test_slopes_within_their_limit_keep_their_bits():
    rise, slope = np.array([1.0, 2.0, 3.0]), np.array([0.7, 1.3, 2.4, 3.3])
    assert np.array_equal(limited_slopes(slope, rise), slope)
    assert limited_slopes(np.array([9.0, 9.0, -1.0, 9.0]), rise).tolist() == [3.0, 3.0, 0.0, 9.0]
    assert limited_slopes(np.array([1.0, 0.5, 1.0]), np.array([1.0, -1.0])).tolist() == [1.0, 0.0, 0.0]


@pytest.mark.parametrize("first", [1e-6, 1e-4, 2e-3])
def test_a_point_close_to_the_origin_does_no_harm(first):
    """The lines through few points keep their area, while cubic pieces change with every point."""
    law = MomentCurve(angle=(0.0, first, 0.5, 1.0), moment_values=(0.0, 6.0 * first, 3.0, 9.0))
    assert law.moment(np.array([0.5, 1.0]), 1e-3) == pytest.approx((3.0, 9.0), rel=1e-6)
