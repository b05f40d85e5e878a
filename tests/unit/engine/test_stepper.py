"""How a step is shared out to threads and tiles, and what it launches."""

import os
import platform
from contextlib import contextmanager
from functools import partial

import numpy as np
import pytest
import warp as wp

from tests.support.runs import one_sheet_run
from weavesim.device import load_kernel
from weavesim.engine import sheet_model
from weavesim.engine import stepper as stepper_module
from weavesim.engine.replay import Replay
from weavesim.engine.stepper import REFRESH_INTERVAL
from weavesim.engine.threads import ThreadChoice, beside_steps
from weavesim.engine.tiling import division
from weavesim.fabric.presets import glass_polypropylene
from weavesim.kernels.machine import count_rounds, flush_subnormals, restore_subnormals, wait_for_all
from weavesim.kernels.rows import MOTION_VECTORS, ClockEntry, MotionRow, ToolWatchRow
from weavesim.kernels.stepping.step import check_clock
from weavesim.process.strokes import Stroke
from weavesim.process.supports import Drive, Support
from weavesim.run.diagnosis import find_failure
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Sphere
from weavesim.tools.tool import Tool

LANES = 16


def free_sheet(monkeypatch, **given) -> Simulation:
    """On a CPU, but launched as on a GPU: one lane, and tiles of the whole sheet."""
    monkeypatch.setattr(division, "TILE_SIZE", 10**9)
    blank = Blank.rectangle((0.0, 0.0), (0.05, 0.05), 0.005)
    settings = {"lane_count": 1, "threads": 1, "duration": 1.0}
    return one_sheet_run(name="free", blank=blank, fabric=glass_polypropylene(), **(settings | given))


@pytest.mark.parametrize("whole_launches", [False, True])
@pytest.mark.parametrize("driven", [False, True])
def test_a_step_is_three_launches(monkeypatch, driven, whole_launches):
    """Elements, nodes, tools and clock; one more where supports are driven, five every ``REFRESH_INTERVAL`` steps.

    In a recorded loop each step counts itself, and the block its rounds.
    """
    drive = Drive(Stroke((0.0, 1.0), (0.0, 0.01)), (1.0, 0.0, 0.0))
    supports = (Support("edge", np.arange(11), drives=(drive,)),) if driven else ()
    simulation = free_sheet(monkeypatch, supports=supports)
    simulation.prepare()
    launched, counts = [], []
    for name in ("launch", "launch_tiled"):
        monkeypatch.setattr(
            wp, name, lambda kernel, **given: (counts if kernel is count_rounds else launched).append(kernel.key)
        )
    monkeypatch.setattr(wp, "capture_while", lambda count, body: [body() for _ in range(REFRESH_INTERVAL)])
    stepper = simulation.stepper
    if whole_launches:
        stepper._block_of_whole_launches()
    else:
        stepper._block(stepper._launches.divided(1), 0)
    assert len(launched) == (4 if driven else 3) * REFRESH_INTERVAL + 5
    assert len(set(launched)) == (9 if driven else 8) and len(counts) == (0 if whole_launches else 1 + REFRESH_INTERVAL)


@pytest.mark.parametrize("whole_launches", [False, True])
def test_stepping_does_not_wait_for_the_device(monkeypatch, whole_launches):
    simulation = free_sheet(monkeypatch)
    simulation.stepper.whole_launches = whole_launches
    simulation.stepper.advance(1)  # records
    replayed = []
    for name in ("launch", "copy", "synchronize", "synchronize_device", "synchronize_stream"):
        monkeypatch.setattr(wp, name, lambda *given, name=name, **more: pytest.fail(f"wp.{name} between two frames"))
    monkeypatch.setattr(wp.array, "numpy", lambda self: pytest.fail("an array was read between two frames"))
    rounds = simulation.stepper._replay._rounds
    monkeypatch.setattr(wp, "capture_launch", lambda graph: replayed.append(int(rounds[0])))
    simulation.stepper.advance(7)
    assert sum(replayed) == 7 and simulation.stepper.step_count == 8 * REFRESH_INTERVAL


def thrown_sheet(monkeypatch, **given) -> Simulation:
    """A free sheet in motion, whose step starts a tenth of the stable one and grows."""
    x, y = np.meshgrid(np.arange(11), np.arange(11))
    velocity = np.column_stack([np.zeros(121), np.zeros(121), np.sin(x * y).ravel()])
    simulation = free_sheet(monkeypatch, initial_velocity=velocity, **given)
    clock = simulation.state.clock.numpy()
    clock[ClockEntry.step] *= 0.1
    simulation.state.clock.assign(clock)
    return simulation


