"""``weavesim compare``, in the words that a user sees."""

from functools import partial
from types import SimpleNamespace

import pytest

from weavesim.app.results.compare import paired


@pytest.fixture
def compare_command(run_command):
    return partial(run_command, "compare")


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


def test_measured_points(compare_command, folder, tmp_path):
    (tmp_path / "points.csv").write_text("flat_x,flat_y,shear_angle [deg]\n10,10,2\n20,5,1\n")
    code, out, err = compare_command(folder, tmp_path / "points.csv", "--unit", "mm", "--out", tmp_path)
    assert code == 0, err
    assert "shear angle [degrees] 1.5 on average, at most 2, over 100% of 2 points" in out
    code, _, err = compare_command(folder, tmp_path / "points.csv", "--unit", "mm", "--sheet", "upper")
    assert code == 2 and "sheet 'upper'" in err
    code, _, err = compare_command(folder, tmp_path / "points.csv", "--unit", "mm", "--unit-scale", 1)
    assert code == 2 and "both are given" in err


@pytest.mark.parametrize(
    ("theirs", "expected", "note"),
    [
        ("ba", [("a", "a"), ("b", "b")], ""),
        ("xb", [("a", "x"), ("b", "b")], "note: a is compared with x, by their places"),
    ],
)
def test_sheets_of_two_runs_are_paired_by_name(theirs, expected, note, capsys):
    def run(names):
        return SimpleNamespace(folder="run", sheets=tuple(SimpleNamespace(name=name) for name in names))

    assert [(own.name, each.name) for own, each in paired(run("ab"), run(theirs))] == expected
    assert capsys.readouterr().out.startswith(note) and bool(note) == (theirs == "xb")
