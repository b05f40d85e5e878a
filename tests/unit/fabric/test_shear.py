"""Shear laws: what they answer, and which values are refused."""

import math

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.fabric.shear import LinearShear, MomentCurve, ShearFriction


def test_picture_frame_conventions_agree():
    """One test in three normalisations: raw force, force per side of the frame, force per area of the fabric."""
    law = MomentCurve(
        angle=tuple(np.linspace(0.0, 0.8, 30)), moment_values=tuple(np.linspace(0.0, 0.8, 30) ** 2 * 50.0)
    )
    angle, frame, specimen = np.linspace(0.0, 0.8, 30), 0.25, 0.2
    moment = law.moment(angle)
    half_angle = 0.25 * np.pi - 0.5 * angle
    force = specimen**2 * moment / (frame * np.sin(half_angle))
    # the power of the machine, by differences of the diagonal
    diagonal = 2.0 * frame * np.cos(half_angle)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(diagonal))])
    assert work[-1] == pytest.approx(specimen**2 * np.trapezoid(moment, angle), rel=2e-3)
    side_force = force / (2.0 * np.cos(half_angle))
    readings = (
        MomentCurve.from_picture_frame(angle, force, frame_side=frame, fabric_side=specimen),
        MomentCurve.from_normalised_force(
            angle, side_force / frame, convention="frame side", frame_side=frame, fabric_side=specimen
        ),
        MomentCurve.from_normalised_force(angle, side_force * frame / specimen**2, convention="fabric area"),
    )
    for reading in readings:
        assert reading.moment(angle) == pytest.approx(moment, rel=1e-12)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: LinearShear(modulus=-1.0), "modulus = -1.0"),
        (lambda: MomentCurve(angle=(0.0, 0.5), moment_values=(0.0,)), "2 angles and 1 moments"),
        (lambda: MomentCurve(angle=(0.1, 0.5), moment_values=(0.0, 1.0)), "start at 0"),
        (lambda: MomentCurve(angle=(0.0, 0.5), moment_values=(1.0, 2.0)), "moments must start at 0"),
        (lambda: MomentCurve(angle=(0.0, 0.5, 0.4), moment_values=(0.0, 1.0, 2.0)), "increase"),
        (lambda: MomentCurve(angle=(0.0, 1.7), moment_values=(0.0, 1.0)), "at most 1.571 rad"),
        (lambda: MomentCurve(angle=(0.0, 0.5), moment_values=(0.0, -1.0)), "moments must not be negative"),
        (
            lambda: ShearFriction.from_loading_and_unloading((0.0, 0.5), (0.0, 1.0), (0.0, 2.0), stiffness=1.0),
            "unloading lies above loading",
        ),
        (lambda: MomentCurve.from_polynomial("ab"), "coefficients = 'ab': a list of at least one number"),
        (lambda: MomentCurve.from_polynomial(()), "coefficients = .*: a list of at least one number"),
        (lambda: MomentCurve.from_polynomial(3.0), "coefficients = 3.0: a list of at least one number"),
        (lambda: MomentCurve.from_polynomial((1.0, None)), r"coefficients\[1\] = None: a finite number"),
        (lambda: MomentCurve.from_stress_polynomial(("x",), 1e-3), r"tangent_coefficients\[0\] = 'x'"),
        (lambda: MomentCurve(angle=(0.0, 1.7), moment_values=(0.0, 1.0)), "at most 1.571 rad is allowed$"),
        (lambda: MomentCurve(angle=(0.0, True), moment_values=(0.0, 1.0)), "not true or false"),
        (lambda: LinearShear(modulus=True), "modulus = True: a number is needed"),
        (lambda: ShearFriction(stiffness=1.0, limit=(1.0, 2.0), angle=(0.0, 30.0)), "write 0.5236 for 30 degrees"),
        (lambda: MomentCurve.from_loading_and_unloading((0.0, 0.5), (0.0, 1.0), ("a", "b")), "unloading: a list"),
        (
            lambda: ShearFriction.from_loading_and_unloading((0.0, 0.5), (0.0, 1.0), (0.0, 1.0), stiffness=1.0),
            "no effect",
        ),
        (lambda: MomentCurve(angle=(0.0, math.nan), moment_values=(0.0, 1.0)), "finite"),
        (lambda: MomentCurve(angle=(0.0, 0.5), moment_values=(0.0, 1.0), locking_stiffness=-1.0), "locking_stiffness"),
    ],
)
def test_bad_laws_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_polynomial_of_the_moment_begins_with_its_linear_term():
    curve = MomentCurve.from_polynomial([30.0, -40.0, 100.0])
    angle = np.linspace(0.0, math.radians(55.0), 77)
    expected = 30.0 * angle - 40.0 * angle**2 + 100.0 * angle**3
    assert curve.moment(angle, 1e-3) == pytest.approx(expected, abs=1e-4 * expected.max())
    slope = np.diff(curve.moment(np.radians([55.0, 60.0, 70.0]), 1e-3)) / np.radians([5.0, 10.0])
    assert slope[0] == pytest.approx(slope[1])


def test_curve_goes_on_beyond_its_end_and_locks():
    curve = MomentCurve(
        angle=(0.0, 0.5, 1.0),
        moment_values=(0.0, 1.0, 3.0),
        locking_angle=1.2,
        locking_width=0.1,
        locking_stiffness=50.0,
    )
    angle = np.linspace(1.0, 1.2, 21)
    slope = np.diff(curve.moment(angle)) / np.diff(angle)
    assert np.allclose(slope, slope[0], rtol=1e-9)
    assert slope[0] > 0.0
    beyond = np.linspace(1.35, 1.5, 16)
    assert np.allclose(np.diff(curve.moment(beyond)) / np.diff(beyond), slope[0] + 50.0, rtol=1e-9)
    # smooth where it begins
    start = 1.2 + np.array([-1e-6, 1e-6])
    assert np.diff(curve.moment(start))[0] / 2e-6 == pytest.approx(slope[0], rel=1e-3)


def test_linear_law_is_equation_four():
    """Half of t G_12 sin cos: the tensor component of the strain, not the angle."""
    law = LinearShear(modulus=3.0e6)
    assert law.moment(np.array(0.3), 1e-3) == pytest.approx(0.5 * 1e-3 * 3.0e6 * np.sin(0.3) * np.cos(0.3))
    assert law.moment(np.array(1e-6), 1e-3) == pytest.approx(0.5 * 1e-3 * 3.0e6 * 1e-6)
