"""``weavesim verdict`` and ``--strict``: exit codes, files of limits."""

import sys

import pytest

from tests.support.runs import one_sheet_setup
from tests.support.sheet import plain_fabric
from weavesim.app import command_line
from weavesim.app.ending import ExitCode
from weavesim.app.options import RunOptions
from weavesim.app.results.verdict import read_limits, strict_code
from weavesim.errors import InputError
from weavesim.measures.defects.judgement import Limits
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
def strict_limits(tmp_path):
    """A file with a limit that nothing keeps."""
    path = tmp_path / "limits.toml"
    path.write_text("locking_angle = 1e-300\n")
    return path


def run_command(monkeypatch, capsys, *arguments):
    monkeypatch.setattr(sys, "argv", ["weavesim", *map(str, arguments)])
    with pytest.raises(SystemExit) as ending:
        command_line.main()
    return ending.value.code or 0, capsys.readouterr()


def test_a_flat_sheet_passes(monkeypatch, capsys, folder, tmp_path):
    code, told = run_command(monkeypatch, capsys, "verdict", folder, "--out", tmp_path)
    assert code == 0 and "within all limits" in told.out
    assert {path.name for path in tmp_path.iterdir()} == {"verdict.json", "verdict.csv", "verdict.png"}


def test_a_bad_file_of_limits_is_told(monkeypatch, capsys, folder, tmp_path):
    path = tmp_path / "limits.toml"
    path.write_text("wrinkle_hight = 0.001\n")
    code, told = run_command(monkeypatch, capsys, "verdict", folder, "--limits", path)
    assert code == ExitCode.INPUT_ERROR and "wrinkle_hight" in told.err
    with pytest.raises(InputError, match="cannot be read"):
        read_limits(tmp_path / "none.toml")


def test_strict_is_the_worst_of_all_cases(folder):
    result = {"one": {"outcome": "finished"}, "outcome": "finished"}
    assert strict_code(result, folder.parent, Limits()) == 0
    assert strict_code({"outcome": "finished"}, folder, Limits()) == 0
    # the stretch of a free flat sheet is one but for rounding, and its angle zero: a limit on the gap needs tools
    assert strict_code({"outcome": "finished"}, folder, Limits(gap=1e-3)) == 0


def test_strict_needs_the_results_and_limits_need_strict(tmp_path):
    with pytest.raises(InputError, match="strict.*has no effect without"):
        RunOptions(strict=True, without="results")
    with pytest.raises(InputError, match="limits.*has no effect without strict"):
        RunOptions(limits=tmp_path / "x.toml")
    assert RunOptions(strict=True).strict
