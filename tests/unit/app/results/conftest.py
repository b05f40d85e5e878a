"""What the tests of commands on results share: the folder of a run, and a command as a user calls it."""

import sys
from collections.abc import Callable

import pytest

from tests.support.runs import one_sheet_setup
from tests.support.sheet import plain_fabric
from weavesim.app import command_line
from weavesim.output import ResultFolder
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder of a small, flat run."""
    blank = Blank.rectangle((0.0, 0.0), (0.03, 0.02), 0.005)
    setup = one_sheet_setup(name="small", blank=blank, fabric=plain_fabric(), duration=1e-5, frame_count=2)
    path = tmp_path_factory.mktemp("runs") / "one"
    Simulation(setup).run([ResultFolder(path, writers=["results"])])
    return path


@pytest.fixture
def run_command(monkeypatch, capsys) -> Callable[..., tuple[int, str, str]]:
    """Runs ``weavesim`` with arguments: (exit code, stdout, stderr)."""

    def call(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["weavesim", *map(str, arguments)])
        with pytest.raises(SystemExit) as ending:
            command_line.main()
        captured = capsys.readouterr()
        return ending.value.code or 0, captured.out, captured.err

    return call
