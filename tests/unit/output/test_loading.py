"""Libraries of writers are loaded beside the first steps of a run; what is not installed is told before it."""

import gc
import subprocess
import sys
import threading
from functools import partial

import pytest

from tests.support.processes import COARSE, ENOUGH, environment
from weavesim.app.ending import ExitCode
from weavesim.engine.threads import ThreadChoice
from weavesim.errors import InputError
from weavesim.output import ResultFolder, Writer, chosen_writers
from weavesim.output import loading as loading_module
from weavesim.output import writer as writer_module
from weavesim.output.folder import LARGEST_WAITING_COUNT
from weavesim.output.loading import Loading
from weavesim.output.sharing import can_share
from weavesim.run.frame import Outcome


@pytest.fixture(autouse=True)
def _forgotten(monkeypatch):
    """Nothing was loaded before, and what a test defines is unknown afterwards."""
    monkeypatch.setattr(loading_module, "_done", set())
    monkeypatch.setattr(writer_module, "_known", dict(writer_module._known))


def test_all_is_called_in_order_in_another_thread_and_a_failure_stops_nothing():
    called, threads = [], set()

    def first():
        called.append("first")
        raise ImportError("no such library")

    def second():
        called.append("second")
        threads.add(threading.current_thread())

    before = sys.getswitchinterval()
    loading = Loading([first])
    loading.add(second)
    loading.wait()  # it has not begun
    assert not called and not loading.has(second)
    loading.begin()
    loading.wait()
    assert called == ["second", "first"] and threading.current_thread() not in threads
    assert loading.has(first) and loading.has(second) and sys.getswitchinterval() == before
    again = Loading([first, second])
    again.begin()
    again.wait()
    assert called == ["second", "first"]


def test_runs_leave_a_core_to_it_from_the_moment_it_begins(monkeypatch):
    monkeypatch.setattr("weavesim.engine.threads.available_threads", lambda: 2)
    choice, gate = ThreadChoice((1, 2)), threading.Event()
    loading = Loading([lambda: gate.wait(30.0)])
    assert choice.present() is choice
    loading.begin()
    assert choice.present().counts == (1,)
    gate.set()
    loading.wait()
    assert choice.present() is choice


def test_two_that_load_at_once_leave_the_turns_of_threads_as_they_were():
    before, gates = sys.getswitchinterval(), [threading.Event(), threading.Event()]
    both = [Loading([partial(gate.wait, 30.0)]) for gate in gates]
    for loading in both:
        loading.begin()
    for gate, loading in zip(gates, both, strict=True):  # the first to begin is the first to end
        gate.set()
        loading.wait()
    assert sys.getswitchinterval() == before


def test_what_libraries_make_is_not_searched_for_garbage_in_a_run_that_searches_only_its_own():
    made = []
    assert gc.get_freeze_count() == 0
    for freezes in (False, True):
        if freezes:
            gc.freeze()
        before = gc.get_freeze_count()
        try:
            loading = Loading([lambda: made.extend([{}] for _ in range(1000))])
            loading.begin()
            loading.wait()
            assert (gc.get_freeze_count() >= before + 1000) is freezes
        finally:
            gc.unfreeze()


def test_without_room_for_a_thread_all_is_called_at_once(monkeypatch):
    def full(thread):
        raise RuntimeError("can't start new thread")

    called = []
    monkeypatch.setattr(threading.Thread, "start", full)
    loading = Loading([lambda: called.append(1)])
    loading.begin()
    loading.wait()
    assert called == [1]


def test_what_is_no_exception_stops_nothing_either():
    called = []

    def broken():
        raise SystemExit(3)

    def next_one():
        called.append(1)

    loading = Loading([broken, next_one])
    loading.begin()
    loading.wait()
    assert called == [1] and loading.has(broken)


def test_a_missing_package_is_told_before_the_run(tmp_path, monkeypatch):
    monkeypatch.setattr(chosen_writers(["film"])[0], "packages", ("pxr", "no_such_package"))
    with pytest.raises(InputError, match="film: it needs the package no_such_package, which is not installed"):
        ResultFolder(tmp_path)
    ResultFolder(tmp_path, writers=["summary"])


