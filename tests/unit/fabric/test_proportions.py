"""Values of a fabric that hardly fit each other are named."""

import re

import pytest

from weavesim import InputError
from weavesim.fabric import (
    BendingCurve,
    Compaction,
    IsotropicBending,
    LinearMembrane,
    PlainWeave,
    YarnBending,
    glass_polypropylene,
)
from weavesim.fabric.presets import PRESETS
from weavesim.ranges import unusual_values

SOFT = glass_polypropylene().shear.locking_at_most(100.0)


def sentences(**values):
    fabric = glass_polypropylene().model_copy(update={"compaction": Compaction(), **values})
    return list(fabric.disproportions())


@pytest.mark.parametrize("name", PRESETS)
def test_presets_fit_together(name):
    assert not list(PRESETS[name]().disproportions())


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ({"areal_density": 7.43}, "a density of 6192"),
        ({"thickness": 1.2e-2}, "a density of 61.9"),
        ({"thickness": 1.2e-5}, "a density of 6.192e.04"),
        ({"bending": YarnBending(warp=2.9, weft=2.9, twist=0.0)}, "droop"),
        ({"bending": YarnBending(warp=1.0, weft=1.0, twist=0.1)}, "droop over 0.516 m"),
        ({"bending": YarnBending(warp=1.0, weft=1e-3, twist=1e-4)}, "stiffness, 1 N m, .*droop over 0.516 m"),
        ({"bending": YarnBending(warp=1e-3, weft=1e-9, twist=0.0)}, "droop over 0.000516 m"),
        ({"bending": YarnBending(warp=2e-3, weft=1e-3, twist=0.1)}, "twist = 0.1 N m is 70.7 times"),
        ({"bending": IsotropicBending(modulus=20e9)}, "droop"),
        ({"bending": YarnBending(warp=2.9e-9, weft=2.9e-9, twist=0.0)}, "solid plate"),
        ({"unit_cell": PlainWeave.glass_polypropylene(crossover_height=5e-3)}, "times crossover_height"),
        ({"unit_cell": PlainWeave.glass_polypropylene(crossover_height=1e-6)}, "times crossover_height"),
        ({"unit_cell": PlainWeave.glass_polypropylene(weft_half_spacing=0.1e-3)}, "2 weft_half_spacing"),
        (
            {"unit_cell": PlainWeave.glass_polypropylene(weft_modulus=31.8e6), "shear": SOFT},
            "warp is 1000 times as stiff",
        ),
        ({"unit_cell": PlainWeave.glass_polypropylene(warp_cross_section=1e-9), "shear": SOFT}, "weft is 1000 times"),
        (
            {"bending": YarnBending(warp=1e-3, weft=3e-6, twist=1e-5)},
            "bending stiffness is 0.001 N m along the warp and",
        ),
    ],
)
def test_values_that_hardly_fit_are_named(values, word):
    assert any(re.search(word, sentence) for sentence in sentences(**values))


def test_a_stiffness_in_another_unit_is_named_where_it_lowers_a_limit():
    with pytest.raises(
        InputError, match="locking_stiffness .* but the yarn stiffness .* the weft is 1000 times as stiff"
    ):
        glass_polypropylene().model_copy(
            update={"unit_cell": PlainWeave.glass_polypropylene(warp_modulus=31.8e6), "compaction": Compaction()}
        )


def test_a_membrane_of_one_direction_is_only_told(caplog):
    cell = LinearMembrane(warp_stiffness=2e6, weft_stiffness=1.5e3)
    assert not sentences(unit_cell=cell, shear=SOFT) and "the warp is 1333 times as stiff" in caplog.text


def test_no_bending_and_no_height_are_allowed():
    flat = PlainWeave.straight(stiffness_per_width=1e5)
    assert not sentences(unit_cell=flat, bending=IsotropicBending(modulus=0.0), shear=PRESETS_SHEAR)


PRESETS_SHEAR = glass_polypropylene().shear.locking_at_most(100.0)


@pytest.mark.parametrize("end", [0.25, 1.0, 2.5, 4.0])
def test_a_bending_test_in_centimetres_is_named(end):
    curve = BendingCurve(curvature=(0.0, 0.4 * end, end), moment_values=(0.0, 1e-4, 3e-4))
    fabric = glass_polypropylene().model_copy(update={"bending": YarnBending(warp=1e-3, weft=curve, twist=1e-4)})
    assert any(f"write {100 * end:g} for {end:g} 1/cm" in sentence for sentence in unusual_values(fabric))
    for usual in (BendingCurve.from_kawabata(1e-3, 2e-2), curve.model_copy(update={"curvature": (0.0, 100.0, 250.0)})):
        assert not list(unusual_values(usual))
