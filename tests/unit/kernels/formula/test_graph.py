"""Graphs of formulas: what is simplified, what is left alone, and values by NumPy."""

import math

import numpy as np
import pytest

from weavesim.kernels.formula.graph import FUNCTIONS, Graph, evaluated, in_order


@pytest.fixture
def graph():
    return Graph()


@pytest.fixture
def abc(graph):
    return [graph.symbol(name) for name in "abc"]


def test_the_same_formula_is_the_same_expression(abc):
    a, b, c = abc
    assert a * b + c is c + b * a
    assert a - a == a.graph.number(0.0)
    assert (a + b) * (b + a) is a.graph.product([(a + b, 2)])


def test_like_terms_and_powers_are_collected(graph, abc):
    a, b, _ = abc
    assert a + a is 2.0 * a
    assert 0.5 * (a * b) + 0.5 * (b * a) is a * b
    assert a * a * b / a is a * b
    assert graph.function("sqrt", a) * graph.function("sqrt", a) is a
    assert 1.0 / (1.0 / a) is a


def test_one_plus_a_small_number_loses_nothing(graph, abc):
    e = abc[0]
    assert (1.0 + e) - 1.0 is e
    assert ((1.0 + e) - 1.0) * 2.0 is 2.0 * e
    (value,) = evaluated([((1.0 + e) + abc[1]) - 1.0], {"a": 1e-20, "b": 0.0})
    assert value == 1e-20


def test_groups_of_a_sum_stay(abc):
    """Whoever writes (a - b) + (c - a b) may have reasons: only what cancels is regrouped."""
    a, b, c = abc
    (value,) = evaluated([(a - b) + c], {"a": 1.0, "b": 1.0 - 1e-16, "c": 1e16})
    assert value == (1.0 - (1.0 - 1e-16)) + 1e16
    assert (a - b) + b is a


def test_numbers_are_folded(graph):
    two = graph.number(2.0)
    assert (two * 3.0 + 1.0).is_equal(7.0)
    assert graph.function("sqrt", graph.number(9.0)).is_equal(3.0)
    assert (0.0 * graph.symbol("a")).is_equal(0.0)
    assert graph.comparison("<", two, graph.number(3.0)) is True
    assert math.isinf((1.0 / graph.number(0.0)).value)
    assert graph.power(graph.symbol("a"), graph.number(0.5)) is graph.function("sqrt", graph.symbol("a"))


def test_conditions_that_are_known_choose(graph, abc):
    a, b, _ = abc
    positive = graph.comparison(">", a, graph.number(0.0))
    assert graph.choice(True, a, b) is a and graph.choice(positive, b, b) is b
    assert graph.combination("all", [True, positive]) is positive
    assert graph.combination("all", [False, positive]) is False
    assert graph.combination("any", [True, positive]) is True
    assert graph.combination("any", [False, False]) is False
    assert graph.negation(False) is True


def test_arguments_stand_before_what_is_made_of_them(abc):
    a, b, c = abc
    order = in_order([(a + b) * c])
    assert all(order.index(argument) < order.index(one) for one in order for argument in one.arguments)


def test_only_parameters_make_uniform_expressions(graph, abc):
    p = graph.symbol("p", uniform=True)
    assert (p * 2.0 + 1.0).uniform and graph.number(1.0).uniform
    assert not (p * abc[0]).uniform


def test_values_are_those_of_numpy(graph, abc):
    a, b, c = abc
    points = {name: np.array(values) for name, values in (("a", [0.3, -0.4]), ("b", [0.7, 0.2]), ("c", [2.0, 3.0]))}
    condition = graph.combination("any", [graph.comparison("<", a, graph.number(0.0)), graph.comparison(">=", a, b)])
    formulas = [a * b / c + 3.0 - a, graph.choice(condition, a, c), graph.magnitude(a), graph.larger(a, b)]
    formulas += [graph.smaller(a, b), graph.choice(graph.negation(condition), a, c), graph.power(c, a)]
    values = evaluated(formulas, points)
    x, y, z = points["a"], points["b"], points["c"]
    wanted = [x * y / z + 3.0 - x, np.where(x < 0, x, z), abs(x), np.maximum(x, y), np.minimum(x, y)]
    wanted += [np.where(x < 0, z, x), z**x]
    for value, expected in zip(values, wanted, strict=True):
        np.testing.assert_allclose(value, expected, rtol=1e-15)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_have_their_values(graph, abc, name):
    count = 2 if name in ("atan2", "pow") else 1
    (value,) = evaluated([graph.function(name, *abc[:count])], {"a": 0.3, "b": 0.7})
    assert value == FUNCTIONS[name](*(0.3, 0.7)[:count])
