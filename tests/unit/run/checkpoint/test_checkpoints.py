"""Checkpoints of a run in a folder: found, refused, told, removed."""

import errno
import json
import logging
from pathlib import Path

import numpy as np
import pytest

from tests.support.frames import Frames
from tests.support.runs import small_run
from tests.unit.run.checkpoint.test_journal import same
from weavesim.errors import InputError
from weavesim.run.checkpoint import checkpoints as module
from weavesim.run.checkpoint.checkpoints import Checkpoints, has_job, read_job, remove_checkpoints
from weavesim.run.checkpoint.container import read_container, write_container
from weavesim.run.checkpoint.job import Job
from weavesim.run.frame import Outcome

GIVEN = {"duration": 4e-4, "frame_count": 4}


@pytest.fixture(autouse=True)
def _often(monkeypatch):
    """A checkpoint after every turn of steps."""
    monkeypatch.setattr(module, "LARGEST_SHARE", 1e9)


def run_in(folder: Path, **given):
    """A run with checkpoints, and its frames."""
    simulation, frames = small_run(**GIVEN, **given), Frames()
    simulation.run([frames], checkpoints=Checkpoints(folder, 1e-9))
    return simulation, frames.all


def files(folder: Path) -> list[str]:
    return sorted(path.name for path in (folder / module.FOLDER_NAME).iterdir())


@pytest.fixture(scope="module")
def whole():
    simulation, frames = small_run(**GIVEN), Frames()
    simulation.run([frames])
    return simulation, frames.all


def ends_alike(simulation, frames, whole) -> None:
    """Whether a run ends as one that was never interrupted."""
    reference, of_reference = whole
    assert simulation.outcome is Outcome.FINISHED
    assert len(frames) == len(of_reference) and all(map(same, frames, of_reference))
    assert simulation.history == reference.history and simulation.watch.history == reference.watch.history
    for (name, a), (_, b) in zip(simulation.state.arrays(), reference.state.arrays(), strict=True):
        assert a.numpy().tobytes() == b.numpy().tobytes(), name


def resumed(folder: Path):
    simulation, frames, checkpoints = small_run(**GIVEN), Frames(), Checkpoints(folder)
    assert checkpoints.find() is not None
    simulation.resume(checkpoints)
    simulation.run([frames])
    return simulation, frames.all


def test_writing_checkpoints_changes_no_bit(tmp_path, whole):
    ends_alike(*run_in(tmp_path), whole)
    assert len(files(tmp_path)) == 2 + module.KEPT_COUNT and {"job.bin", "frames.bin"} < set(files(tmp_path))


def test_every_checkpoint_leads_to_the_same_end(tmp_path, whole, monkeypatch):
    monkeypatch.setattr(module, "KEPT_COUNT", 10_000)
    run_in(tmp_path)
    numbered = [name for name in files(tmp_path) if name[0].isdigit()]
    assert len(numbered) > 4
    steps = set()
    for name in reversed(numbered):
        steps.add(read_container(tmp_path / module.FOLDER_NAME / name).values["step_count"])
        ends_alike(*resumed(tmp_path), whole)
        for later in files(tmp_path):
            if later[0].isdigit() and later >= name:
                (tmp_path / module.FOLDER_NAME / later).unlink()
    assert len(steps) > 4


def test_time_adds_up_and_parts_are_told(tmp_path):
    first, _ = run_in(tmp_path)
    again, _ = resumed(tmp_path)
    assert again.wall_time >= first.wall_time * 0.5 and again.stepping_time > 0.0
    (part,) = again.info.parts
    assert part in again.summary()["notes"] and part.startswith("resumed at step ") and not again.info.warnings


def test_a_run_without_checkpoints_writes_none(tmp_path, monkeypatch):
    simulation = small_run(**GIVEN)
    simulation.run()
    assert not simulation.checkpoint()


def test_a_stage_can_write_one_when_it_likes(tmp_path):
    simulation = small_run(**GIVEN)
    written = []

    class AtFrames(Frames):
        def frame(self, frame):
            written.append(simulation.checkpoint())

    simulation.run([AtFrames()], checkpoints=Checkpoints(tmp_path, 1e9))
    assert written == [True] * 5


def test_an_interval_that_is_stretched_is_told(tmp_path, caplog, monkeypatch):
    caplog.set_level("INFO")
    monkeypatch.setattr(module, "LARGEST_SHARE", 0.02)
    simulation, checkpoints = small_run(**GIVEN), Checkpoints(tmp_path, 1e-9)
    simulation.run(checkpoints=checkpoints)
    assert "not after the 1e-09 s of the interval, so that they take 2% of the run at most" in caplog.text


