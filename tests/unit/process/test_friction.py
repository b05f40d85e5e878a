"""Friction laws and interfaces are checked before a run."""

import numpy as np
import pytest

from tests.support.stacked_plies import THICKNESS, ply, square, stack_setup
from weavesim import InputError, Setup
from weavesim.process import (
    Coulomb,
    Friction,
    Interface,
    PressureFriction,
    StribeckFriction,
    ViscousFilm,
    YarnAngleFriction,
)

PLIES = [ply("lower", square(0.01, 0.01)), ply("upper", square(0.01, 0.01, THICKNESS))]


def test_tables_are_in_the_units_of_the_kernels():
    angles, coefficients = YarnAngleFriction((0.0, 90.0), (0.1, 0.4)).table()
    np.testing.assert_allclose(angles, (0.0, 0.5 * np.pi))
    np.testing.assert_allclose(coefficients, (0.1, 0.4))
    assert Coulomb(0.3).table()[1].tolist() == [0.3]
    assert ViscousFilm(100.0, 1e-4, 0.05).table()[1].tolist() == [0.05]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Coulomb(-0.1), "at least 0"),
        (lambda: PressureFriction((0.0,), (0.2,)), "at least two"),
        (lambda: PressureFriction((0.0, 1e4), (0.2,)), "the same number of both"),
        (lambda: PressureFriction((1e4, 0.0), (0.2, 0.3)), "it must increase"),
        (lambda: YarnAngleFriction((0.0, 120.0), (0.2, 0.3)), "at most 90"),
        (lambda: StribeckFriction((0.0, 1.0), (0.2, -0.3), 100.0), "must not be negative"),
        (lambda: ViscousFilm(100.0, 0.0), "above 0"),
        (lambda: Interface("a", "a"), "joins two sheets"),
        (lambda: Interface("a", "b", stiffness_share=0.5), "at most 0.2"),
    ],
)
def test_bad_laws_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"interfaces": (Interface("lower", "uper"),)}, "no sheet 'uper'.*did you mean 'upper'"),
        ({"interfaces": (Interface("lower", "upper"), Interface("upper", "lower"))}, "is that of entry 0 already"),
        ({"dynamics": {"contact_thickness": "current"}}, "at the initial thickness"),
    ],
)
def test_bad_interfaces_are_refused(change, message):
    with pytest.raises(InputError, match=message):
        stack_setup(PLIES, Coulomb(0.2), duration=1e-3, **change)


def test_interfaces_survive_json():
    setup = stack_setup(PLIES, StribeckFriction((0.0, 1.0), (0.2, 0.3), 100.0), duration=1e-3)
    again = Setup.from_json(setup.to_json())
    assert again == setup and isinstance(again.interfaces[0].friction, Friction)
