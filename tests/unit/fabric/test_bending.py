"""Bending laws: what they answer, and which values are refused."""

import math

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.fabric.bending import BendingCurve, IsotropicBending, YarnBending


def test_kawabata_numbers_come_back():
    """B and 2HB: slope and height of the loop, measured on the law as the tester does, between 0.5 and 1.5 /cm."""
    law = BendingCurve.from_kawabata(rigidity=8e-6, hysteresis=6e-4, slip_curvature=10.0)
    path = np.concatenate([np.linspace(0.0, 250.0, 500), np.linspace(250.0, -250.0, 1000)])
    spring, slip, moments = law.friction_stiffness, 0.0, []
    for kappa in path:
        slip = kappa - np.clip(kappa - slip, -law.friction_limit / spring, law.friction_limit / spring)
        moments.append(float(law.moment(np.array(kappa))) + spring * (kappa - slip))
    up, down = (
        np.interp([50.0, 150.0], path[:500], moments[:500]),
        np.interp([50.0, 150.0], path[500:][::-1], moments[500:][::-1]),
    )
    assert (up[1] - up[0]) / 100.0 == pytest.approx(8e-6, rel=1e-3)
    assert up - down == pytest.approx(6e-4, rel=1e-3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: IsotropicBending(modulus=-1.0), "modulus = -1.0"),
        (lambda: IsotropicBending(modulus=1.0, poisson_ratio=0.5), "poisson_ratio = 0.5"),
        (lambda: IsotropicBending(modulus=1.0, poisson_ratio=math.nan), "poisson_ratio"),
        (lambda: YarnBending(warp=-1.0, weft=1.0, twist=1.0), "warp = -1.0"),
        (lambda: YarnBending(warp=1.0, weft=1.0, twist=1.0, coupling=1.1), "coupling"),
        (
            lambda: BendingCurve.from_loading_and_unloading(
                (0.0, 10.0, 20.0), (0.0, 1.0, 2.0), (0.0, 2.0, 3.0), friction_stiffness=1.0
            ),
            "unloading lies above loading",
        ),
        (lambda: BendingCurve.from_kawabata(-1e-3, 1e-2), "rigidity = -0.001"),
        (lambda: BendingCurve.from_kawabata(1e-3, -1e-2), "hysteresis = -0.01"),
        (lambda: BendingCurve.from_kawabata("0.5", 1e-2), "rigidity = '0.5'"),
        (lambda: BendingCurve(curvature=(0.0, 1.0), moment_values=(0.0, -1.0)), "but all are: change the sign"),
        (lambda: BendingCurve.from_kawabata(1e-3, 1e-2, slip_curvature=0.0), "slip_curvature = 0"),
        (lambda: BendingCurve.from_kawabata(1e-3, 1e-2, slip_curvature="x"), "slip_curvature = 'x'"),
        (
            lambda: BendingCurve.from_loading_and_unloading(
                (0.0, 1.0), (0.0, 1.0, 2.0), (0.0, 1.0), friction_stiffness=1.0
            ),
            "2 of curvature, 3 of loading, 2 of unloading",
        ),
    ],
)
def test_bad_laws_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
