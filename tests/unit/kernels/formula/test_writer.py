"""Formulas in C++ against NumPy: all lanes, both numbers of lanes, angles in all quadrants."""

import numpy as np
import pytest
import warp as wp

from weavesim.device import initialise
from weavesim.kernels.formula.graph import FUNCTIONS, Graph, evaluated
from weavesim.kernels.formula.writer import Constants, lane_loop

STATE = ("a", "b", "c")
Pair = wp.types.vector(24, wp.float64)


@wp.struct
class Given:
    constants: Pair


def formulas(graph):
    a, b, c = (graph.symbol(name) for name in STATE)
    p = graph.symbol("p", uniform=True)
    loose = graph.comparison(">", p, graph.number(1.0))
    turned = graph.combination("any", [graph.comparison("<", a, b), graph.negation(graph.comparison("<=", b, c))])
    found = [
        0.5 * p * a * a + p * a * b - 3.0 * c / b + p * p,
        graph.choice(loose, graph.larger(a, graph.number(0.0)), a) * p * a,
        graph.choice(turned, a * b * c, -a) + graph.choice(graph.combination("all", [turned, loose]), c, b),
        graph.function("atan2", a, b),
        graph.function("sqrt", a * a + b * b) + 1.0 / (a * a + b * b),
        a,
        graph.number(2.5),
        p * 3.0,
    ]
    inside = 0.5 * (a / graph.function("sqrt", 1.0 + a * a)) + 0.5
    for name in FUNCTIONS:
        if name != "atan2":
            found.append(graph.function(name, inside, *([c] if name == "pow" else [])))
    return found


def compiled_values(lanes, outputs, points, p):
    """What the C++ of the formulas gives, (formulas, lanes)."""
    constants = Constants()
    text = lane_loop(outputs, constants, {name: f"x.data[{k}][i]" for k, name in enumerate(STATE)}, lanes, "double")
    State, Rows = wp.types.matrix((3, lanes), wp.float64), wp.types.matrix((len(outputs), lanes), wp.float64)

    @wp.func_native(text)
    def compiled(p: Given, x: State) -> Rows: ...

    @wp.kernel(module="unique", enable_backward=False)
    def evaluate(p: Given, x: wp.array(dtype=State), found: wp.array(dtype=Rows)):
        found[0] = compiled(p, x[0])

    given = Given()
    values = constants.values({"p": p})
    given.constants = Pair(*values, *[0.0] * (24 - len(values)))
    found = wp.zeros(1, dtype=Rows, device="cpu")
    state = wp.array(points[None], dtype=State, device="cpu")
    wp.launch(evaluate, dim=1, inputs=[given, state, found], device="cpu")
    return found.numpy()[0]


@pytest.mark.parametrize("lanes", [1, 16])
def test_formulas_have_the_values_of_numpy(lanes):
    initialise()
    graph = Graph()
    outputs = formulas(graph)
    for seed, p in ((1, 0.7), (2, 1.9)):
        points = np.random.default_rng(seed).uniform(-2.0, 2.0, (3, lanes))
        found = compiled_values(lanes, outputs, points, p)
        wanted = evaluated(outputs, {"p": p} | dict(zip(STATE, points, strict=True)))
        for row, value in zip(found, wanted, strict=True):
            np.testing.assert_allclose(row, np.broadcast_to(value, lanes), rtol=4e-15, atol=4e-15)


def test_angles_in_all_quadrants_and_on_the_axes():
    initialise()
    graph = Graph()
    a, b = graph.symbol("a"), graph.symbol("b")
    turn = np.linspace(-np.pi, np.pi, 16)
    round_ones = np.array([np.sin(turn), np.cos(turn), turn])
    axes = np.array([[0.0, 0.0, 1.0, -1.0, 0.0, 1e-9, 1.0, 1e-300], [0.0, 1.0, 0.0, 0.0, -1.0, 1.0, 1e-9, 1e-300]])
    on_axes = np.concatenate([np.tile(axes, 2), np.zeros((1, 16))])
    for points in (round_ones, on_axes):
        (found,) = compiled_values(16, [graph.function("atan2", a, b)], points, 0.0)
        np.testing.assert_allclose(found, np.arctan2(points[0], points[1]), rtol=2e-15, atol=1e-300)
    broken = np.full((3, 16), np.nan)
    assert np.isnan(compiled_values(16, [graph.function("atan2", a, b)], broken, 0.0)).all()


def test_factors_of_several_products_are_multiplied_once():
    graph = Graph()
    a, b, c = (graph.symbol(name) for name in STATE)
    outputs = [a * b * c, a * b / c, a * b * 2.0]
    text = lane_loop(outputs, Constants(), {name: name for name in STATE}, 16, "double")
    assert text.count("*") == 4 and text.count("/") == 1


def test_parameters_are_combined_on_the_host():
    graph = Graph()
    a, p, q = graph.symbol("a"), graph.symbol("p", uniform=True), graph.symbol("q", uniform=True)
    constants = Constants()
    text = lane_loop([a * p / q * 3.0, a + (p - q)], constants, {"a": "a"}, 16, "double")
    assert constants.values({"p": 8.0, "q": 2.0}) == [12.0, 6.0]
    assert "p.constants[0]" in text and "p.constants[1]" in text and "/" not in text
    assert Constants().values({}) == []
