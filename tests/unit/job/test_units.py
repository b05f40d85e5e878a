"""Texts with units become the numbers that a script would have, to the bit, or are refused with what to write."""

import math

import pytest

from weavesim.job.units import EXAMPLES, in_units, length_unit, number_of
from weavesim.ranges import QUANTITIES, SLIPS


@pytest.mark.parametrize(
    ("text", "quantity", "number"),
    [
        ("5 mm", "length", 0.005),
        ("61.2 mm", "length", 0.0612),
        ("9mm", "length", 0.009),
        ("0.25", "length", 0.25),
        ("2 in", "length", 0.0508),
        ("1.2e1 cm", "length", 0.12),
        ("20 kPa", "pressure", 20.0e3),
        ("45 deg", "angle", 45.0),
        ("45°", "angle", 45.0),
        ("180 deg", "turn", math.pi),
        ("600 N", "force", 600.0),
        ("0.6 kN", "force", 600.0),
        ("600 g/m^2", "areal density", 0.6),
        ("2.5 g/cm³", "fibre density", 2500.0),
        ("500 mm/s", "speed", 0.5),
        ("2 us", "time step", 2e-6),
        ("2 µs", "time step", 2e-6),
        ("500 ns", "time step", 5e-7),
        ("30 mm/min", "speed", 0.0005),
        ("20 %", "friction", 0.2),
        ("-3 mm", "position", -0.003),
    ],
)
def test_a_text_is_the_number_that_a_script_has(text, quantity, number):
    row = QUANTITIES[quantity]
    found = number_of(text, row)
    assert found == number if quantity not in ("turn",) else math.isclose(found, number, rel_tol=1e-15)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("5 mmm", "did you mean 'mm'"),
        ("5 kg", "'kg' is no unit of it, write '5 mm'"),
        ("five", "a number with its unit is needed"),
        ("5 mm + 2 in", "no unit that is known"),
        ("1e999 mm", "finite"),
        ("__import__('os')", "a number with its unit"),
        ("5,5 mm", "write '5.5 mm'"),
        ("5 mm, 3", "no unit that is known"),
        ("", "a number with its unit"),
        ("9" * 100, "a number with its unit"),
    ],
)
def test_what_is_none_is_refused(text, words):
    with pytest.raises(ValueError, match="(?s).*" + words.replace("(", r"\(").replace("+", r"\+")):
        number_of(text, QUANTITIES["length"])


@pytest.mark.parametrize(
    ("text", "quantity", "words"),
    [
        ("10 mM", "length", "'mM': capitals count in units, since m is milli and M is mega: write 'mm'"),
        ("10 Mm", "length", "write 'mm'"),
        ("10 MM", "length", "write 'mm'"),
        ("10 M", "length", "write 'm'"),
        ("10 uM", "length", "write 'um'"),
        ("5 KN", "force", "write 'kN'"),
        ("5 kn", "force", "write 'kN'"),
        ("5 mn", "force", "write 'mN' or 'MN'"),
        ("5 mpa", "pressure", "write 'MPa'"),
        ("5 KPA", "pressure", "write 'kPa'"),
        ("5 MS", "time", "write 'ms'"),
        ("5 KN/mm", "membrane stiffness", "no unit that is known"),
    ],
)
def test_capitals_that_may_mean_another_unit_are_refused(text, quantity, words):
    with pytest.raises(ValueError, match=words):
        number_of(text, QUANTITIES[quantity])


@pytest.mark.parametrize(
    ("text", "quantity", "number"),
    [("2 MN", "force", 2e6), ("2 mN", "force", 2e-3), ("1 Inch", "length", 0.0254), ("45 DEG", "angle", 45.0),
     ("3 MPa", "pressure", 3e6), ("2 Metres", "length", 2.0)],
)  # fmt: skip
def test_capitals_that_mean_one_thing_are_taken(text, quantity, number):
    assert number_of(text, QUANTITIES[quantity]) == number


def test_the_unit_of_a_file_has_its_capitals_too():
    with pytest.raises(ValueError, match="capitals count in units, .* write 'mm'"):
        length_unit("MM")


def test_an_angle_is_no_plain_number():
    with pytest.raises(ValueError, match="'deg' is no unit of it"):
        number_of("45 deg", QUANTITIES["friction"])


def test_lists_are_converted_however_nested():
    assert in_units([["1 mm", 2.0], ["3 cm", "4"]], QUANTITIES["position"]) == ((0.001, 2.0), (0.03, 4.0))


def test_every_unit_of_the_table_has_an_example_that_is_read():
    assert set(EXAMPLES) == set(SLIPS)
    for row in QUANTITIES.values():
        assert math.isfinite(number_of(EXAMPLES[row.unit], row))


@pytest.mark.parametrize(
    ("text", "metres"), [("mm", 0.001), ("m", 1.0), ("inch", 0.0254), ("in", 0.0254), ("cm", 0.01)]
)
def test_units_of_files(text, metres):
    assert length_unit(text) == metres


@pytest.mark.parametrize("text", ["kg", "furlong", "", "mm^2"])
def test_no_units_of_files(text):
    with pytest.raises(ValueError, match="a unit of length is needed"):
        length_unit(text)
