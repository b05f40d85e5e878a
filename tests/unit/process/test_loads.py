"""Loads that cannot be are refused."""

import numpy as np
import pytest

from tests.support.runs import one_sheet_run
from weavesim.errors import InputError
from weavesim.process.loads import NodalLoads
from weavesim.sheet.blank import Blank


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"force": np.zeros((3, 3))}, r"force has shape \(3, 3\); finite values of shape \(25, 3\)"),
        ({"couple": np.full((25, 3), np.nan)}, "couple .* finite"),
        ({"times": (0.0, 1.0)}, "2 times and 1 shares|times"),
        ({"times": (1.0, 0.0), "shares": (0.0, 1.0)}, "must increase"),
        ({"shares": (np.inf,)}, "finite"),
    ],
)
def test_bad_loads_are_refused(given, message, fabric):
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)
    with pytest.raises(InputError, match=message):
        one_sheet_run(name="bad", blank=blank, fabric=fabric(), duration=1.0, loads=NodalLoads(**given))
