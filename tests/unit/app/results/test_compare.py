"""``weavesim compare``, in the words that a user sees."""

import sys

import pytest

from tests.support.runs import one_sheet_setup
from tests.support.sheet import plain_fabric
from weavesim.app import command_line
from weavesim.output import ResultFolder
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The folder of a small run."""
    blank = Blank.rectangle((0.0, 0.0), (0.03, 0.02), 0.005)
    setup = one_sheet_setup(name="small", blank=blank, fabric=plain_fabric(), duration=1e-5, frame_count=2)
    path = tmp_path_factory.mktemp("run")
    Simulation(setup).run([ResultFolder(path, writers=["results"])])
    return path


@pytest.fixture
def compare_command(monkeypatch, capsys):
    """Runs ``weavesim compare``: (exit code, stdout, stderr)."""

    def call(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["weavesim", "compare", *map(str, arguments)])
        with pytest.raises(SystemExit) as ending:
            command_line.main()
        captured = capsys.readouterr()
        return ending.value.code or 0, captured.out, captured.err

    return call


def test_a_run_beside_itself(compare_command, folder, tmp_path):
    code, out, err = compare_command(folder, folder, "--out", tmp_path)
    assert code == 0, err
    assert "shear angle [degrees] 0 on average" in out and "over 100% of the sheet" in out
    assert {path.name for path in tmp_path.iterdir()} == {f"comparison.{end}" for end in ("json", "csv", "png")}


def test_what_is_no_run_and_no_scan_is_told(compare_command, folder, tmp_path):
    code, _, err = compare_command(folder, tmp_path / "scan.stl")
    assert code == 2 and "scan" in err and "does not exist" in err
    code, _, err = compare_command(folder, tmp_path)
    assert code == 2 and "it has no results.h5" in err
    code, _, err = compare_command(folder, folder, "--unit-scale", -1)
    assert code == 2 and "unit_scale" in err