def arrived(simulation: Simulation) -> tuple[int, bytes, bytes]:
    """Steps, clock and motion, to the last bit."""
    state = simulation.state
    return state.step_count, state.clock.numpy().tobytes(), state.sheet.motion.numpy().tobytes()


INTERVAL_BLOCK_COUNT = 60


@pytest.fixture
def block_by_block(monkeypatch, device):
    """A target between two ends of blocks, the device, and the sheet at the first of them that reaches it."""
    simulation = thrown_sheet(monkeypatch, device=device)
    for _ in range(INTERVAL_BLOCK_COUNT):
        before = simulation.state.time
        simulation.stepper.advance(1)
    assert simulation.state.step > 2.5 * thrown_sheet(monkeypatch, device=device).state.step
    return 0.5 * (before + simulation.state.time), device, arrived(simulation)


@pytest.mark.parametrize("tool_count", [0, 2])
def test_whole_launches_give_the_same_bits(monkeypatch, tool_count):
    """What a GPU runs side by side is here in one of the orders that it may take."""
    tools = [Tool(f"ball {k}", Sphere(0.02, origin=(0.01 + 0.03 * k, 0.025, 0.0205))) for k in range(tool_count)]
    found = []
    for whole_launches in (False, True):
        simulation = thrown_sheet(monkeypatch, tools=tools)
        simulation.stepper.whole_launches = whole_launches
        simulation.stepper.advance(7)
        found.append((*arrived(simulation), simulation.state.tool_watch.numpy().tobytes()))
    assert found[0] == found[1]
    assert not tool_count or simulation.state.tool_watch.numpy()[ToolWatchRow.peak].min() > 0.0


def test_an_interval_ends_at_the_first_block_that_reaches_it(monkeypatch, block_by_block):
    target, device, expected = block_by_block
    simulation = thrown_sheet(monkeypatch, device=device)
    simulation.stepper.launches_intervals = False
    simulation.stepper.advance_to(target)
    assert arrived(simulation) == expected
    simulation.stepper.advance_to(target)
    assert arrived(simulation) == expected


@pytest.mark.parametrize("largest", [stepper_module.LARGEST_INTERVAL, 7])
def test_an_interval_of_one_launch_ends_there_too(monkeypatch, block_by_block, largest):
    """On a CPU the loop is recorded as on a GPU, and replayed natively."""
    target, device, expected = block_by_block
    monkeypatch.setattr(stepper_module, "LARGEST_INTERVAL", largest)
    simulation = thrown_sheet(monkeypatch, device=device)
    load_kernel(check_clock, simulation.model.device)
    launched, launch = [], wp.capture_launch
    monkeypatch.setattr(wp, "capture_launch", lambda graph: [launched.append(graph), launch(graph)])
    simulation.stepper.launches_intervals = True
    simulation.stepper.advance_to(target)
    assert arrived(simulation) == expected
    assert len(launched) == -(-INTERVAL_BLOCK_COUNT // largest)
    simulation.stepper.set_damping(0.0)
    simulation.stepper.advance_to(2.0 * target)
    assert simulation.state.time - 2.0 * target < REFRESH_INTERVAL * simulation.state.step


@pytest.mark.gpu
def test_a_gpu_launches_whole_intervals(monkeypatch):
    there, here = (thrown_sheet(monkeypatch, device=device) for device in ("cuda:0", "cpu"))
    assert there.stepper.launches_intervals == wp.is_conditional_graph_supported()
    for target in (1.0e-4, 3.0e-4):
        for simulation in (there, here):
            simulation.stepper.advance_to(target)
        assert there.stepper.step_count == here.stepper.step_count
        assert there.state.time == pytest.approx(here.state.time, rel=1e-6)
        motion = [
            simulation.model.sheet.read_motion(simulation.state.sheet.motion)[MotionRow.position.vector]
            for simulation in (there, here)
        ]
        assert np.abs(motion[0] - motion[1]).max() < 1e-6


@pytest.mark.parametrize("lane_count", [1, LANES])
@pytest.mark.parametrize("row", MOTION_VECTORS)
@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize("launches_intervals", [False, True])
def test_a_lost_state_ends_the_interval(monkeypatch, lane_count, row, value, launches_intervals):
    """Looking at the step is enough, for it is lost too."""
    simulation = thrown_sheet(monkeypatch, lane_count=lane_count)
    load_kernel(check_clock, simulation.model.device)
    simulation.stepper.launches_intervals = launches_intervals
    motion = simulation.model.sheet.read_motion(simulation.state.sheet.motion)
    motion[list(MOTION_VECTORS).index(row), 60, 1] = value
    simulation.model.sheet.write_motion(simulation.state.sheet.motion, motion)
    simulation.stepper.advance_to(1.0)
    # that of the first block, or of the first turn of several
    assert simulation.stepper.step_count <= (1 if launches_intervals else 50) * REFRESH_INTERVAL
    assert find_failure(simulation.model, simulation.state, simulation.frame)


def test_an_interval_ends_when_asked_to(monkeypatch):
    simulation = thrown_sheet(monkeypatch)
    answers = iter([False, False, True])
    simulation.stepper.advance_to(1.0, lambda: next(answers))
    assert simulation.state.time < 1.0 and next(answers, None) is None


class EveryCount:
    """Takes one number of threads after the other."""

    def __init__(self, counts: tuple[int, ...]) -> None:
        self.counts, self.count, self.used = counts, counts[0], []

    def present(self) -> "EveryCount":
        return self

    def block_count(self) -> int:
        return 2

    def report(self, block_count: int, seconds: float) -> None:
        self.used.append(self.count)
        self.count = self.counts[len(self.used) % len(self.counts)]


def test_threads_may_change_during_a_run(monkeypatch):
    fixed = thrown_sheet(monkeypatch, lane_count=LANES)
    fixed.stepper.advance(12)
    changing = thrown_sheet(monkeypatch, lane_count=LANES, threads=3)
    changing.stepper._choice = EveryCount((1, 2, 3))
    changing.stepper.advance(12)
    assert changing.stepper._choice.used == [1, 2, 3, 1, 2, 3]
    assert arrived(changing) == arrived(fixed)


def test_while_others_of_the_process_compute_they_are_left_a_core_and_no_bit_changes(monkeypatch):
    monkeypatch.setattr("weavesim.engine.threads.available_threads", lambda: 2)
    fixed = thrown_sheet(monkeypatch, lane_count=LANES)
    fixed.stepper.advance(12)
    free = thrown_sheet(monkeypatch, lane_count=LANES, threads=2)
    free.stepper._choice = ThreadChoice((1, 2))
    with beside_steps():
        free.stepper.advance(6)
        assert set(free.stepper._block_graphs) == {1} and free.stepper.thread_count == 1
    free.stepper.advance(6)
    assert arrived(free) == arrived(fixed)


@contextmanager
def one_core():
    """This thread, and those that it starts, share one core."""
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(before)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


pins_threads = pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="threads cannot be given one core here")


