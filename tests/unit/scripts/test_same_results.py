"""The comparison of two versions' results: any bit, and where it is; the runs themselves are not started."""

import json
import subprocess
import sys
from dataclasses import dataclass, field

import numpy as np
import pytest

from scripts.comparison.differences import difference, differences
from scripts.comparison.inputs import write_inputs
from scripts.comparison.reading import RENAMED
from scripts.comparison.recorded_run import Record
from scripts.comparison.verdict import compare, verdict_table
from tests.support.paths import ROOT

SCRIPTS = ROOT / "scripts"


@dataclass
class Frame:
    """As a run's: numbers, arrays over the nodes, fields and energies by name."""

    index: int
    position: np.ndarray
    fields: dict = field(default_factory=dict)
    energies: dict = field(default_factory=dict)


@pytest.fixture
def results(tmp_path):
    """Writes the results of a small run whose kinetic energies and last coordinate are given."""

    def write(name, kinetic, coordinate=1.0, threads=1):
        out = tmp_path / name / "out"
        out.mkdir(parents=True)
        record = Record()
        for index, value in enumerate(kinetic):
            position = np.zeros((20, 3))
            position[-1, 2] = coordinate * index
            angle = np.full(40, 0.1, dtype=np.float32)
            record.add(Frame(index, position, {"shear_angle": angle}, {"kinetic": value, "internal": 2.0}))
        record.write(tmp_path / name / "frames.npz")
        (out / "history.csv").write_text("frame,kinetic_energy_j\n" + "".join(f"{i},0\n" for i in range(len(kinetic))))
        summary = {"wall_time_s": threads, "threads": threads, "energies_j": {"kinetic": kinetic[-1]}, "notes": ["a"]}
        (out / "summary.json").write_text(json.dumps(summary))
        (out / "film.usdc").write_bytes(bytes([threads]))
        return tmp_path / name

    return write


def test_same_results_are_the_same_whatever_the_clock_says(results):
    verdict = compare("case", results("a", [0.0, 1.0]), results("b", [0.0, 1.0], threads=2))
    assert verdict.same and verdict.entry_count > 8
    assert verdict.changed_files == ["film.usdc"]


def test_one_bit_of_one_frame_is_found_with_its_frame_and_size(results):
    verdict = compare("case", results("a", [0.0, 1.0, 4.0]), results("b", [0.0, 1 + 2**-52, 4.0]))
    (one,) = verdict.found
    assert not verdict.same
    assert (one.name, one.frame) == ("frames/energies.kinetic", 1)
    assert one.size == pytest.approx(2**-52 / 4.0)
    assert "frame 1, 1.0 became 1.0000000000000002, 1 of 3 values, relative difference 5.6e-17" in str(one)


def test_the_earliest_frame_comes_first_and_the_last_state_tells_how_far(results):
    verdict = compare("case", results("a", [0.0, 1.0, 2.0]), results("b", [0.0, 1.0, 3.0], 1.5))
    assert [one.name for one in verdict.found] == [
        "frames/sha256 of position", "frames/energies.kinetic", "last/position", "summary.json/energies_j.kinetic",
    ]  # fmt: skip
    assert [one.frame for one in verdict.found] == [1, 2, None, None]
    assert verdict.found[2].size == pytest.approx(1.0 / 3.0)
    assert "DIFFERENT (4 entries)" in verdict_table([verdict])


def test_a_shorter_run_is_different(results):
    verdict = compare("case", results("a", [0.0, 1.0, 1.0]), results("b", [0.0, 1.0]))
    assert verdict.found[0].frame == 2 and "3 frames became 2" in verdict.found[0].text


@pytest.mark.parametrize(
    ("before", "after", "text"),
    [
        (np.array([0.0]), np.array([-0.0]), "0.0 became -0.0"),
        (np.array([1.0]), np.array([np.nan]), "1.0 became nan"),
        (np.array([1.0]), np.array([1.0], dtype=np.float32), "float64 became float32"),
        (np.zeros(3), np.zeros((3, 1)), r"shape (3,) became (3, 1)"),
        (np.array(["0.5", "1"]), np.array(["0.5", "1.0"]), "1 became 1.0"),
        (np.array("finished"), np.array("interrupted"), "finished became interrupted"),
        (np.array(True), np.array(False), "True became False"),
    ],
)
def test_what_counts_as_different(before, after, text):
    assert text in difference("name", before, after).text
    assert difference("name", before, before.copy()) is None


def test_nan_is_the_same_as_itself_and_empty_as_empty():
    assert difference("name", np.array([np.nan]), np.array([np.nan])) is None
    assert difference("name", np.zeros((2, 0, 3)), np.zeros((2, 0, 3))) is None


def test_entries_that_only_one_has_are_reported():
    found = differences({"a": np.zeros(1), "b": np.zeros(1)}, {"b": np.zeros(1), "c": np.zeros(1)})
    assert [str(one) for one in found] == ["a: is missing", "c: is new"]


def test_a_name_changed_on_purpose_is_no_difference(results, monkeypatch):
    before, after = results("a", [0.0]), results("b", [0.0])
    table = after / "out" / "history.csv"
    table.write_text(table.read_text().replace("kinetic_energy_j", "motion_j"))
    assert len(compare("case", before, after).found) == 2
    monkeypatch.setitem(RENAMED, "history.csv/kinetic_energy_j", "history.csv/motion_j")
    assert compare("case", before, after).same


def test_tools_of_the_cases_are_read_as_sheets(tmp_path):
    import trimesh

    write_inputs(tmp_path)
    mesh = trimesh.load_mesh(tmp_path / "punch.stl")
    np.testing.assert_allclose(mesh.bounds, [[-145.0, -60.0, 0.0], [145.0, 60.0, 60.0]], atol=1e-4)
    write_inputs(tmp_path)
    (tmp_path / "punch.stl").write_bytes(b"another")
    with pytest.raises(SystemExit, match="record the reference again"):
        write_inputs(tmp_path)


def test_cases_are_listed_and_unknown_ones_refused():
    def answer(*arguments):
        return subprocess.run([sys.executable, SCRIPTS / "same_results.py", *arguments], capture_output=True, text=True)

    listed = answer("--list").stdout.splitlines()
    assert "double-dome-quarter (quick): weavesim double-dome" in listed
    refused = answer("--case", "nothing")
    assert refused.returncode == 2 and "cantilever" in refused.stderr
