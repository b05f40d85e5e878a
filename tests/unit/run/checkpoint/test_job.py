"""What is kept of a run so that it goes on without anything else."""

from pathlib import Path

import pytest

from tests.support.every_kind import every_kind
from weavesim.run.checkpoint.container import DamageError
from weavesim.run.checkpoint.job import Job, unpacked_options

CASES = every_kind()


@pytest.mark.parametrize("name", CASES)
def test_every_set_up_is_kept_whole(tmp_path, name):
    job = Job(CASES[name], "id", {"a": [1, "b"], "c": None}, {"scene": "s", "case": ""}, ("film",), 3, True)
    job.write(tmp_path / "job.bin")
    again, content = Job.read(tmp_path / "job.bin")
    assert again == job and again.setup.content_hash == job.setup.content_hash
    assert unpacked_options(again, content, tmp_path / "inputs") == job.options


def test_files_that_options_name_are_kept(tmp_path):
    measured, others = tmp_path / "measured.csv", [tmp_path / "a" / "one.csv", tmp_path / "b" / "one.csv"]
    for number, path in enumerate([measured, *others]):
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"content {number}")
    options = {"measured": str(measured), "out": str(tmp_path), "tests": [str(path) for path in others], "name": "none"}
    Job(CASES["supports and loads"], "id", options).write(tmp_path / "job.bin")
    for path in (measured, *others):
        path.unlink()
    job, content = Job.read(tmp_path / "job.bin")
    (tmp_path / "inputs").mkdir()
    again = unpacked_options(job, content, tmp_path / "inputs")
    assert Path(again["measured"]).read_text() == "content 0" and again["measured"].endswith("measured.csv")
    assert [Path(path).read_text() for path in again["tests"]] == ["content 1", "content 2"]
    assert (again["name"], again["out"]) == ("none", str(tmp_path)) and job.options == options


def test_a_name_in_a_job_leads_nowhere_else(tmp_path, monkeypatch):
    """Files get their last name only, whatever a forged job says."""
    from weavesim.run.checkpoint import job as module

    monkeypatch.setattr(module, "_named_files", lambda options: [("measured\n../../evil", module.np.zeros(1, "u1"))])
    Job(CASES["supports and loads"], "id", {"measured": "../../evil"}).write(tmp_path / "job.bin")
    (tmp_path / "inputs").mkdir()
    options = unpacked_options(*Job.read(tmp_path / "job.bin"), tmp_path / "inputs")
    assert options["measured"] == str(tmp_path / "inputs" / "0" / "evil")


def test_damage_is_found(tmp_path):
    path = tmp_path / "job.bin"
    Job(CASES["supports and loads"], "id").write(path)
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 4
    path.write_bytes(data)
    with pytest.raises(DamageError, match="checksum"):
        Job.read(path)
