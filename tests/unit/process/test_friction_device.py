"""Friction laws on the device: viscosities as far as an explicit step carries them."""

import pytest

from weavesim.process import Coulomb, PressureFriction, StribeckFriction, ViscousFilm, YarnAngleFriction
from weavesim.process.friction import in_words, law_of
from weavesim.process.friction_device import argument_kind, carried_rate, viscous_rates, viscous_share

RISING = StribeckFriction((0.0, 1e-2), (0.1, 0.3), 2.0)


def test_every_law_has_its_argument():
    tables = (kind((0.0, 1.0), (0.1, 0.2)) for kind in (PressureFriction, YarnAngleFriction))
    laws = (Coulomb(0.1), ViscousFilm(1.0, 1e-3), *tables, RISING)
    assert len({argument_kind(law) for law in laws}) == 4
    assert argument_kind(laws[0]) == argument_kind(laws[1])


def test_a_step_carries_a_tenth_of_what_would_stop_a_sheet_at_once():
    assert carried_rate(0.5, 1e-6) == pytest.approx(0.1 * 0.5 / 1e-6)
    carried = 100.0
    # a film of any viscosity drags at most as much as is carried
    assert viscous_rates(ViscousFilm(0.05, 1e-3)) == pytest.approx((0.0, 50.0))
    assert viscous_rates(ViscousFilm(0.05, 1e-3), carried) == pytest.approx((0.0, 50.0 / 1.5))
    assert viscous_rates(ViscousFilm(1e9, 1e-3), carried)[1] == pytest.approx(carried)
    assert viscous_share(ViscousFilm(0.05, 1e-3), carried) == pytest.approx(1.0 / 1.5)
    # so does the slope of a Stribeck curve times its viscosity: 20 per m, 40 Pa s/m
    assert viscous_rates(RISING, carried) == pytest.approx((2.0 / 1.4, 0.0))
    assert viscous_share(RISING, carried) == pytest.approx(1.0 / 1.4)
    assert viscous_share(StribeckFriction((0.0, 1e-2), (0.3, 0.1), 2.0), carried) == 1.0
    assert viscous_share(Coulomb(0.2), carried) == 1.0


def test_words_for_logs():
    assert in_words(0.25) == "friction 0.25" and in_words(Coulomb(0.25)) == "Coulomb 0.25"
    assert in_words(RISING) == "StribeckFriction 0.1 to 0.3"
    assert law_of(0.25) == Coulomb(0.25) and law_of(RISING) is RISING
