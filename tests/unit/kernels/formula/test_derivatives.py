"""Derivatives of formulas against differences, in double precision."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from weavesim.kernels.formula.derivatives import Derivatives
from weavesim.kernels.formula.graph import FUNCTIONS, Graph, evaluated

NAMES = ("a", "b", "c")
SMOOTH = [name for name in FUNCTIONS if name not in ("floor", "ceil")]
unit = st.floats(0.1, 0.9)


def symbols():
    graph = Graph()
    return graph, [graph.symbol(name) for name in NAMES]


def differences(expression, name, point, change=1e-6):
    ends = [evaluated([expression], point | {name: point[name] + sign * change})[0] for sign in (1.0, -1.0)]
    return (ends[0] - ends[1]) / (2.0 * change)


def assert_derivatives(expression, point):
    for name in NAMES:
        (value,) = evaluated([Derivatives(expression.graph.symbol(name))(expression)], point)
        assert value == pytest.approx(differences(expression, name, point), rel=2e-7, abs=2e-8), name


@pytest.mark.parametrize("name", SMOOTH)
@given(a=unit, b=unit)
@settings(max_examples=20, deadline=None, derandomize=True)
def test_functions(name, a, b):
    graph, (first, second, _) = symbols()
    arguments = (first * second, second + first) if name in ("atan2", "pow") else (first * second,)
    assert_derivatives(graph.function(name, *arguments), {"a": a, "b": b, "c": 0.0})


@given(a=unit, b=unit, c=unit)
@settings(max_examples=50, deadline=None, derandomize=True)
def test_sums_products_and_choices(a, b, c):
    graph, (x, y, z) = symbols()
    member = graph.larger(x - 0.5 * y, graph.number(0.0))
    point = {"a": a, "b": b, "c": c}
    formula = 3.0 * x * x / (y + z) + 0.5 * member * member + graph.magnitude(y - 2.0) * z - 1.0 / (x * z)
    assert_derivatives(formula, point)
    second = Derivatives(y)(Derivatives(x)(formula))
    kink = abs(a - 0.5 * b) < 1e-5
    (value,) = evaluated([second], point)
    assert kink or value == pytest.approx(differences(Derivatives(x)(formula), "b", point), rel=1e-6, abs=1e-6)


def test_order_of_differentiation_does_not_matter():
    graph, (x, y, _) = symbols()
    formula = graph.function("sqrt", x * x + y) * graph.function("exp", x / y)
    point = {"a": 0.3, "b": 0.8}
    values = evaluated([Derivatives(y)(Derivatives(x)(formula)), Derivatives(x)(Derivatives(y)(formula))], point)
    assert values[0] == pytest.approx(values[1], rel=1e-14)


def test_a_branch_that_is_not_taken_does_not_matter():
    """The root has no derivative at zero; it is not taken there."""
    graph, (x, _, _) = symbols()
    root = graph.choice(graph.comparison(">", x, graph.number(0.0)), graph.function("sqrt", x), 2.0 * x)
    assert evaluated([Derivatives(x)(root)], {"a": 0.0})[0] == 2.0


def test_floors_and_parameters_have_none():
    graph, (x, _, _) = symbols()
    p = graph.symbol("p", uniform=True)
    assert Derivatives(x)(graph.function("floor", x)).is_equal(0.0)
    assert Derivatives(x)(p * p).is_equal(0.0)
    assert Derivatives(x)(graph.function("pow", x, p)) is p * graph.function("pow", x, p - 1.0)


def test_angle_at_the_origin_has_derivative_zero():
    graph, (x, y, _) = symbols()
    assert np.all(
        evaluated([Derivatives(v)(graph.function("atan2", x, y)) for v in (x, y)], {"a": 0.0, "b": 0.0}) == np.zeros(2)
    )
