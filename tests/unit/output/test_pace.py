"""Results are saved early, then often enough, and never for more than a small share of the time."""

import pytest

from weavesim.output import pace as module
from weavesim.output.pace import Pace


@pytest.fixture
def clock(monkeypatch):
    class Clock:
        now = 1000.0

    monkeypatch.setattr(module.time, "monotonic", lambda: Clock.now)
    return Clock


def saved(clock, frame_count, interval, cost=0.0):
    pace, result = Pace(), []
    for index in range(frame_count):
        if pace.due():
            result.append(index)
            clock.now += cost
            pace.done()
        clock.now += interval
    return result


def test_a_run_of_seconds_is_saved_a_few_times(clock):
    assert saved(clock, 20, 1e-3) == [0]
    assert saved(clock, 81, 0.0625) == [0, 8, 16, 32, 64]


def test_the_beginning_too_takes_a_small_share(clock):
    """A film of many elements, in a run whose frames come fast."""
    start, cost = clock.now, 0.05
    count = len(saved(clock, 81, 0.05, cost=cost))
    assert count == 2 and count * cost < 0.03 * (clock.now - start)


def test_slow_frames_are_saved_every_five_seconds(clock):
    assert saved(clock, 8, 6.0) == list(range(8))
    assert saved(clock, 65, 1.0) == [0, 1, 2, 4, 8, 13, 18, 23, 28, 33, 38, 43, 48, 53, 58, 63]


def test_slow_saves_become_rare(clock):
    start = clock.now
    count = len(saved(clock, 4000, 0.5, cost=1.0))
    assert count < 0.025 * (clock.now - start) + 12


def test_what_takes_longer_to_save_begins_later(clock):
    pace, result = Pace(2.0), []
    for second in range(20):
        if pace.due():
            result.append(second)
            pace.done()
        clock.now += 1.0
    assert result == [0, 2, 4, 8, 13, 18]
