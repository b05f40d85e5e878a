"""The lane vocabulary against NumPy, in both precisions, with one lane and with sixteen."""

import re

import numpy as np
import warp as wp

from tests.support.lanes import scalars
from tests.support.paths import ROOT
from weavesim.engine.layout import lanes_view
from weavesim.kernels.lanes import (
    cross,
    dot,
    fill,
    from_rows,
    in_every_lane,
    lane_maximum,
    lane_sum,
    larger,
    load,
    magnitude,
    negative,
    pick,
    scale,
    smaller,
    square_root,
    store,
    store_rows3,
    where_positive,
)
from weavesim.kernels.operators import add, div, mul, sub  # noqa: F401


def numbers(array: wp.array) -> np.ndarray:
    return array.numpy().ravel().astype(np.float64)


def tolerance(types) -> float:
    return 4.0 * np.finfo(np.float32 if types.real is wp.float32 else np.float64).eps


def test_selections_and_sums(types):
    lanes, real = types.lanes, types.real

    @wp.kernel(module="unique", enable_backward=False)
    def select(
        a: wp.array(dtype=lanes),
        b: wp.array(dtype=lanes),
        rows: wp.array2d(dtype=lanes),
        totals: wp.array2d(dtype=real),
    ):
        i = wp.tid()
        rows[0, i] = larger(a[i], b[i])
        rows[1, i] = smaller(a[i], b[i])
        rows[2, i] = where_positive(a[i], a[i], b[i])
        totals[0, i] = lane_sum(a[i])
        totals[1, i] = lane_maximum(a[i])

    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 32)).astype(np.float32).astype(np.float64)
    rows = lanes_view(wp.zeros((3, 32), dtype=real, device="cpu"), types.lane_count)
    totals = wp.zeros((2, 32 // types.lane_count), dtype=real, device="cpu")
    wp.launch(
        select, dim=32 // types.lane_count, inputs=[scalars(types, a), scalars(types, b)], outputs=[rows, totals],
        device="cpu",
    )  # fmt: skip
    found = rows.numpy().reshape(3, -1).astype(np.float64)
    assert np.array_equal(found[0], np.maximum(a, b))
    assert np.array_equal(found[1], np.minimum(a, b))
    assert np.array_equal(found[2], np.where(a > 0.0, a, b))
    groups = a.reshape(-1, types.lane_count)
    assert np.allclose(totals.numpy()[0], groups.sum(axis=1), rtol=0.0, atol=1e-5)
    assert np.array_equal(totals.numpy()[1].astype(np.float64), groups.max(axis=1))


def test_nan_takes_the_otherwise_branch(types):
    lanes, real = types.lanes, types.real

    @wp.kernel(module="unique", enable_backward=False)
    def select(a: wp.array(dtype=lanes), result: wp.array(dtype=lanes)):
        i = wp.tid()
        result[i] = where_positive(a[i], a[i], lanes(real(7.0)))

    values = np.ones(16)
    values[3] = np.nan
    result = scalars(types, np.zeros(16))
    wp.launch(select, dim=16 // types.lane_count, inputs=[scalars(types, values)], outputs=[result], device="cpu")
    expected = np.ones(16)
    expected[3] = 7.0
    assert np.array_equal(numbers(result), expected)


def test_vectors_load_pick_and_store(types):
    vec3, lanes3, indices = types.vec3, types.lanes3, types.indices

    @wp.kernel(module="unique", enable_backward=False)
    def combine(
        source: wp.array(dtype=vec3),
        rows: wp.array(dtype=types.real),
        index: wp.array(dtype=indices),
        lane_count: int,
        result: wp.array(dtype=vec3),
        products: wp.array(dtype=types.lanes),
    ):
        block = wp.tid()
        own = load(source, block * lane_count, lanes3())
        other = wp.matrix_from_rows(
            pick(rows, index[block], 2), pick(rows, index[block], 42), pick(rows, index[block], 82)
        )
        product = dot(own, other)
        products[block] = product
        store(result, block * lane_count, cross(own, other) + scale(product, own))

    rng = np.random.default_rng(1)
    values = rng.normal(size=(32, 3)).astype(np.float32).astype(np.float64)
    order = rng.permutation(32).astype(np.int32)
    result = wp.zeros(32, dtype=vec3, device="cpu")
    products = scalars(types, np.zeros(32))
    wp.launch(
        combine,
        dim=32 // types.lane_count,
        inputs=[
            wp.array(values, dtype=vec3, device="cpu"),
            wp.array(np.pad(values.T, ((0, 0), (2, 6))).ravel(), dtype=types.real, device="cpu"),
            wp.array(order.reshape(-1, types.lane_count), dtype=indices, device="cpu"),
            types.lane_count,
        ],
        outputs=[result, products],
        device="cpu",
    )
    other = values[order]
    product = np.einsum("ij,ij->i", values, other)
    assert np.allclose(numbers(products), product, rtol=0.0, atol=10.0 * tolerance(types))
    expected = np.cross(values, other) + product[:, None] * values
    assert np.allclose(result.numpy(), expected, rtol=0.0, atol=50.0 * tolerance(types))


def test_operators_go_lane_by_lane(types):
    lanes, real = types.lanes, types.real

    @wp.kernel(module="unique", enable_backward=False)
    def operate(a: wp.array2d(dtype=lanes), b: wp.array2d(dtype=lanes), third: real, result: wp.array3d(dtype=lanes)):
        x = a[0, 0]
        y = b[0, 0]
        result[0, 0, 0] = x + y
        result[1, 0, 0] = x - y
        result[2, 0, 0] = x * y
        result[3, 0, 0] = x / y
        result[4, 0, 0] = third * x
        result[5, 0, 0] = x / third
        u = wp.matrix_from_rows(a[0, 0], a[1, 0], a[2, 0])
        v = wp.matrix_from_rows(b[0, 0], b[1, 0], b[2, 0])
        sums = wp.matrix_from_rows(a[0, 0], a[1, 0], a[2, 0], a[3, 0])
        sums = sums + wp.matrix_from_rows(b[0, 0], b[1, 0], b[2, 0], b[3, 0])
        for c in range(3):
            result[0, 1 + c, 0] = (u + v)[c]
            result[1, 1 + c, 0] = (u - v)[c]
            result[2, 1 + c, 0] = mul(u, v)[c]
            result[3, 1 + c, 0] = div(u, v)[c]
            result[4, 1 + c, 0] = (third * u)[c]
            result[5, 1 + c, 0] = (u / third)[c]
        for c in range(4):
            result[6, c, 0] = sums[c]

    rng = np.random.default_rng(2)
    number = wp.dtype_to_numpy(real)
    a, b = rng.normal(size=(2, 4, types.lane_count)).astype(number)
    third = number(1.0 / 3.0)
    result = scalars(types, np.zeros((7, 4, types.lane_count)))
    wp.launch(operate, dim=1, inputs=[scalars(types, a), scalars(types, b), third], outputs=[result], device="cpu")
    found = result.numpy().reshape(7, 4, types.lane_count)
    both = np.array([a + b, a - b, a * b, a / b, third * a, a / third])
    # each is rounded once: the same bits, whatever the lanes are made of
    assert np.array_equal(found[:6, 0], both[:, 0])
    assert np.array_equal(found[:6, 1:], both[:, :3])
    assert np.array_equal(found[6], a + b)


def test_modules_import_all_operators_or_none():
    for file in (ROOT / "kernels").rglob("*.py"):
        imported = re.findall(r"^from \.+operators import (.*)$", file.read_text(), re.MULTILINE)
        assert imported in ([], ["add, div, mul, sub  # noqa: F401"]), file


def test_number_in_every_lane(types):
    lanes, third = types.lanes, types.real(1.0 / 3.0)

    @wp.kernel(module="unique", enable_backward=False)
    def fill_all(result: wp.array2d(dtype=lanes)):
        like = lanes()
        result[0, 0] = fill(like, 0.5)
        result[1, 0] = fill(like, third)
        result[2, 0] = fill(like, like.dtype(0.1))

    result = scalars(types, np.zeros((3, types.lane_count)))
    wp.launch(fill_all, dim=1, outputs=[result], device="cpu")
    expected = np.repeat(np.array([0.5, 1.0 / 3.0, 0.1]), types.lane_count)
    assert np.array_equal(numbers(result), expected.astype(wp.dtype_to_numpy(types.real)).astype(np.float64))


def test_functions_of_lanes_are_exact(types):
    lanes, real = types.lanes, types.real
    count = types.lane_count

    @wp.kernel(module="unique", enable_backward=False)
    def apply(
        a: wp.array2d(dtype=lanes), b: wp.array2d(dtype=lanes), v: types.vec3, turn: wp.types.matrix((3, 3), real),
        result: wp.array2d(dtype=lanes),
    ):  # fmt: skip
        x = a[0, 0]
        y = b[0, 0]
        u = from_rows(a[0, 0], a[1, 0], a[2, 0])
        w = from_rows(b[0, 0], b[1, 0], b[2, 0])
        result[0, 0] = square_root(magnitude(x))
        result[1, 0] = magnitude(x)
        result[2, 0] = negative(x)
        result[3, 0] = larger(x, y)
        result[4, 0] = smaller(x, y)
        store_rows3(result, 5, 0, negative(u))
        for c in range(3):
            result[8 + c, 0] = where_positive(x, u[c], w[c])
        store_rows3(result, 11, 0, scale(y, u))
        store_rows3(result, 14, 0, in_every_lane(u, v))
        result[17, 0] = lanes(lane_maximum(x))
        both = from_rows(x, y)
        four = from_rows(a[0, 0], a[1, 0], b[0, 0], b[1, 0])
        six = from_rows(a[0, 0], a[1, 0], a[2, 0], b[0, 0], b[1, 0], b[2, 0])
        for c in range(2):
            result[18 + c, 0] = both[c]
        for c in range(4):
            result[20 + c, 0] = four[c]
        for c in range(6):
            result[24 + c, 0] = six[c]
        store_rows3(result, 30, 0, turn * u)
        result[33, 0] = lanes(lane_sum(x))
        result[34, 0] = dot(u, w)
        store_rows3(result, 35, 0, cross(u, w))

    rng = np.random.default_rng(3)
    number = wp.dtype_to_numpy(real)
    a, b = rng.normal(size=(2, 3, count)).astype(number)
    a[0, 0] = -0.0
    v, turn = np.array([0.5, -2.0, 3.0], dtype=number), rng.normal(size=(3, 3)).astype(number)
    result = scalars(types, np.zeros((38, count)))
    inputs = [scalars(types, a), scalars(types, b), types.vec3(*v), wp.types.matrix((3, 3), real)(*turn.ravel())]
    wp.launch(apply, dim=1, inputs=inputs, outputs=[result], device="cpu")
    found = result.numpy().reshape(38, count)
    exact = [
        np.sqrt(np.abs(a[:1])), np.abs(a[:1]), -a[:1], np.maximum(a[:1], b[:1]), np.minimum(a[:1], b[:1]), -a,
        np.where(a[0] > 0.0, a, b), b[0] * a, np.repeat(v[:, None], count, axis=1),
        np.full((1, count), a[0].max()), a[:1], b[:1], a[:2], b[:2], a, b,
    ]  # fmt: skip
    assert np.array_equal(found[:30], np.concatenate(exact))
    assert np.array_equal(np.signbit(found[5:8]), ~np.signbit(a))
    inexact = [turn @ a, np.full((1, count), a[0].sum()), (a * b).sum(axis=0, keepdims=True), np.cross(a.T, b.T).T]
    assert np.allclose(found[30:], np.concatenate(inexact), rtol=0.0, atol=30.0 * tolerance(types))


def test_nan_is_not_larger_and_not_smaller(types):
    """So that the second of two lanes is kept, and a sum and a root stay without a number."""
    lanes = types.lanes

    @wp.kernel(module="unique", enable_backward=False)
    def select(a: wp.array(dtype=lanes), result: wp.array2d(dtype=lanes)):
        x = a[0]
        result[0, 0] = larger(x, fill(x, 7.0))
        result[1, 0] = smaller(x, fill(x, 7.0))
        result[2, 0] = magnitude(x)
        result[3, 0] = square_root(x)
        result[4, 0] = lanes(lane_sum(x))

    values = np.full(types.lane_count, np.nan)
    result = scalars(types, np.zeros((5, types.lane_count)))
    wp.launch(select, dim=1, inputs=[scalars(types, values)], outputs=[result], device="cpu")
    found = result.numpy().reshape(5, -1)
    assert np.all(found[:2] == 7.0)
    assert np.all(np.isnan(found[2:]))
