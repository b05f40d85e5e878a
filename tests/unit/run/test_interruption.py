"""Signals end a run in order: noted while a run has something to lose, raised at once before."""

import os
import signal
import threading

import pytest

from tests.support.frames import Frames
from tests.support.runs import small_run
from weavesim.run import interruption as module
from weavesim.run.frame import Outcome
from weavesim.run.interruption import SIGNALS, Interrupted, interruption


def send(number: int) -> None:
    signal.raise_signal(number)


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_a_signal_is_noted_while_held(number):
    with interruption() as interrupted, interrupted.held():
        assert not interrupted.is_set()
        send(number)
        assert interrupted.is_set() and interrupted.signal is number


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_a_signal_is_raised_where_there_is_nothing_to_lose(number):
    with pytest.raises(Interrupted) as caught, interruption():
        send(number)
    assert caught.value.signal is number and isinstance(caught.value, KeyboardInterrupt)


def test_the_first_signal_is_kept_and_the_third_press_is_obeyed():
    with interruption() as interrupted, interrupted.held():
        send(signal.SIGTERM)
        for _ in range(5):
            send(signal.SIGTERM)
            send(signal.SIGHUP)
        send(signal.SIGINT)
        send(signal.SIGINT)
        assert interrupted.signal is signal.SIGTERM
        with pytest.raises(KeyboardInterrupt):
            send(signal.SIGINT)


def test_a_second_press_after_a_while_is_obeyed(monkeypatch):
    monkeypatch.setattr(module, "PATIENCE", 0.0)
    with interruption() as interrupted, interrupted.held():
        send(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            send(signal.SIGINT)


def test_handlers_are_restored():
    before = [signal.getsignal(number) for number in SIGNALS]
    with interruption() as outer:
        with interruption() as inner:
            assert inner is outer
        assert signal.getsignal(signal.SIGTERM) == outer.handle
    assert [signal.getsignal(number) for number in SIGNALS] == before


def test_nohup_is_respected():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with interruption() as interrupted, interrupted.held():
            os.kill(os.getpid(), signal.SIGHUP)
            assert not interrupted.is_set()
    finally:
        signal.signal(signal.SIGHUP, before)


def test_another_thread_leaves_signals_alone():
    seen = []

    def work():
        with interruption() as interrupted:
            seen.append((interrupted.is_set(), signal.getsignal(signal.SIGTERM)))

    before = signal.getsignal(signal.SIGTERM)
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [(False, before)]


class Sending(Frames):
    """Sends a signal at a frame."""

    def __init__(self, index, number):
        super().__init__()
        self.index, self.number = index, number

    def frame(self, frame):
        super().frame(frame)
        if frame.index == self.index:
            send(self.number)


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
def test_a_run_ends_at_its_last_state_and_tells_the_signal(number):
    simulation = small_run(frame_count=4, duration=1e-3)
    frames = Sending(2, number)
    assert simulation.run([frames]) is Outcome.INTERRUPTED is frames.outcome
    assert simulation.interrupted_by == number.name
    assert [frame.index for frame in frames.all] == [0, 1, 2]  # no steps follow, so no frame


def test_a_signal_at_the_last_frame_comes_too_late():
    simulation = small_run(frame_count=4, duration=1e-3)
    assert simulation.run([Sending(4, signal.SIGTERM)]) is Outcome.FINISHED
    assert simulation.interrupted_by is None