def test_a_run_that_ends_soon_keeps_its_job_alone(tmp_path):
    simulation = small_run(**GIVEN)
    simulation.run(checkpoints=Checkpoints(tmp_path, 1e9))
    assert files(tmp_path) == ["frames.bin", "job.bin"]
    assert not (tmp_path / module.FOLDER_NAME / "frames.bin").stat().st_size
    assert Checkpoints(tmp_path).find() is None


def test_frames_that_take_much_memory_do_not_wait_for_a_checkpoint(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "LARGEST_WAITING", 1)
    small_run(**GIVEN).run(checkpoints=Checkpoints(tmp_path, 1e9))
    assert (tmp_path / module.FOLDER_NAME / "frames.bin").stat().st_size > 5000


@pytest.mark.parametrize("what", ["flipped", "cut", "empty", "missing"])
def test_the_one_before_a_damaged_one_is_taken(tmp_path, whole, caplog, what):
    run_in(tmp_path)
    last = tmp_path / module.FOLDER_NAME / files(tmp_path)[1]
    data = bytearray(last.read_bytes())
    data[len(data) // 2] ^= 1
    content = {"flipped": bytes(data), "cut": bytes(data[:-100]), "empty": b"", "missing": None}[what]
    last.unlink() if content is None else last.write_bytes(content)
    ends_alike(*resumed(tmp_path), whole)
    assert what == "missing" or "a checkpoint is damaged (000" in caplog.text


def test_damaged_ones_are_refused_if_there_is_no_other(tmp_path):
    run_in(tmp_path)
    for name in files(tmp_path):
        if name[0].isdigit():
            (tmp_path / module.FOLDER_NAME / name).write_bytes(b"nothing")
    with pytest.raises(InputError, match=r"no checkpoint can be read \(.*--overwrite"):
        Checkpoints(tmp_path).find()


def test_damaged_frames_are_found_before_anything_is_done(tmp_path):
    run_in(tmp_path)
    path = tmp_path / module.FOLDER_NAME / "frames.bin"
    data = bytearray(path.read_bytes())
    data[100] ^= 1
    path.write_bytes(data)
    with pytest.raises(InputError, match="checksum is wrong"):
        Checkpoints(tmp_path).find()
    path.unlink()
    with pytest.raises(InputError, match="no checkpoint can be read"):
        Checkpoints(tmp_path).find()


def changed(folder: Path, **values) -> None:
    """Write other values into the last checkpoint."""
    path = folder / module.FOLDER_NAME / files(folder)[1]
    content = read_container(path)
    write_container(path, {**content.values, **values}, content.arrays)


def found_by(folder: Path, **given):
    checkpoints = Checkpoints(folder)
    checkpoints.find()
    small_run(**{**GIVEN, **given}).resume(checkpoints)


def test_another_version_of_weavesim_is_refused(tmp_path):
    run_in(tmp_path)
    changed(tmp_path, machine={"weavesim": "0.0.1"})
    with pytest.raises(InputError, match=r"it is of weavesim 0\.0\.1, and this is .*resume it with that version"):
        found_by(tmp_path)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"precision": "float32"}, "its precision is float64, not float32"),
        ({"lane_count": 16}, "its lane count is 1, not 16"),
        ({"duration": 5e-4}, "its setup is another one"),
    ],
)
def test_another_run_is_refused(tmp_path, given, message):
    run_in(tmp_path)
    with pytest.raises(InputError, match=message):
        found_by(tmp_path, **given)


def test_a_forged_checkpoint_is_refused(tmp_path):
    run_in(tmp_path)
    path = tmp_path / module.FOLDER_NAME / files(tmp_path)[1]
    content = read_container(path)
    write_container(path, content.values, {**content.arrays, "state/clock": np.zeros(99)})
    with pytest.raises(InputError, match="clock is missing or of another shape"):
        found_by(tmp_path)


def test_another_machine_is_told(tmp_path, whole):
    run_in(tmp_path)
    path = tmp_path / module.FOLDER_NAME / files(tmp_path)[1]
    here = read_container(path).values["machine"]
    changed(tmp_path, machine={**here, "warp": "1.0", "processor": "another"})
    simulation, frames = resumed(tmp_path)
    (warning,) = [text for text in simulation.info.warnings if "resumed" in text]
    assert "version of Warp" in warning and "processor" in warning and "last digits" in warning
    ends_alike(simulation, frames, whole)


