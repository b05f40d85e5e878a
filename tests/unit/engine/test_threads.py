"""The number of threads that a run takes, on machines whose speed is known."""

import sys
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from weavesim.engine import threads as module
from weavesim.engine.threads import PROBE, PROBE_INTERVAL, TURN, ThreadChoice, beside_steps, soon


class Machine:
    """Works at a known speed: ``cost(count, time)`` are seconds per block."""

    def __init__(self, counts: tuple[int, ...], cost: Callable[[int, float], float]) -> None:
        self.choice, self.cost = ThreadChoice(counts), cost
        self.time, self.blocks = 0.0, 0
        self.used: list[tuple[float, int, int]] = []  # time, threads, blocks

    def run(self, seconds: float, largest_block_count: int = 10**9) -> "Machine":
        end = self.time + seconds
        while self.time < end:
            count = self.choice.count
            blocks = min(self.choice.block_count(), largest_block_count)
            took = blocks * self.cost(count, self.time)
            self.used.append((self.time, count, blocks))
            self.time += took
            self.blocks += blocks
            self.choice.report(blocks, took)
        return self

    def share(self, count: int, since: float = 0.0) -> float:
        """Of the blocks since a time, those on ``count`` threads."""
        later = [(used, blocks) for time, used, blocks in self.used if time >= since]
        return sum(blocks for used, blocks in later if used == count) / sum(blocks for _, blocks in later)


# Costs that fall up to one number and rise beyond it, from sheets of a hundred to a million elements.
FACTORS = st.lists(st.floats(1.05, 3.0), min_size=1, max_size=5)


@pytest.mark.slow
@given(FACTORS, st.data(), st.floats(1e-5, 2.0))
def test_the_fastest_is_found_and_probing_costs_little(factors, data, scale):
    best = data.draw(st.integers(0, len(factors)))
    costs = [scale]
    for index, factor in enumerate(factors):
        costs.append(costs[-1] / factor if index < best else costs[-1] * factor)
    counts = tuple(2**index for index in range(len(costs)))
    by_count = dict(zip(counts, costs, strict=True))
    machine = Machine(counts, lambda count, time: by_count[count]).run(3.0 * (len(counts) + 2) * max(TURN, scale))
    # by now every number worth probing has been probed
    started, blocks = machine.time, machine.blocks
    machine.run(200.0 * max(1.0, scale))
    ideal = (machine.blocks - blocks) * costs[best]
    assert machine.share(counts[best], started) > 0.5
    # each of two neighbours may cost one per cent, and a probe begins before its cost is made up
    assert machine.time - started < 1.021 * ideal + 2.0 * 3.0 * max(PROBE, costs[best])
    assert machine.choice.most_used == counts[best]
    assert {used for _, used, _ in machine.used} <= set(counts)


@pytest.mark.slow
@given(st.floats(1e-4, 0.02), st.floats(1.5, 8.0))
def test_load_of_others_is_left_alone_and_forgotten_when_it_ends(cost, slowdown):
    def loaded(count: int, time: float) -> float:
        return cost * {1: 1.0, 2: slowdown if 20.0 <= time < 60.0 else 0.55}[count]

    machine = Machine((1, 2), loaded).run(20.0)
    assert machine.share(2) > 0.97
    machine.run(40.0)
    assert machine.share(1, 21.0 + 4.0 * cost * slowdown) > 0.95
    machine.run(60.0)
    # the next probe comes when the cost of the last one is made up
    wait = PROBE_INTERVAL + 150.0 * (PROBE + cost) * slowdown
    machine.run(wait + 20.0)
    assert machine.share(2, 60.0 + wait) > 0.97


def test_one_slow_turn_changes_nothing():
    machine = Machine((1, 2), lambda count, time: 0.001 * (2.0 / count) * (2.5 if 5.0 <= time < 5.04 else 1.0))
    machine.run(30.0)
    assert machine.share(2, 0.5) > 0.97


