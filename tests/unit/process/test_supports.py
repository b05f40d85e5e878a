"""Supports that cannot be are refused."""

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.errors import InputError
from weavesim.process.strokes import Fixed, SmoothStroke, Stroke
from weavesim.process.supports import Drive, Support

PULL = SmoothStroke.ramped(1e-3, speed=1.0, ramp_time=1e-4)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Support("grip", np.array([0.5])), "indices of one or more nodes"),
        (lambda: Support("grip", np.array([], dtype=int)), "indices of one or more nodes"),
        (lambda: Support("grip", [1, 2, 1]), "listed twice"),
        (lambda: Support("grip", [1], displacements="xw"), 'give some of "xyz"'),
        (lambda: Drive(PULL, (np.nan, 0.0, 0.0)), "finite values"),
        (lambda: Drive(PULL, (1.0, 0.0)), "finite values"),
        (lambda: Drive(PULL, ("0", "1", "0")), "an array of float64 is needed"),
        (lambda: Drive(PULL, [[1.0, 0.0, 0.0], [1.0]]), "rows of equal length"),
        (lambda: Drive(0.5, (1.0, 0.0, 0.0)), "SmoothStroke, PathMotion is needed"),
        (lambda: Drive(Fixed(), (1.0, 0.0, 0.0)), "must be one of Stroke, SmoothStroke"),
        (lambda: Support("grip", [1, 2], (Drive(PULL, np.ones((3, 3))),)), "3 directions for 2 nodes"),
        (lambda: Support("grip", [1, 2], (Drive(PULL, (0.0, 1.0, 0.0)),), displacements="xz"), "driven or free"),
        (lambda: Support("grip", [1], (Drive(Stroke((0.0,), (1e-3,)), (1.0, 0.0, 0.0)),)), "must start from 0"),
        (lambda: SmoothStroke((0.0, 1.0), (0.0, 1.0), (0.0,)), "2 times and 1 speeds"),
        (lambda: SmoothStroke((0.0, 1.0), (0.0, 1.0), (0.0, np.inf)), "entry 1 = inf: a finite number is needed"),
        (lambda: PULL.and_back(rest=-1.0), "must not be negative"),
        (lambda: small_run(supports=[Support("grip", [25])]), "counted from 0"),
        (lambda: small_run(supports=[Support("a", [1, 2]), Support("b", [2, 3])]), "node 2 is also held by a"),
        (lambda: small_run(supports=[Support("a", [1]), Support("a", [3])]), "of entry 1 is that of entry 0 already"),
        (lambda: small_run(supports=["grip"]), "supports.0 = 'grip': a Support is needed"),
        (
            lambda: small_run(supports=[Support("a", [0, 7], (Drive(PULL, (1.0, 1.0, 0.0)),))], symmetry=("y",)),
            "off the symmetry plane y = 0",
        ),
    ],
)
def test_nonsense_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
