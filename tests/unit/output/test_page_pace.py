"""The page of a run in progress is written early and often, and never for more than a small share of the time."""

import pytest

from weavesim.output.run_page import progress as module
from weavesim.output.run_page.progress import PagePace


@pytest.fixture
def clock(monkeypatch):
    class Clock:
        now = 1000.0

    monkeypatch.setattr(module.time, "monotonic", lambda: Clock.now)
    return Clock


def written(clock, duration, cost, frame_count=80, preparation=0.0):
    """Times [s] at which pages begin, in a run that takes so long without them."""
    pace, start, found = PagePace(), clock.now, []
    for _ in range(frame_count):
        clock.now += duration / frame_count
        if pace.due(left=duration + start - clock.now):
            clock.now += preparation if not found else 0.0
            found.append(clock.now - start)
            pace.begin()
            clock.now += cost
            pace.done()
    return found


@pytest.mark.parametrize(("duration", "cost"), [(20.0, 0.05), (30.0, 0.1), (60.0, 0.2), (120.0, 0.3)])
def test_a_run_of_some_seconds_to_minutes_has_about_ten_pages(clock, duration, cost):
    times = written(clock, duration, cost)
    assert 7 <= len(times) <= 20 and times[0] < 5.0
    assert len(times) * cost <= 0.05 * duration


@pytest.mark.parametrize("duration", [1.9, 4.0, 6.9, 11.0, 16.0])
def test_a_run_of_a_few_seconds_has_none_before_its_end(clock, duration):
    """Its only page would take a twentieth of it, and be replaced at once."""
    assert written(clock, duration, 0.1) == []


def test_a_run_that_does_not_know_its_end_has_pages(clock):
    pace = PagePace()
    assert not pace.due(None)
    clock.now += 3.0
    assert pace.due(None)


def test_a_page_that_takes_long_is_rare(clock):
    times = written(clock, 3600.0, 4.0, frame_count=2000)
    assert len(times) * 4.0 < 0.03 * 3600.0 and times[1] - times[0] > 79.0


def test_what_is_prepared_once_delays_no_later_page(clock):
    """Importing and computing the curves of the fabric takes longer than many pages."""
    times = written(clock, 30.0, 0.1, preparation=7.0)
    assert len(times) > 6 and times[1] - times[0] < 3.0
