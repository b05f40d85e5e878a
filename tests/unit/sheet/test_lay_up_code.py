"""The notation of lay-ups, against angles written out by hand."""

import random

import pytest

from weavesim.errors import InputError
from weavesim.sheet.lay_up_code import angles_of, code_of

CODES = {
    "0": (0,),
    "0/45/-45/90": (0, 45, -45, 90),
    "0, 45, -45, 90": (0, 45, -45, 90),
    "[0/90]s": (0, 90, 90, 0),
    "[0/90]S": (0, 90, 90, 0),
    "[0/90]_s": (0, 90, 90, 0),
    "[45/-45]2s": (45, -45, 45, -45, -45, 45, -45, 45),
    "[45/-45]_2s": (45, -45, 45, -45, -45, 45, -45, 45),
    "[±45]2s": (45, -45, 45, -45, -45, 45, -45, 45),
    "[0/90]2": (0, 90, 0, 90),
    "[0/90]2t": (0, 90, 0, 90),
    "(0/90)s": (0, 90, 90, 0),
    "0_3/90": (0, 0, 0, 90),
    "±30_2": (30, 30, -30, -30),
    "+-45/0": (45, -45, 0),
    "+/-45/0": (45, -45, 0),
    "∓45": (-45, 45),
    "[0/[45/-45]2/90]s": (0, 45, -45, 45, -45, 90, 90, -45, 45, -45, 45, 0),
    "[0/90]s/45": (0, 90, 90, 0, 45),
    "22.5°/−67.5°/+.5": (22.5, -67.5, 0.5),
    " [ 0 / 90 ] 2 s ": (0, 90, 0, 90, 90, 0, 90, 0),
}


@pytest.mark.parametrize(("code", "angles"), CODES.items())
def test_a_code_is_read(code, angles):
    assert angles_of(code) == angles
    assert angles_of(code_of(angles_of(code))) == angles


REFUSED = {
    "": "it is empty",
    "  ": "it is empty",
    "0/90s": "'s' is not expected there",
    "0//90": "an angle is missing before '/'",
    "0/": "an angle is missing at the end",
    "/0": "an angle is missing before '/'",
    "[]": "an angle is missing before ']'",
    "[0/90": "the end stands where ']' must close '['",
    "[0/90)": "')' stands where ']' must close '['",
    "0/90]": "']' has no opening bracket",
    "[0/90]x": "s for symmetric or t for total",
    "[0/90]0s": "'0' after a group: a number of repeats from 1 to 500",
    "[0/90]-2": "'-2' after a group",
    "[0/90]1.5": "'1.5' after a group",
    "[0/90]501": "'501' after a group",
    "[[0/90]400]400": "more than 500 plies",
    "0_": "nothing after the underscore",
    "0 90": "'90' is not expected there",
    "--45": "'-' at character 1 is not understood",
    "0/90;nan": "an angle is missing before 'nan'",
    "1e2": "'e' is not expected there",
    "0/90!": "'!' at character 5 is not understood",
}


@pytest.mark.parametrize(("code", "problem"), REFUSED.items())
def test_what_is_no_code_is_refused_with_the_place_and_an_example(code, problem):
    with pytest.raises(InputError) as raised:
        angles_of(code)
    text = str(raised.value)
    assert problem in text and repr(code) in text and "[45/-45]2s" in text


def test_codes_of_lay_ups_are_short():
    assert code_of((0.0, 90.0, 90.0, 0.0)) == "[0/90]s"
    assert code_of((45.0, -45.0) * 2 + (-45.0, 45.0) * 2) == "[45/-45]2s"
    assert code_of((0.0, 90.0) * 3) == "[0/90]3"
    assert code_of((0.0, 0.0)) == "[0]s" and code_of((30.0,)) == "30"


def test_any_lay_up_survives_its_code():
    rng = random.Random(0)
    for _ in range(300):
        angles = tuple(float(rng.choice((0, 45, -45, 90, 22.5))) for _ in range(rng.randint(1, 8)))
        assert angles_of(code_of(angles)) == angles
