"""``run.json``: every file of a run, and everything that repeats it; and the run id in every file."""

import json
import re

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim import Setup, Simulation
from weavesim.output import ResultFolder
from weavesim.output.claim import record as record_module
from weavesim.output.claim.record import file_hash
from weavesim.output.files import replacing
from weavesim.run.frame import Outcome, new_run_id


def test_run_ids_differ_and_sort_by_time():
    ids = [new_run_id() for _ in range(1000)]
    assert len(set(ids)) == 1000 and all(re.fullmatch(r"\d{8}T\d{6}Z-[0-9a-f]{8}", one) for one in ids)


@pytest.fixture(scope="module")
def finished(tmp_path_factory, coarse_run):
    path = tmp_path_factory.mktemp("results")
    (path / "given.csv").write_text("point,angle_deg\n1,20\n")
    options = {"fabric": "glass", "measured": str(path / "given.csv"), "mesh_size": 0.01, "none": None}
    folder = ResultFolder(path, options=options)
    info, frames = coarse_run
    folder.start(info)
    for frame in frames:
        folder.frame(frame)
    folder.finish(Outcome.FINISHED)
    folder.write({})
    return path, info, json.loads((path / "run.json").read_text())


def test_the_record_lists_every_file_with_its_hash(finished):
    path, _, record = finished
    files = {str(file.relative_to(path)) for file in path.rglob("*") if file.is_file()}
    assert set(record["files"]) == files - {"run.json", ".weavesim.lock", "given.csv"}
    for name, digest in record["files"].items():
        assert file_hash(path / name) == digest


def test_only_files_that_have_changed_are_hashed_again_at_the_end(tmp_path, coarse_run, monkeypatch):
    hashed = []
    monkeypatch.setattr(record_module, "file_hash", lambda path: hashed.append(path.name) or file_hash(path))
    record = record_module.RunRecord(tmp_path, coarse_run[0], {})
    for name in ("stays", "replaced", "goes", "comes"):
        record.add(tmp_path / name)
        if name != "comes":
            (tmp_path / name).write_text("one")
    record.hash_so_far()
    assert hashed == ["stays", "replaced", "goes"]
    hashed.clear()
    with replacing(tmp_path / "replaced") as temporary:
        temporary.write_text("two")  # as long as before
    (tmp_path / "goes").unlink()
    (tmp_path / "comes").write_text("new")
    assert set(json.loads((tmp_path / "run.json").read_text())["files"].values()) == {None}
    record.finish(outcome="finished")
    assert hashed == ["replaced", "comes"]
    expected = {name: file_hash(tmp_path / name) for name in ("stays", "replaced", "comes")}
    assert json.loads((tmp_path / "run.json").read_text())["files"] == {**expected, "goes": None}


def test_the_record_tells_how_it_was_run(finished):
    path, info, record = finished
    assert record["run_id"] == info.run_id and record["outcome"] == "finished" and record["missing"] == []
    assert record["options"]["mesh_size"] == 0.01 and record["command"]
    assert record["input_files"] == {
        "measured": {
            "path": str(path / "given.csv"), "bytes": 21, "sha256": file_hash(path / "given.csv"),
        }
    }  # fmt: skip
    assert {"weavesim", "python", "warp-lang", "numpy"} <= set(record["versions"])
    assert record["processor_features"] and record["device"] == "cpu" and record["precision"] == "float32"


def test_the_run_id_is_in_every_file_that_can_tell_it(finished):
    """In tables it cannot be without breaking their readers: their hashes are in the record."""
    path, info, record = finished
    for name in (*record["files"], "run.json"):
        content = (path / name).read_bytes()
        if name.endswith(".csv"):
            continue
        if name.endswith(".usdc"):
            from pxr import Sdf

            layer = Sdf.Layer.FindOrOpen(str(path / name))
            assert layer.customLayerData["weavesim"]["run_id"] == info.run_id
        else:
            assert info.run_id.encode() in content, name


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_a_run_is_repeated_from_its_folder_to_the_bit(tmp_path, precision):
    first = small_run(precision=precision)
    folder = ResultFolder(tmp_path, writers=["summary"])
    first.run([folder])
    folder.write(first.summary())
    setup = Setup.from_json((tmp_path / "setup.json").read_text())
    assert setup == first.setup
    assert setup.content_hash == json.loads((tmp_path / "run.json").read_text())["setup_hash"]
    again = Simulation(setup)
    again.run()
    assert again.info.run_id != first.info.run_id
    assert np.array_equal(again.frame.position, first.frame.position)
    assert again.frame.energies == first.frame.energies
