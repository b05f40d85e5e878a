"""What surrounds the work of a command."""

import gc
import subprocess
import sys

import pytest

from tests.support.processes import ENOUGH, environment
from weavesim.app import session
from weavesim.app.session import collected_alone, uncollected


def test_garbage_is_collected_again_afterwards_whatever_happens():
    assert gc.isenabled()
    with pytest.raises(ValueError, match="lost"), uncollected():
        assert not gc.isenabled()
        raise ValueError("lost")
    assert gc.isenabled()


def test_whoever_collects_nothing_keeps_it_so():
    gc.disable()
    try:
        with uncollected():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_a_run_collects_what_it_makes_and_only_the_first_of_a_process_keeps_what_was_before(monkeypatch):
    monkeypatch.setattr(session, "_has_run", False)
    for kept in (True, False):
        with uncollected():
            with collected_alone():
                assert gc.isenabled()
                assert (gc.get_freeze_count() > 1000) is kept
            assert not gc.isenabled()
        assert gc.get_freeze_count() == 0


def test_a_run_searches_for_garbage_less_often_and_afterwards_all_is_as_before():
    before = gc.get_threshold()
    with pytest.raises(ValueError, match="lost"), collected_alone():
        assert gc.get_threshold() == (session.OBJECTS_BETWEEN_SEARCHES, *before[1:]) != before
        raise ValueError("lost")
    assert gc.get_threshold() == before
    gc.set_threshold(0)  # never
    try:
        with collected_alone():
            assert gc.get_threshold()[0] == 0
    finally:
        gc.set_threshold(*before)


def test_a_run_of_whoever_collects_nothing_collects_nothing():
    gc.disable()
    try:
        with uncollected(), collected_alone():
            assert not gc.isenabled()
    finally:
        gc.enable()


# Garbage that holds itself, and tells when it is found; the command prints its version in between.
GARBAGE = """
import gc, sys
gc.disable()

class Garbage:
    def __init__(self):
        self.own = self
    def __del__(self):
        print("found")

Garbage()
if "command" in sys.argv:
    from weavesim.app.command_line import main
    sys.argv[1:] = ["--version"]
    main()
"""


@pytest.mark.parametrize(("arguments", "found"), [((), True), (("command",), False)])
def test_a_command_ends_without_a_last_search_for_garbage(arguments, found):
    done = subprocess.run(
        [sys.executable, "-c", GARBAGE, *arguments], env=environment(), capture_output=True, text=True, timeout=ENOUGH
    )
    assert done.returncode == 0, done.stderr
    assert ("found" in done.stdout) is found