@wp.kernel(module="unique", enable_backward=False)
def _wait_and_count(counter: wp.array(dtype=wp.int32), thread_count: wp.int32, spins: wp.array(dtype=wp.int32)):
    spins[0] = spins[0] + wait_for_all(counter, thread_count)


@pins_threads
def test_threads_that_share_a_core_give_it_away_at_barriers():
    """Counted is how often they look in vain: a time slice that is spun away is tens of thousands of looks."""
    thread_count, turns, device = 4, 50, wp.get_device("cpu")
    counter, spins = (wp.zeros(count, dtype=wp.int32, device=device) for count in (1, thread_count))
    load_kernel(_wait_and_count, device)
    replay = Replay(device, thread_count)

    def wait(own):
        wp.launch(_wait_and_count, 1, [counter, thread_count, own], device=device)

    graphs = [replay.record_rounds(partial(wait, spins[k : k + 1]), k) for k in range(thread_count)]
    with one_core():
        replay.run(graphs, turns)
    assert counter.numpy()[0] == thread_count * turns
    # 400 before a core is given away at all, and 64 before it is again
    assert spins.numpy().sum() / (thread_count * turns) < 4000


@pins_threads
def test_more_threads_than_cores_change_no_bit(monkeypatch):
    alone, crowded = (thrown_sheet(monkeypatch, lane_count=LANES, threads=threads) for threads in (1, 3))
    alone.stepper.advance(3)
    with one_core():
        crowded.stepper.advance(3)
    assert arrived(crowded) == arrived(alone)


