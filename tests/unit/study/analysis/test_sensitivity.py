"""What matters, by designs whose answer is known."""

from itertools import product

import numpy as np
import pytest

from weavesim.study.analysis.sensitivity import level_effects, rank_effects, sobol_effects, without_effect
from weavesim.study.factors import Factor
from weavesim.study.plans.designs import sobol_design

X, Y = Factor("x", ("x",)), Factor("y", ("y",))
C = Factor("c", ("c",), choices=("a", "b"), scale="values")


def test_indices_of_a_sum_are_the_shares_of_its_variance():
    points = np.array(sobol_design([X, Y], 256, 0))
    one, other = sobol_effects([X, Y], points @ [1.0, 2.0], 256, 0)
    assert one.value == pytest.approx(0.2, abs=0.02) and other.total == pytest.approx(0.8, abs=0.02)
    assert one.low < 0.2 < one.high
    assert sobol_effects([X, Y], points @ [1.0, 2.0], 256, 0)[0] == one  # intervals are repeatable


def test_a_constant_has_no_effects():
    assert [e.value for e in sobol_effects([X], [3.0] * 24, 8, 0)] == [0.0]


def test_shares_between_levels():
    points = list(product((0.0, 1.0, 2.0), ("a", "b")))
    values = [2.0 * x + (0.5 if c == "b" else 0.0) for x, c in points]
    one, other = level_effects([X, C], points, values)
    assert one.value + other.value == pytest.approx(1.0) and one.value > 0.9
    assert other.chance > 0.5 and one.chance < 0.05


def test_a_share_needs_values_that_occur_twice():
    assert level_effects([X], [(0.0,), (1.0,), (2.0,)], [1.0, 5.0, 2.0]) == []


def test_ranks_take_any_monotonous_response():
    rng = np.random.default_rng(0)
    points = [(x, c) for x, c in zip(rng.random(30), rng.choice(["a", "b"], 30), strict=True)]
    one, other = rank_effects([X, C], points, [np.exp(-5.0 * x) for x, _ in points])
    assert one.value == pytest.approx(-1.0) and other.kind == "levels" and other.value < 0.3


def test_idle_factors_are_found_by_pairs_alone():
    points = list(product((0.0, 1.0), (0.0, 1.0)))
    assert without_effect([X, Y], points, [(x,) for x, _ in points]) == {"y": 2}
    assert without_effect([X, Y], [(0.0, 0.0), (1.0, 1.0)], [(1.0,), (1.0,)]) == {}
