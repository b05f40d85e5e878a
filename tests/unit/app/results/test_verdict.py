"""``weavesim verdict`` and ``--strict``: exit codes, files of limits."""

import pytest

from weavesim.app.ending import ExitCode
from weavesim.app.options import RunOptions
from weavesim.app.results.verdict import strict_code
from weavesim.errors import InputError
from weavesim.measures.defects.judgement import Limits
from weavesim.output.stored.judged import read_limits


@pytest.fixture
def strict_limits(tmp_path):
    """A file with a limit that nothing keeps."""
    path = tmp_path / "limits.toml"
    path.write_text("locking_angle = 1.7\n")
    return path


def test_a_flat_sheet_passes(run_command, folder, tmp_path):
    code, *told = run_command("verdict", folder, "--out", tmp_path)
    assert code == 0 and "within all limits" in told[0]
    assert {path.name for path in tmp_path.iterdir()} == {"verdict.json", "verdict.csv", "verdict.png"}


def test_a_bad_file_of_limits_is_told(run_command, folder, tmp_path):
    path = tmp_path / "limits.toml"
    path.write_text("wrinkle_hight = 0.001\n")
    code, *told = run_command("verdict", folder, "--limits", path)
    assert code == ExitCode.INPUT_ERROR and "wrinkle_hight" in told[1]
    with pytest.raises(InputError, match="cannot be read"):
        read_limits(tmp_path / "none.toml")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("locking_angle = 0.8", "write 45.84 for 0.8 rad"),
        ("locking_angle = 95", "at most 90 degrees"),
        ("bridging_gap = 0.05", "bridging_gap = 0.05 m: usual are 0 to 0.02 m"),
        ("wrinkle_amplitude = 1", "write 0.001 for 1 mm"),
    ],
)
def test_limits_in_another_unit_are_refused(tmp_path, text, message):
    (tmp_path / "limits.toml").write_text(text)
    with pytest.raises(InputError, match=message):
        read_limits(tmp_path / "limits.toml")


def test_unusual_limits_are_taken_where_the_file_says_so(tmp_path):
    (tmp_path / "limits.toml").write_text("bridging_gap = 0.05")
    with pytest.raises(InputError, match="write accept_unusual = true in the file"):
        read_limits(tmp_path / "limits.toml")
    (tmp_path / "limits.toml").write_text("accept_unusual = true\nbridging_gap = 0.05")
    assert read_limits(tmp_path / "limits.toml").bridging_gap == 0.05


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
