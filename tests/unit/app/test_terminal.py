"""A terminal that goes away costs no run."""

import io
import subprocess
import sys

import pytest

from tests.support.processes import environment
from weavesim.app.terminal import SteadyStream, say


class Broken(io.StringIO):
    """Fails like a pipe whose reader has gone."""

    def write(self, text):
        raise BrokenPipeError(32, "Broken pipe")


@pytest.mark.parametrize("make", [lambda: None, Broken, lambda: Broken("closed")], ids=["none", "pipe", "closed"])
def test_a_stream_that_fails_is_silent(make):
    stream = make()
    if stream is not None and stream.getvalue():
        stream.close()
    steady = SteadyStream(stream)
    assert steady.write("text") == 4 and steady.write("more") == 4
    steady.flush()
    assert steady.isatty() is False and steady.encoding == "utf-8"


def test_what_a_stream_can_take_it_gets(capsys):
    SteadyStream(sys.stderr).write("text")
    say("to the one")
    say("to the other", error=True)
    assert capsys.readouterr() == ("to the one\n", "textto the other\n")


def test_a_name_that_is_no_text_is_shown_escaped(monkeypatch):
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding="utf-8"))
    say("out/gr\udcf6\udcdfe")
    assert raw.getvalue() == b"out/gr\\udcf6\\udcdfe\n"


CLOSED = """
import os, sys
for number in map(int, sys.argv[1:]):
    os.close(number)
from weavesim.app.terminal import hold_standard_streams
hold_standard_streams()
with open(os.devnull) as file:
    sys.exit(file.fileno() < 3)
"""


@pytest.mark.parametrize("closed", [(0,), (1,), (2,), (1, 2), (0, 1, 2)])
def test_no_file_gets_the_number_of_a_closed_stream(closed):
    done = subprocess.run([sys.executable, "-c", CLOSED, *map(str, closed)], env=environment(), check=False)
    assert done.returncode == 0
