"""Sums and maxima of many entries, in tiles."""

import numpy as np
import pytest
import warp as wp

from weavesim.engine.launches import TILE_THREAD_COUNT
from weavesim.kernels.stepping.step import MAXIMUM_GROUP, group_maximum_kernel, partial_maximum_kernel
from weavesim.kernels.stepping.tools import SUM_GROUP, partial_sum_kernel

COUNTS = [1, 255, 1024, 1025, 5000]


def group_count(entry_count, group):
    return -(-entry_count // group)


def partial_maxima(values, precision, device):
    given = wp.array(values.astype(precision.numpy), device=device)
    maxima = wp.empty(group_count(len(values), MAXIMUM_GROUP), dtype=precision.real, device=device)
    kernel = partial_maximum_kernel(precision.real)
    wp.launch_tiled(
        kernel, dim=[len(maxima)], block_dim=TILE_THREAD_COUNT, inputs=[given], outputs=[maxima], device=device
    )
    by_loop = wp.empty_like(maxima)
    kernel = group_maximum_kernel(precision.real, MAXIMUM_GROUP)
    wp.launch(kernel, dim=len(maxima), inputs=[given], outputs=[by_loop], device=device)
    np.testing.assert_array_equal(by_loop.numpy(), maxima.numpy())
    return maxima.numpy()


@pytest.mark.parametrize("entry_count", COUNTS)
def test_forces_are_summed_in_double_precision(entry_count, precision, device):
    # the sum of the large ones is zero: in single precision the rest would be lost
    force = np.random.default_rng(entry_count).normal(size=(3, entry_count, 3)).astype(precision.numpy)
    force[:, : entry_count // 2] += 1e6
    force[:, entry_count - entry_count // 2 :] -= 1e6
    given = wp.array(force, dtype=wp.types.vector(3, precision.real), device=device)
    sums = wp.empty((3, group_count(entry_count, SUM_GROUP)), dtype=wp.vec3d, device=device)
    kernel = partial_sum_kernel(precision.real)
    found = []
    for _ in range(2):
        wp.launch_tiled(
            kernel, dim=sums.shape, block_dim=TILE_THREAD_COUNT, inputs=[given], outputs=[sums], device=device
        )
        found.append(sums.numpy())
    assert found[0].tobytes() == found[1].tobytes()
    expected = force.astype(np.float64).sum(axis=1)
    rounding = 1e-14 * np.abs(force).astype(np.float64).sum()
    np.testing.assert_allclose(found[0].sum(axis=1), expected, rtol=0.0, atol=rounding)


@pytest.mark.parametrize("entry_count", COUNTS)
def test_the_largest_entry_is_found_wherever_it_is(entry_count, precision, device):
    values = np.random.default_rng(entry_count).random(entry_count)
    for place in {0, entry_count // 2, entry_count - 1}:
        given = values.copy()
        given[place] = 2.0
        maxima = partial_maxima(given, precision, device)
        assert maxima.max() == 2.0 and np.argmax(maxima) == place // MAXIMUM_GROUP
    np.testing.assert_array_equal(
        partial_maxima(values, precision, device),
        [values[first : first + MAXIMUM_GROUP].astype(precision.numpy).max()
         for first in range(0, entry_count, MAXIMUM_GROUP)],
    )  # fmt: skip


@pytest.mark.parametrize("lost", [np.nan, -np.nan, np.inf])
@pytest.mark.parametrize("place", [0, 700, 1500])
def test_a_lost_entry_becomes_infinity(lost, place, precision, device):
    values = np.ones(1501)
    values[place] = lost
    assert partial_maxima(values, precision, device)[place // MAXIMUM_GROUP] == np.inf