@pytest.mark.parametrize("frame_count", [3, LARGEST_WAITING_COUNT + 3])
def test_a_writer_gets_what_it_missed_while_its_libraries_were_loaded(tmp_path, coarse_run, frame_count):
    (info, frames), gate, seen = coarse_run, threading.Event(), []

    class Late(Writer):
        name = "late"
        needs_load = True

        @classmethod
        def load(cls):
            assert gate.wait(30.0)
            seen.append("load")

        def start(self, info):
            seen.append("start")

        def frame(self, frame):
            seen.append("frame")

        def finish(self, outcome):
            seen.append("finish")

    folder = ResultFolder(tmp_path, writers=["late", "summary"])
    folder.start(info)
    if frame_count <= LARGEST_WAITING_COUNT:
        for _ in range(frame_count):
            folder.frame(frames[0])
        assert seen == []
        gate.set()
    else:  # it waits for the libraries rather than for ever keep what is to be written
        opener = threading.Timer(0.2, gate.set)
        opener.start()
        for _ in range(frame_count):
            folder.frame(frames[0])
        assert seen == ["load", "start", *["frame"] * frame_count]
    folder.finish(Outcome.FINISHED)
    assert seen == ["load", "start", *["frame"] * frame_count, "finish"]


# Ends the command when libraries would begin to load beside its first step, with the names of the packages that it has
# imported. At the step itself the thread that loads may be far ahead.
_UP_TO_THE_FIRST_STEP = """
import os, sys
from weavesim.app.command_line import main
from weavesim.output.loading import Loading

def end(*arguments):
    os.write(1, " ".join(sorted({name.partition(".")[0] for name in sys.modules})).encode())
    os._exit(0)

Loading.begin = end
main()
"""


def test_nothing_that_draws_or_writes_is_imported_before_the_first_step(tmp_path):
    command = [sys.executable, "-c", _UP_TO_THE_FIRST_STEP, *COARSE, "--out", str(tmp_path / "out")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=ENOUGH, env=environment())
    imported = set(done.stdout.split())
    assert "warp" in imported, done.stderr
    assert not imported & {"pxr", "matplotlib", "scipy", "h5py", "jinja2", "PIL", "plotly", "meshio"}


def test_what_hangs_is_waited_for_once_and_the_rest_does_without_it(tmp_path, coarse_run, monkeypatch):
    (info, frames), gate, seen = coarse_run, threading.Event(), []
    monkeypatch.setattr(loading_module, "LONGEST_WAIT", 0.05)

    class Hanging(Writer):
        name = "hanging"
        title = "what hangs"

        @classmethod
        def load(cls):
            gate.wait(30.0)

        def finish(self, outcome):
            seen.append("hanging")

    class Later(Hanging):
        name = "later"
        title = "what comes later"
        needs_load = True
        rank = 1

        @classmethod
        def load(cls):
            seen.append("later loaded")

        def frame(self, frame):
            seen.append("frame")

        def finish(self, outcome):
            seen.append("later")

    folder = ResultFolder(tmp_path, writers=["hanging", "later", "summary"])
    folder.start(info)
    try:
        folder.frame(frames[0])
        folder.finish(Outcome.FINISHED)
        assert seen == ["frame", "later"]
        assert not can_share()  # a thread is within an import
        summary = folder.write({})
        assert summary["missing"] == ["what hangs"]
        assert [str(text) for text in folder.warnings] == [
            "what hangs could not be written and is given up: its libraries are not there after 120 s"
        ]
    finally:
        gate.set()
        folder.release()


# A command whose USD is on a disk that does not answer.
_HANGING_FILM = """
import time
from weavesim.app.command_line import main
from weavesim.output import loading
from weavesim.output.film.film import Film

loading.LONGEST_WAIT = loading.LONGEST_WAIT_AT_EXIT = 0.5
Film.load = lambda: time.sleep(1000.0)
main()
"""


def test_a_command_ends_although_a_library_hangs(tmp_path):
    out = tmp_path / "out"
    command = [sys.executable, "-c", _HANGING_FILM, *COARSE, "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=ENOUGH, env=environment())
    assert done.returncode == ExitCode.MISSING, done.stderr
    assert "film could not be written and is given up: its libraries" in done.stderr + done.stdout
    assert (out / "report.html").is_file() and (out / "results.h5").is_file() and not list(out.glob("*.usdc"))
