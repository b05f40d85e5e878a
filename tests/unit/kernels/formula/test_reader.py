"""Warp functions as formulas: their values against what Warp computes, and what is refused, with its line."""

import math
from typing import Any

import numpy as np
import pytest
import warp as wp
from warp import float64 as real

from weavesim.device import initialise
from weavesim.kernels.formula.builtins import Vector
from weavesim.kernels.formula.graph import Graph, evaluated
from weavesim.kernels.formula.reader import read
from weavesim.kernels.formula.values import Parameters, Unreadable

HALF = wp.constant(real(0.5))
ENCLOSED_DEFAULT = 3


@wp.struct
class Given:
    stiffness: wp.float64
    lengths: wp.vec2d


@wp.func
def squared(a: real):
    return a * a


@wp.func
def either(p: Any, a: real, b: real):
    """Early return, two sides."""
    if a > b:
        return p.stiffness * a
    return b


@wp.func
def everything(p: Any, a: real, b: real, q: Any):
    """Most of what an energy can contain."""
    total = real(0.0)
    spring = wp.vec2d(real(0.0), real(1.0))
    for k in range(2):
        spring[k] = p.lengths[k] * q[k] + HALF
        total += squared(spring[k]) / (real(k) + real(1.0))
    if a < b and not (a > real(2.0)):
        total = total + a * b
        other = b
    else:
        total -= b
        other = -a
    if wp.static(ENCLOSED_DEFAULT > 2):
        total = total * real(ENCLOSED_DEFAULT)
    both = spring + wp.vec2d(a, b) * real(2.0)
    total = total + wp.dot(both, spring) + wp.length(both) + both.x + wp.length_sq(spring) - both[1]
    total = total + wp.max(a, b) * wp.min(a, other) + wp.abs(a - b) + wp.clamp(a, real(-0.2), real(0.2))
    total = total + wp.where(a == b, a, wp.sign(a)) + wp.step(b) + a ** real(2.0) + wp.pow(b * b, real(1.3))
    total = total + (a if a > real(0.0) else b) + real(math.pi) * wp.atan2(a, b) + wp.sqrt(a * a) + wp.cbrt(b)
    total = total + wp.exp(a) * wp.log(real(3.0) + b) + wp.sin(a) * wp.cos(b) + wp.tan(a) + wp.tanh(b)
    total = total + wp.asin(real(0.3) * a) + wp.acos(real(0.3) * b) + wp.atan(a) + wp.sinh(a) * wp.cosh(b)
    total = total + wp.floor(real(5.0) * a) + wp.ceil(b) + wp.log10(real(4.0) + a) + wp.degrees(a) + wp.nonzero(a)
    ratio = wp.cw_mul(spring, both) - wp.cw_div(spring, wp.vec2d(real(2.0), real(4.0)))
    return total + ratio[0] * ratio[1] + either(p, a, b) + real(7 // 2)


@wp.kernel(module="unique", enable_backward=False)
def compiled(p: Given, points: wp.array(dtype=wp.vec4d), found: wp.array(dtype=wp.float64)):
    i = wp.tid()
    x = points[i]
    found[i] = everything(p, x[0], x[1], wp.vec2d(x[2], x[3]))


def arguments(graph):
    lengths = Vector(graph.symbol(f"lengths[{k}]", uniform=True) for k in range(2))
    p = Parameters({"stiffness": graph.symbol("stiffness", uniform=True), "lengths": lengths})
    a, b, *q = (graph.symbol(name) for name in ("a", "b", "q0", "q1"))
    return [p, a, b, Vector(q)]


def test_a_function_has_the_values_that_warp_computes():
    initialise()
    points = np.random.default_rng(3).uniform(-0.9, 0.9, (200, 4))
    p = Given()
    p.stiffness, p.lengths = 3.0, wp.vec2d(0.7, 1.9)
    found = wp.zeros(len(points), dtype=wp.float64, device="cpu")
    wp.launch(
        compiled, dim=len(points), inputs=[p, wp.array(points, dtype=wp.vec4d, device="cpu"), found], device="cpu"
    )
    graph = Graph()
    formula = read(graph, everything, arguments(graph))
    symbols = {"stiffness": 3.0, "lengths[0]": 0.7, "lengths[1]": 1.9}
    (values,) = evaluated([formula], symbols | dict(zip(("a", "b", "q0", "q1"), points.T, strict=True)))
    np.testing.assert_allclose(values, found.numpy(), rtol=1e-12)


def test_a_vector_of_results_is_a_vector():
    @wp.func
    def pair(p: Any, a: real, b: real, q: Any):
        return wp.vec2d(a + q[1], b)

    graph = Graph()
    p, a, b, q = arguments(graph)
    assert read(graph, pair, [p, a, b, q]) == (a + q[1], b)


@wp.func
def endless(p: Any, a: real, b: real, q: Any):
    while a < b:
        a = a + real(1.0)
    return a


@wp.func
def integer_division(p: Any, a: real, b: real, q: Any):
    return a * real(-7 // 2)


@wp.func
def unknown_parameter(p: Any, a: real, b: real, q: Any):
    return p.stifness * a


@wp.func
def unknown_builtin(p: Any, a: real, b: real, q: Any):
    return wp.noise(wp.uint32(1), wp.float32(a))


@wp.func
def one_sided(p: Any, a: real, b: real, q: Any):
    if a > b:
        return a
    b = b + a


@wp.func
def recursive_length(p: Any, a: real, b: real, q: Any):
    total = a
    for _k in range(100000):
        total = total + b
    return total


@wp.func
def missing_component(p: Any, a: real, b: real, q: Any):
    return q[7]


@wp.func_native("return a;")
def native(a: real) -> real: ...


@wp.func
def calls_native(p: Any, a: real, b: real, q: Any):
    return native(a)


@wp.func
def state_dependent_loop(p: Any, a: real, b: real, q: Any):
    total = a
    for _k in range(int(a)):
        total = total + b
    return total


@wp.func
def leaves_a_loop(p: Any, a: real, b: real, q: Any):
    total = a
    for _k in range(3):
        if a > b:
            break
        total = total + b
    return total


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (endless, "statement 'while"),
        (integer_division, "FloorDiv of -7 and 2"),
        (unknown_parameter, "no parameter 'stifness'"),
        (unknown_builtin, "is not followed"),
        (one_sided, "only one side"),
        (recursive_length, "too long"),
        (missing_component, "IndexError"),
        (calls_native, "no single source"),
        (state_dependent_loop, "whole number"),
        (leaves_a_loop, "'break' is not followed"),
    ],
)
def test_what_cannot_be_followed_is_refused_with_its_line(function, said):
    graph = Graph()
    with pytest.raises(Unreadable, match="line [0-9]+: ") as refusal:
        read(graph, function, arguments(graph))
    assert said in str(refusal.value)