@pytest.mark.parametrize("threads", [1, 2])
def test_constants_side_by_side_and_fetched_ahead_change_no_bit(monkeypatch, precision, threads):
    whole = thrown_sheet(monkeypatch, lane_count=LANES, precision=precision, threads=threads)
    monkeypatch.setattr(sheet_model, "LARGE_SHEET", 0)
    together = thrown_sheet(monkeypatch, lane_count=LANES, precision=precision, threads=threads)
    lines = [run.stepper.model.sheets[0].elements.corner_node.strides for run in (whole, together)]
    assert lines[1][-1] > lines[0][-1]
    models = [run.stepper.model.sheets[0] for run in (whole, together)]
    assert [(model.elements.looks_ahead, model.nodes.looks_ahead) for model in models] == [(0, 0), (1, 1)]
    assert [model.elements_single.looks_ahead for model in models] == [0, 0]
    for run in (whole, together):
        run.stepper.advance(12)
    assert arrived(together) == arrived(whole)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_step_is_recorded_once_and_goes_round_by_itself(monkeypatch, threads):
    """The same as launch by launch, step by step, block by block."""
    by_hand = thrown_sheet(monkeypatch)
    flushed = wp.zeros(1, dtype=wp.int32, device="cpu")
    wp.launch(flush_subnormals, dim=1, outputs=[flushed], device="cpu")
    divided = by_hand.stepper._launches.divided(1)
    for _ in range(3):
        for _ in range(REFRESH_INTERVAL):
            by_hand.stepper._step(divided, 0)
        by_hand.stepper._refresh(1, 0)
    wp.launch(restore_subnormals, dim=1, inputs=[flushed], device="cpu")
    replayed = thrown_sheet(monkeypatch, threads=threads)
    launched, launch = [], wp.capture_launch
    monkeypatch.setattr(wp, "capture_launch", lambda graph: [launched.append(graph), launch(graph)])
    steps, step = [], replayed.stepper._step
    monkeypatch.setattr(replayed.stepper, "_step", lambda *given: [steps.append(given), step(*given)])
    replayed.stepper._choice = ThreadChoice((threads,))
    replayed.stepper.advance(3)
    assert len(steps) == len(replayed.stepper._block_graphs[threads]) == threads
    # steps by hand are not counted
    assert replayed.stepper.step_count == 3 * REFRESH_INTERVAL and arrived(replayed)[1:] == arrived(by_hand)[1:]


def test_no_number_of_threads_given_means_all_that_may_be_fastest(monkeypatch):
    monkeypatch.setattr("weavesim.device.available_threads", lambda: 6)
    assert free_sheet(monkeypatch, threads=None).info.thread_counts == (1, 2, 4, 6)
    assert free_sheet(monkeypatch, threads=3).info.thread_counts == (3,)
    simulation = free_sheet(monkeypatch, threads=None, duration=1e-3, frame_count=2)
    simulation.run()
    assert simulation.summary()["threads"] in (1, 2, 4, 6)


def test_phases_can_be_timed_and_change_nothing(monkeypatch):
    simulation = thrown_sheet(monkeypatch)
    simulation.stepper.advance(2)
    state = simulation.state

    def everything() -> dict[str, bytes]:
        # the forces at the corners are of the last step, and nothing later reads them
        return {name: array.numpy().tobytes() for name, array in state.arrays() if not name.endswith("corner_force")}

    before = everything()
    phases = simulation.stepper.phases(3)
    assert list(phases) == ["copy", "elements", "nodes and contact", "tools", "stable step (every 20th)"]
    corner_force = simulation.stepper.look_ahead().sheet.corner_force
    corner_force.zero_()
    phases["copy"]()
    assert np.abs(corner_force.numpy()).max() == 0.0
    for phase in phases.values():
        phase()
    assert np.abs(corner_force.numpy()).max() > 0.0
    assert everything() == before


def test_arrays_are_all_of_the_state_once(monkeypatch):
    simulation = free_sheet(monkeypatch)
    arrays = simulation.stepper.arrays()
    pointers = [array.ptr for array in arrays]
    assert len(set(pointers)) == len(pointers)
    state = simulation.state
    for array in (state.sheet.motion, state.sheet.corner_force, state.clock, simulation.model.sheet.elements.area):
        assert array.ptr in pointers


def test_subnormal_numbers_become_zero_until_that_is_restored():
    """On x86, where they cost a hundred times as much."""
    before = wp.zeros(1, dtype=wp.int32, device="cpu")
    product = wp.zeros(3, dtype=wp.float32, device="cpu")

    @wp.kernel(module="unique", enable_backward=False)
    def multiply(small: wp.float32, place: int, result: wp.array(dtype=wp.float32)):
        result[place] = small * small

    def launch(place: int) -> None:
        wp.launch(multiply, dim=1, inputs=[wp.float32(1.0e-20), place], outputs=[product], device="cpu")

    launch(0)
    wp.launch(flush_subnormals, dim=1, outputs=[before], device="cpu")
    launch(1)
    wp.launch(restore_subnormals, dim=1, inputs=[before], device="cpu")
    launch(2)
    expected = np.float32(1.0e-20) ** 2
    assert expected > 0.0
    flushed = 0.0 if platform.machine().lower() in ("x86_64", "amd64") else expected
    assert product.numpy().tolist() == [expected, flushed, expected]
