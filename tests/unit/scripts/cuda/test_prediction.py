"""Times of a step on a device of round numbers, worked out by hand."""

import pytest

from scripts.benchmarks.cuda.prediction import (
    BANDWIDTH_SHARE,
    CYCLES,
    EVERY_STEP,
    H100,
    H200,
    MOVED,
    REFRESHED,
    SHORTEST,
    Device,
    Work,
    kernel_time,
    predicted,
    resident_warps,
    step_time,
)
from scripts.benchmarks.cuda.record import Entry, Record
from scripts.benchmarks.cuda.resources import Resources

# Ten multiprocessors at 1 GHz.
ROUND = Device("round", 10, 2 * 128 * 10 * 1e9, 0.5, 1e12)
ELEMENTS = Work(registers=128, instructions=10_000)


@pytest.mark.parametrize(
    ("registers", "warps"), [(16, 64), (32, 64), (40, 50), (64, 32), (65, 28), (128, 16), (168, 12), (255, 8)]
)
def test_warps_that_a_multiprocessor_holds_at_once(registers, warps):
    """NVIDIA's occupancy of blocks of 64 threads with 65,536 registers."""
    assert resident_warps(registers) == warps


def test_the_clock_follows_from_the_peak():
    assert ROUND.clock == pytest.approx(1e9)
    assert H100.clock == H200.clock == pytest.approx(1.98e9, rel=0.01)


def test_what_fits_at_once_takes_as_long_as_one_thread():
    alone = 10_000 * CYCLES * 1e-9
    assert kernel_time(ELEMENTS, 1, ROUND) == kernel_time(ELEMENTS, 10 * 16 * 32, ROUND) == pytest.approx(alone)
    assert kernel_time(ELEMENTS, 3 * 10 * 16 * 32, ROUND) == pytest.approx(3 * alone)
    assert kernel_time(Work(32, 10), 1, ROUND) == SHORTEST


@pytest.mark.parametrize(("double", "cycles"), [(False, 16.0), (True, 32.0)])
def test_four_schedulers_issue_an_instruction_a_cycle_and_half_of_that_in_double_precision(double, cycles):
    """64 warps in each multiprocessor are sixteen for each scheduler."""
    assert kernel_time(Work(32, 10_000, double), 10 * 64 * 32, ROUND) == pytest.approx(10_000 * cycles * 1e-9)


def test_a_step_is_its_kernels_and_a_twentieth_of_the_refresh_or_its_bytes():
    alone = 10_000 * CYCLES * 1e-9
    few = step_time([ELEMENTS, ELEMENTS], [ELEMENTS], 600.0, 100, ROUND)
    assert few == (pytest.approx(2.05 * alone), "latency")
    assert step_time([ELEMENTS], [], 1.0, 2 * 5120, ROUND) == (pytest.approx(2 * alone), "registers")
    many = step_time([Work(32, 100)], [], 600.0, 10**7, ROUND)
    assert many == (pytest.approx(600.0 * 1e7 / (BANDWIDTH_SHARE * 1e12)), "memory")


def test_a_case_is_predicted_from_its_own_kernels():
    needs = {90: Resources(128, 0, 2000)}
    entries = [Entry(name, "float64", ("free patch",), name, needs) for name in (*EVERY_STEP, *REFRESHED)]
    one = predicted(Record("1.0", entries), H100, "free patch", 1000, "float64")
    work = Work(128, 2000, double=True)
    assert (one.step, one.bound) == step_time([work] * 2, [work] * 3, MOVED["free patch"]["float64"], 1000, H100)
    with pytest.raises(ValueError, match="node_motion of the free patch"):
        predicted(Record("1.0", entries[:1]), H100, "free patch", 1000, "float64")
