"""Single values: one wording for what is wrong, and no bit of a good value changes."""

from decimal import Decimal

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.quantities import finite, positive, unit_vector, vector


@pytest.mark.parametrize("value", [0.1, np.float64(0.1), np.array(0.1), Decimal("0.1")])
def test_a_good_number_keeps_its_bits(value):
    assert finite("x", value).hex() == positive("x", value).hex() == (0.1).hex()
    assert type(finite("x", value)) is type(positive("x", value)) is float
    assert vector("x", (value, 2, -0.0)) == (0.1, 2.0, 0.0)


def test_a_unit_vector_keeps_its_bits_and_others_are_scaled():
    unit = tuple((np.array([1.0, 2.0, 3.0]) / np.linalg.norm([1.0, 2.0, 3.0])).tolist())
    assert unit_vector("axis", unit) == unit
    assert unit_vector("axis", np.array([0.0, 0.0, -4.0])) == (0.0, 0.0, -1.0)


NO_NUMBERS = [True, np.True_, "1.0", b"1", None, [1.0], float("nan"), float("inf"), -float("inf"), 10**400, 1j]


@pytest.mark.parametrize("value", NO_NUMBERS, ids=lambda value: repr(value)[:10])
def test_what_is_no_finite_number_is_refused(value):
    with pytest.raises(InputError, match="^speed = .*: a finite number is needed$"):
        finite("speed", value)
    with pytest.raises(InputError, match="^speed = .*: a finite number above 0 is needed$"):
        positive("speed", value)
    with pytest.raises(InputError, match="^axis = .*: three finite numbers are needed$"):
        vector("axis", (0.0, value, 1.0))


@pytest.mark.parametrize(
    ("check", "message"),
    [
        (lambda: positive("side", 0.0), "side = 0.0: a finite number above 0 is needed"),
        (lambda: positive("side", np.float64(-2.0)), "side = -2.0: a finite number above 0 is needed"),
        (lambda: positive("side", 250, largest=5.0, hint="in metres"), "side = 250: at most 5 is allowed: in metres"),
        (lambda: finite("rest", True), "rest = True: a finite number is needed"),
        (lambda: finite("rest", "1.0"), "rest = '1.0': a finite number is needed"),
        (lambda: vector("axis", 5), "axis = 5: three finite numbers are needed"),
        (lambda: vector("axis", "123"), "axis = '123': three finite numbers are needed"),
        (lambda: vector("axis", np.ones((3, 3))), "three finite numbers are needed"),
        (lambda: unit_vector("axis", (0, 0)), r"axis = \(0, 0\): three finite numbers are needed"),
        (lambda: unit_vector("axis", (0, 0, 0)), r"axis = \(0, 0, 0\): a direction is needed, other than zero"),
    ],
)
def test_a_bad_value_is_named(check, message):
    with pytest.raises(InputError, match=message):
        check()


@pytest.mark.parametrize("value", [(1e300, 0.0, 1.0), (0.0, -1e200, 0.0), (1e308, 1e308, 1e308)])
def test_a_direction_whose_length_overflows_is_refused(value):
    with pytest.raises(InputError, match="axis = .*a direction of moderate length"):
        unit_vector("axis", value)
