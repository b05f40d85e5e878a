"""The lane vocabulary against NumPy, in both precisions, with one lane and with sixteen."""

import re

import numpy as np
import pytest
import warp as wp

from tests.support.paths import ROOT
from weavesim.engine.layout import lanes_view
from weavesim.kernels.lanes import (
    angle_of,
    cross,
    dot,
    fill,
    lane_maximum,
    lane_sum,
    lane_types,
    larger,
    load,
    pick,
    scale,
    smaller,
    square_root,
    step_options,
    store,
    where_positive,
)
from weavesim.kernels.operators import add, div, mul, sub  # noqa: F401


@pytest.fixture(params=[1, 16], ids=["one lane", "sixteen lanes"])
def types(request, precision):
    return lane_types(precision.real, request.param)


def scalars(types, values) -> wp.array:
    return lanes_view(wp.array(np.asarray(values), dtype=types.real, device="cpu"), types.lane_count)


def numbers(array: wp.array) -> np.ndarray:
    return array.numpy().ravel().astype(np.float64)


def tolerance(types) -> float:
    return 4.0 * np.finfo(np.float32 if types.real is wp.float32 else np.float64).eps


def test_angle_is_that_of_arctan2(types):
    lanes = types.lanes

    @wp.kernel(module="unique", enable_backward=False)
    def angles(sine: wp.array(dtype=lanes), cosine: wp.array(dtype=lanes), result: wp.array(dtype=lanes)):
        i = wp.tid()
        s = sine[i]
        c = cosine[i]
        result[i] = angle_of(s, c, square_root(wp.cw_mul(s, s) + wp.cw_mul(c, c)))

    expected = np.concatenate([np.linspace(-1.0, 1.0, 465), np.geomspace(1e-12, 1e-2, 15)]) * np.deg2rad(170.0)
    size = np.geomspace(1e-3, 1e3, len(expected))
    result = scalars(types, np.zeros(len(expected)))
    wp.launch(
        angles,
        dim=len(expected) // types.lane_count,
        inputs=[scalars(types, size * np.sin(expected)), scalars(types, size * np.cos(expected))],
        outputs=[result],
        device="cpu",
    )
    # relative: small angles keep their digits; the polynomial itself is good to 1e-14
    error = np.abs(numbers(result) - expected)
    assert np.all(error <= np.maximum(tolerance(types), 2e-14) * np.abs(expected))


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


# Threads of a block on a GPU.
ON_EVERY_PROCESSOR = {"block_dim": 64}


@pytest.mark.parametrize("machine", ["x86_64", "AMD64"])
def test_single_precision_does_without_gathers_on_x86(monkeypatch, machine):
    monkeypatch.setattr("platform.machine", lambda: machine)
    monkeypatch.setattr(wp.config, "cpu_compiler_flags", "-march=native")
    without_gathers = {"cpu_compiler_flags": "-march=native -target-feature +prefer-no-gather"}
    assert step_options(wp.float32) == ON_EVERY_PROCESSOR | without_gathers
    assert step_options(wp.float64) == ON_EVERY_PROCESSOR


@pytest.mark.parametrize(
    ("machine", "flags"), [("aarch64", "-march=native"), ("arm64", "-march=native"), ("x86_64", None)]
)
def test_other_processors_and_unset_flags_keep_the_options(monkeypatch, machine, flags):
    monkeypatch.setattr("platform.machine", lambda: machine)
    monkeypatch.setattr(wp.config, "cpu_compiler_flags", flags)
    assert step_options(wp.float32) == ON_EVERY_PROCESSOR
