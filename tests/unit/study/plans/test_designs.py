"""Designs cover what they promise."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.study.factors import Factor
from weavesim.study.plans.designs import factorial, latin_hypercube, scenarios, sobol_design

X, Y = Factor("x", ("x",), count=3), Factor("y", ("y",), choices=("a", "b"), scale="values")


def test_a_factorial_has_every_combination():
    assert factorial([X, Y]) == [(0.0, "a"), (0.0, "b"), (0.5, "a"), (0.5, "b"), (1.0, "a"), (1.0, "b")]


def test_a_range_without_a_count_is_refused():
    with pytest.raises(InputError, match="x: count is required"):
        factorial([Factor("x", ("x",))])


def test_too_many_combinations_are_refused():
    with pytest.raises(InputError, match="latin-hypercube or sobol"):
        factorial([Factor(name, (name,), count=101) for name in "abc"])


def test_a_latin_hypercube_has_one_point_in_each_part():
    points = np.array(latin_hypercube([X, Factor("z", ("z",), low=-1.0)], 10, 0))
    assert sorted((points[:, 0] * 10).astype(int)) == list(range(10))
    assert sorted(((points[:, 1] + 1.0) * 5).astype(int)) == list(range(10))
    assert latin_hypercube([X], 5, 1) == latin_hypercube([X], 5, 1) != latin_hypercube([X], 5, 2)


def test_sobols_design_exchanges_one_column_at_a_time():
    points = np.array(sobol_design([Factor(name, (name,)) for name in "abc"], 8, 0)).reshape(5, 8, 3)
    a, b = points[:2]
    for k in range(3):
        assert np.array_equal(points[2 + k][:, k], b[:, k])
        rest = [j for j in range(3) if j != k]
        assert np.array_equal(points[2 + k][:, rest], a[:, rest])


def test_scenarios_are_the_same_for_all_candidates():
    assert scenarios([X], 4, 0) == scenarios([X], 4, 0) and scenarios([], 4, 0) == []
