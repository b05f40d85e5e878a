"""Values of parameters: as written, within their ranges, with their units."""

import math

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.study.factors import factor_of, parsed_vary
from weavesim.study.schema import VaryTable


def factor(**given):
    return factor_of(VaryTable(key="tools.ring.force", **given))


def test_a_range_has_the_unit_of_its_first_value():
    found = factor(range=("100 N", "2 kN"), count=3)
    assert (found.low, found.high, found.unit) == (100.0, 2000.0, "N")
    assert found.levels() == (100.0, 1050.0, 2000.0)
    assert found.settings(1050.0) == ["tools.ring.force=1050.0 N"]
    assert found.label == "tools.ring.force [N]"


def test_a_log_range_is_even_in_its_logarithm():
    assert factor(range=(1.0, 100.0), count=3, scale="log").levels() == (1.0, 10.0, 100.0)


def test_a_normal_distribution_is_cut_off_at_three_deviations():
    found = factor(mean="0.2", deviation=0.01)
    values = [found.at(share) for share in np.linspace(0.0, 1.0, 2001)]
    assert min(values) == pytest.approx(0.17) and max(values) == pytest.approx(0.23)
    assert np.std(values) == pytest.approx(0.01, rel=0.02)


def test_steps_are_whole_numbers_where_they_can_be():
    found = factor(range=(2, 8), step=2)
    assert found.levels() == (2, 4, 6, 8) and all(isinstance(v, int) for v in found.levels())
    assert found.at(1.0) == 8 and found.at(0.0) == 2


def test_values_may_be_of_any_kind():
    found = factor(values=("a", "b"))
    assert not found.is_numeric and found.settings("a") == ['tools.ring.force="a"']
    assert factor(values=("1 mm", "2 mm")).settings(2.0) == ["tools.ring.force=2.0 mm"]
    assert factor(values=(True, False)).settings(True) == ["tools.ring.force=true"]
    assert factor(values=([1, 2], [3, 4])).settings((1, 2)) == ["tools.ring.force=[1, 2]"]


def test_several_keys_get_the_same_value():
    found = factor_of(VaryTable(key=("a.b", "a.c"), range=(1, 2)))
    assert found.settings(1.5) == ["a.b=1.5", "a.c=1.5"]


def test_values_of_designs_do_not_depend_on_the_last_bits_of_random_numbers():
    found = factor(range=(0.0, math.pi))
    assert found.at(1.0 / 3.0) == found.at(math.nextafter(1.0 / 3.0, 1.0))


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"range": (2.0, 2.0)}, "it is empty"),
        ({"range": (3.0, 2.0)}, "it is empty"),
        ({"range": ("1 N", "2 mm")}, "one unit"),
        ({"range": ("x", 2.0)}, "one unit"),
        ({"range": (0.0, 2.0), "scale": "log"}, "above 0"),
        ({"range": (1.0, 2.0), "step": 5.0}, "at most 1"),
        ({"values": (1.0, 1.0)}, "every value once"),
        ({"mean": 1.0, "deviation": 0.0}, "above 0"),
    ],
)
def test_what_has_no_values_is_refused(given, text):
    with pytest.raises(InputError, match=text):
        factor(**given)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({}, "none is given"),
        ({"range": (1, 2), "values": (1, 2)}, "range and values are given"),
        ({"mean": 1.0}, "both are needed"),
        ({"values": (1.0,)}, "at least two"),
        ({"values": (1.0, 2.0), "count": 3}, "no effect without a range"),
    ],
)
def test_a_table_says_its_values_in_one_way(given, text):
    with pytest.raises(InputError, match=text):
        VaryTable(key="a", **given)


def test_options_are_ranges_or_lists():
    assert parsed_vary("tools.ring.force=100:2000:8").count == 8
    assert parsed_vary("a=1 N:2 N").range == ("1 N", "2 N")
    assert parsed_vary("a=0.1,0.2").values == (0.1, 0.2)
    assert parsed_vary('fabric=x,"y z"').values == ("x", "y z")


@pytest.mark.parametrize("text", ["a", "a=", "a=1:2:x", "a=1:2:3:4", "a=1", "a=1:2:1", "a=:2"])
def test_other_options_are_refused_with_the_form(text):
    with pytest.raises(InputError, match="--vary"):
        parsed_vary(text)


def test_numbers_without_a_unit_have_that_of_the_key_for_readers_alone():
    units = {"tools.ring.force": "N", "tools.die.force": "N", "ply.mesh_size": "m"}
    found = factor(range=(100.0, 2000.0), count=3).with_si_unit(units.get)
    assert found.label == "tools.ring.force [N]" and found.shown(1050.0) == "1050 N"
    assert found.settings(1050.0) == ["tools.ring.force=1050.0"]
    written = factor(range=("1 kN", "2 kN")).with_si_unit(units.get)
    assert written.label == "tools.ring.force [kN]" and written.shown(1.5) == "1.5 kN"
    both = factor_of(VaryTable(key=("tools.ring.force", "ply.mesh_size"), range=(1, 2))).with_si_unit(units.get)
    assert both.shown_unit == ""
    assert factor(values=("a", "b")).with_si_unit(units.get).label == "tools.ring.force"
