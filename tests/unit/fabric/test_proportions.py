"""Values of a fabric that hardly fit each other are named."""

import re

import pytest

from weavesim.fabric import BendingCurve, Compaction, IsotropicBending, PlainWeave, YarnBending, glass_polypropylene
from weavesim.fabric.presets import PRESETS
from weavesim.ranges import unusual_values


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
    ],
)
def test_values_that_hardly_fit_are_named(values, word):
    assert any(re.search(word, sentence) for sentence in sentences(**values))


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
