"""Trims: closed curves, and what they refuse."""

import numpy as np
import pytest

from weavesim import InputError, Stage, Trim

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


def test_a_single_curve_will_do():
    one = Trim(SQUARE)
    assert one == Trim((np.array(SQUARE),)) == Trim(np.array(SQUARE))
    assert (one.view, one.keeps, one.sheet) == ("formed", "inside", None)
    assert len(Trim([SQUARE, SQUARE[:3]]).curves) == 2
    stage = Stage("trim", 1.0, trims=(one,))
    assert Stage.from_json(stage.to_json()) == stage


@pytest.mark.parametrize(
    ("curves", "text"),
    [
        ((), "closed curve is needed"),
        (SQUARE[:2], "at least three"),
        ([(0.0, 0.0, 0.0)] * 4, "of shape"),
        ([(0.0, np.nan), (1.0, 0.0), (0.0, 1.0)], "finite"),
    ],
)
def test_what_is_no_closed_curve_is_refused(curves, text):
    with pytest.raises(InputError, match=text):
        Trim(curves)