def test_a_full_disk_costs_a_checkpoint_and_nothing_else(tmp_path, whole, caplog, monkeypatch):
    failing = iter([False, True, True, False, *[True] * 1000])

    def written(*arguments):
        if next(failing):
            raise OSError(errno.ENOSPC, "No space left on device")
        write_container(*arguments)

    monkeypatch.setattr(module, "write_container", written)
    with caplog.at_level(logging.WARNING):
        ends_alike(*run_in(tmp_path), whole)
    (told,) = [record.getMessage() for record in caplog.records if "checkpoint" in record.getMessage()]
    assert "(No space left on device): it is tried again; the last one stays, it is of " in told
    monkeypatch.undo()
    assert [name for name in files(tmp_path) if name[0].isdigit()] == ["000000.bin", "000001.bin"]
    ends_alike(*resumed(tmp_path), whole)


def test_frames_that_had_no_room_are_written_later(tmp_path, whole, monkeypatch):
    append, failing = module.FrameJournal.append, iter([False, True, True, *[False] * 100])

    def appended(self, frame):
        if next(failing):
            raise OSError(errno.ENOSPC, "No space left on device")
        append(self, frame)

    monkeypatch.setattr(module.FrameJournal, "append", appended)
    run_in(tmp_path)
    ends_alike(*resumed(tmp_path), whole)


def test_a_backlog_that_grows_too_large_ends_the_checkpoints(tmp_path, whole, caplog, monkeypatch):
    def full(self, frame):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(module.FrameJournal, "append", full)
    monkeypatch.setattr(module, "LARGEST_BACKLOG", 3000)
    ends_alike(*run_in(tmp_path), whole)
    assert "no more will be written" in caplog.text


def test_a_folder_that_vanishes_ends_the_checkpoints(tmp_path, whole, caplog):
    simulation = small_run(**GIVEN)

    class Vanishing(Frames):
        def frame(self, frame):
            super().frame(frame)
            if frame.index == 1:
                for path in (tmp_path / module.FOLDER_NAME).iterdir():
                    path.unlink()
                (tmp_path / module.FOLDER_NAME).rmdir()

    frames = Vanishing()
    simulation.run([frames], checkpoints=Checkpoints(tmp_path, 1e-9))
    ends_alike(simulation, frames.all, whole)
    assert "No such file or directory" in caplog.text and "no more will be written" in caplog.text
    assert not has_job(tmp_path)


def test_a_folder_that_cannot_be_written_to_costs_no_run(tmp_path, whole, caplog):
    (tmp_path / module.FOLDER_NAME).write_text("a file")
    ends_alike(*run_in(tmp_path), whole)
    assert "a checkpoint could not be written" in caplog.text
    assert (tmp_path / module.FOLDER_NAME).read_text() == "a file"


def test_only_own_files_are_removed(tmp_path):
    run_in(tmp_path)
    (tmp_path / module.FOLDER_NAME / "notes.txt").write_text("mine")
    (tmp_path / module.FOLDER_NAME / ".000009.bin.partial").write_text("half")
    remove_checkpoints(tmp_path)
    assert files(tmp_path) == ["notes.txt"]
    (tmp_path / module.FOLDER_NAME / "notes.txt").unlink()
    remove_checkpoints(tmp_path)
    remove_checkpoints(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_link_is_not_followed(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "job.bin").write_text("not ours")
    (tmp_path / module.FOLDER_NAME).symlink_to(tmp_path / "elsewhere")
    remove_checkpoints(tmp_path)
    assert (tmp_path / "elsewhere" / "job.bin").exists()


def test_a_job_is_read_or_a_word_said(tmp_path):
    with pytest.raises(InputError, match="there is nothing to resume in it"):
        read_job(tmp_path)
    simulation, _ = run_in(tmp_path)
    job, _ = read_job(tmp_path)
    assert job.setup == simulation.setup and job.run_id == simulation.info.run_id and has_job(tmp_path)
    (tmp_path / module.FOLDER_NAME / "job.bin").write_bytes(b"")
    with pytest.raises(InputError, match="job.bin: it is cut off after 0 bytes"):
        read_job(tmp_path)


def test_a_job_that_is_there_stays_there_at_every_moment(tmp_path, monkeypatch):
    job = Job(small_run().setup, "id")
    checkpoints = Checkpoints(tmp_path, job=job)
    checkpoints.begin(job)
    monkeypatch.setattr(Job, "write", lambda self, path: pytest.fail("it is written again"))
    Checkpoints(tmp_path).begin(job)
    assert json.dumps(read_job(tmp_path)[0].options) == "{}"
