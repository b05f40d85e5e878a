"""Pressures that cannot be are refused, by name, and before a run."""

import numpy as np
import pytest

from weavesim import Sheet
from weavesim.errors import InputError
from weavesim.fabric import glass_polypropylene
from weavesim.process.pressure import Pressure
from weavesim.sheet.blank import Blank


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Pressure("left", (1e3,)), "face = 'left': one of 'top' or 'bottom' is needed"),
        (lambda: Pressure("top", (1e3, 2e3)), "1 times and 2 pressures"),
        (lambda: Pressure("top", (0.0, 1e3), (1.0, 1.0)), "times must increase"),
        (lambda: Pressure("top", (np.inf,)), "finite"),
        (lambda: Pressure("top", (1e3,), elements=np.array([], dtype=int)), "one or more elements"),
        (lambda: Pressure("top", (1e3,), elements=np.array([2, 2])), "list each element once"),
        (lambda: Pressure.ramped("top", 1e3, 0.0), "must increase"),
    ],
)
def test_bad_pressures_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_elements_that_the_blank_does_not_have_are_named():
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)
    pressure = Pressure("top", (1e3,), elements=np.array([0, 16]))
    with pytest.raises(InputError, match="pressure on the top: elements go from 0 to 16; the blank has 16 elements"):
        Sheet(blank, glass_polypropylene(), pressures=(pressure,))


def test_a_curve_is_linear_and_a_part_is_a_part():
    pressure = Pressure.ramped("top", 1e3, 0.1, elements=np.array([1, 3]))
    assert pressure.at(np.array([-1.0, 0.0, 0.025, 0.1, 2.0])).tolist() == [0.0, 0.0, 250.0, 1e3, 1e3]
    assert pressure.acts_on(5).tolist() == [False, True, False, True, False]
    assert Pressure("bottom", (1.0,)).acts_on(2).all()
