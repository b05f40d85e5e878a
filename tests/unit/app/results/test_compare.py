"""``weavesim compare``, in the words that a user sees."""

from functools import partial

import pytest


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
