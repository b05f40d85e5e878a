"""Progress of a study: how many runs are done, and how long the others take."""

import io

from rich.console import Console

from weavesim.app import study_progress
from weavesim.app.study_progress import StudyProgress


def shown(monkeypatch, seconds):
    clock = [100.0]
    monkeypatch.setattr(study_progress.time, "perf_counter", lambda: clock[0])
    stream = io.StringIO()
    progress = StudyProgress("tray", Console(file=stream, width=200))
    progress.planned(10, 2)
    return progress, clock, stream


def test_time_left_is_that_of_the_runs_that_are_left(monkeypatch):
    progress, clock, stream = shown(monkeypatch, 0)
    assert progress.time_left() is None
    progress.known(2)
    for _ in range(4):
        clock[0] += 5.0
        progress.ended("finished", 10.0)
    # four runs are left, of 10 s, two at a time
    assert progress.time_left() == 20.0
    assert "6 of 10 runs, 2 known, 0:20 left" in stream.getvalue()


def test_runs_that_did_not_finish_are_told(monkeypatch):
    progress, clock, stream = shown(monkeypatch, 0)
    progress.ended("refused", 0.0)
    progress.said("a\nb")
    progress.close()
    assert "1 of 10 runs, 1 did not finish" in stream.getvalue() and "a\\nb" in stream.getvalue()


def test_a_terminal_gets_a_bar(monkeypatch):
    stream = io.StringIO()
    progress = StudyProgress("tray", Console(file=stream, width=100, force_terminal=True))
    progress.planned(2, 1)
    progress.ended("finished", 1.0)
    progress.ended("finished", 1.0)
    progress.close()
    assert "2/2" in stream.getvalue()