def test_a_lucky_probe_is_forgotten():
    """Two threads are slow here, except for probes that happen to find both cores free."""

    def bursts(count: int, time: float) -> float:
        lucky = count == 2 and time % 2.0 < 0.2
        return 1e-3 * (1.0 if count == 1 else 0.5 if lucky else 6.0)

    machine = Machine((1, 2), bursts).run(200.0)
    assert sum(blocks * bursts(count, time) for time, count, blocks in machine.used if count == 2) < 0.1 * 200.0


def test_short_replays_count_together():
    """As when a run is advanced block by block, or frames are close together."""
    machine = Machine((1, 2), lambda count, time: 1e-4 * (2.0 / count)).run(10.0, largest_block_count=1)
    assert machine.share(2) > 0.97


def test_a_sheet_too_small_for_threads_stays_on_one():
    machine = Machine((1, 2, 4, 8, 16), lambda count, time: 1e-4 * (1.0 + 0.5 * count)).run(10.0)
    assert machine.share(1) > 0.96 and {count for _, count, _ in machine.used} == {1, 2}


def test_more_threads_are_tried_while_they_are_faster():
    machine = Machine((1, 2, 4, 6), lambda count, time: 1e-2 / count).run(10.0)
    assert list(dict.fromkeys(count for _, count, _ in machine.used)) == [1, 2, 4, 6]
    assert machine.share(6, 0.2) > 0.96
    assert machine.share(6) > 0.97


def test_a_given_number_stays():
    machine = Machine((3,), lambda count, time: 1e-3 * (1.0 + time)).run(5.0)
    assert machine.share(3) == 1.0 and machine.choice.most_used == 3
    # a run listens to Ctrl-C between two turns
    assert max(blocks * 1e-3 * (1.0 + time) for time, _, blocks in machine.used) < 3.0 * TURN


def test_before_the_first_turn_nothing_is_known():
    choice = ThreadChoice((1, 2))
    assert choice.block_count() == 1 and choice.count == choice.most_used == 1
    # then the blocks so far tell how many are left of it
    choice.report(1, module.PROBE / 10.0)
    assert choice.block_count() == 9
    choice.report(9, 0.9 * module.PROBE)
    assert choice.count == 2


@pytest.mark.parametrize(
    ("cores", "counts", "used"),
    [(2, (1, 2), {1}), (4, (1, 2, 4), {1, 2}), (3, (1, 2, 3), {1, 2}), (1, (1,), {1}), (2, (2,), {2}), (1, (2,), {2})],
)
def test_a_core_is_left_to_who_computes_beside_the_steps(monkeypatch, cores, counts, used):
    monkeypatch.setattr(module, "available_threads", lambda: cores)
    whole, tried = ThreadChoice(counts), []
    with beside_steps():
        for _ in range(40):
            choice = whole.present()
            tried.append(choice.count)
            choice.report(1, 1.0 / choice.count)
    assert set(tried) == used
    assert whole.most_used in used
    # nothing that was measured meanwhile counts afterwards
    assert whole.present() is whole and (len(counts) == 1 or (whole.count == 1 and whole.block_count() == 1))


def test_two_who_compute_take_two_cores_and_one_thread_is_left(monkeypatch):
    monkeypatch.setattr(module, "available_threads", lambda: 4)
    choice = ThreadChoice((1, 2, 4))
    with beside_steps():
        assert choice.present().counts == (1, 2)
        with beside_steps(), beside_steps(), beside_steps():
            assert choice.present().counts == (1,)
        assert choice.present().counts == (1, 2)
    assert choice.present() is choice


def test_python_takes_turns_as_before_in_whatever_order_contexts_end():
    before = sys.getswitchinterval()
    first, second = soon(5e-4), soon(2e-4)
    first.__enter__()
    assert sys.getswitchinterval() == pytest.approx(5e-4)
    second.__enter__()
    first.__exit__(None, None, None)
    assert sys.getswitchinterval() == pytest.approx(2e-4)
    second.__exit__(None, None, None)
    assert sys.getswitchinterval() == before
    with soon(10.0):  # it never gets later
        assert sys.getswitchinterval() == before
