"""How far plies move between updates of the search."""

import numpy as np
import pytest
import warp as wp

from weavesim.kernels.pass_entries import PassEntry
from weavesim.kernels.plies.search import SPEED_MARGIN, plan_search_kernel, search_struct, watch_struct
from weavesim.kernels.rows import ClockEntry

REAL, STEP, STEPS, SKIN = wp.float64, 1e-6, 20, 1.0
SPEEDS = (10.0, 10.0, 2.0, 0.2, 0.0, 5.0)  # of both plies together [m/s]


def zeros(count: int, value: float = 0.0) -> wp.array:
    return wp.array(np.full(count, value), dtype=REAL, device="cpu")


@pytest.fixture
def planned():
    """Reach and age of boxes at each update [m]."""
    search, watch = search_struct(REAL)(), watch_struct(REAL)()
    search.skin, search.steps, search.slot = SKIN, STEPS, -1
    watch.entry, watch.drift = zeros(len(PassEntry)), zeros(1, 1e30)
    clock = np.zeros(len(ClockEntry))
    clock[ClockEntry.step] = STEP
    awake = [wp.zeros(1, dtype=wp.int32, device="cpu") for _ in range(2)]
    found = []
    for speed in SPEEDS:
        speeds = zeros(2, (0.25 * speed) ** 2), zeros(3, (0.75 * speed) ** 2)
        inputs = [search, wp.array(clock, device="cpu"), *speeds, watch, *awake]
        wp.launch(plan_search_kernel(REAL), dim=1, inputs=inputs, device="cpu")
        found.append((watch.entry.numpy()[PassEntry.reach], watch.drift.numpy()[0]))
    return np.array(found)


def test_boxes_are_as_old_as_the_intervals_that_are_over(planned):
    reach = SPEED_MARGIN * STEPS * STEP * np.array(SPEEDS)
    np.testing.assert_allclose(planned[:, 0], reach)
    np.testing.assert_allclose(planned[:, 1], np.append(0.0, np.cumsum(reach)[:-1]))
