"""The prediction of a step on many threads, against schedules that can be added up by hand."""

import numpy as np
import pytest

from scripts.benchmarks.schedule import Step, Times, step_on
from weavesim.engine.tiling.tiles import Part, Tile, divide_step

TIMES = Times(element=10.0, node=1.0, serial=5.0)


def test_a_step_ends_with_its_slowest_threads():
    parts = [
        Part(tiles=(Tile(((0, 2),), ((0, 1),)), Tile(((2, 2),), ((1, 3),))), shared=((8, 1),)),  # 44, then 1
        Part(tiles=(Tile(((4, 2), (6, 1)), ((4, 2),)),), shared=((9, 2), (12, 4))),  # 32, then 6
    ]
    step = step_on(parts, TIMES, wait=0.5)
    assert step == Step(work=50.0, serial=5.0, barriers=1.5, balance=pytest.approx((45.0 + 38.0) / 2 / 50.0))
    assert step.seconds == 56.5


def test_one_thread_does_all_and_waits_for_none():
    alone = [Part(tiles=(Tile(((0, 7),), ((0, 8),)),), shared=())]
    assert step_on(alone, TIMES) == Step(work=78.0, serial=5.0, barriers=0.0, balance=1.0)


@pytest.mark.parametrize("thread_count", [4, 16, 64])
def test_the_plan_of_a_sheet_keeps_all_threads_busy(thread_count):
    """71 x 71 elements, numbered row by row: no thread has much more to do than the mean."""
    side, lanes = 71, 16
    row, column = np.divmod(np.arange(side * side), side)
    corner = row * (side + 1) + column
    nodes = np.array([corner, corner + 1, corner + side + 2, corner + side + 1])
    padded = np.pad(nodes, ((0, 0), (0, -nodes.shape[1] % lanes)), mode="edge")
    parts = divide_step(padded, lanes, thread_count, 1024)
    step = step_on(parts, Times(element=3.0, node=1.0, serial=0.0), wait=0.0)
    assert step.balance > {4: 0.97, 16: 0.9, 64: 0.75}[thread_count]
