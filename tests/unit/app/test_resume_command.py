"""``weavesim resume``: a run that was killed at any moment ends as one that was never interrupted."""

import json
import signal
import subprocess
import sys

import pytest

from tests.support.paths import ROOT
from tests.support.processes import COARSE, ENOUGH, environment, run, run_forked, slow_run, summary, wait_for
from weavesim.app.resume_command import resume_folder
from weavesim.errors import InputError
from weavesim.output import ResultFolder
from weavesim.run.checkpoint.checkpoints import FOLDER_NAME, has_job

# Runs in stages; shorter ones follow until there were so many kills.
RUN_COUNT, KILL_COUNT, SEED = 4, 30, 20261126
OFTEN = ("--checkpoint-interval", "0.2", "--accept-unusual")


def test_runs_that_are_killed_at_any_moment_end_alike(tmp_path):
    """Also while checkpoints, frames, film, tables and summary are written, and while they are resumed."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.support.kills", str(tmp_path), str(RUN_COUNT), str(SEED), str(KILL_COUNT)],
        cwd=ROOT, env=environment(), capture_output=True, text=True,
    )  # fmt: skip
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    runs, wholes = ([line for line in lines if ("reference" in line) == whole] for whole in (False, True))
    assert done.returncode == 0, [found for found in runs if found.get("different") != []]
    assert len(wholes) == 2 and all(each["reference"] > 20 and each["operations"] > 300 for each in wholes), wholes
    deaths = [death for found in runs for death in found["deaths"]]
    killed = [death for death in deaths if death["ended"] == "killed"]
    assert len(killed) >= KILL_COUNT and any(death["operation"] is not None for death in killed)
    assert any(death["resumable"] for death in killed)


def comparable(folder) -> dict[str, object]:
    """What a run leaves, but for its id, times, and its parts."""
    found = {path.name: path.read_bytes() for path in sorted(folder.glob("*.csv"))}
    numbers = summary(folder)
    names = ("outcome", "frame_count", "step_count", "time_s", "max_shear_angle_deg", "verdict", "energies_j")
    return {**found, **{name: numbers[name] for name in names}}


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    assert run_forked(*COARSE, "--speed", "0.02", "--write", "film,tables,summary", "--out", folder).returncode == 0
    return folder


@pytest.mark.parametrize(
    "number", [pytest.param(signal.SIGKILL, marks=pytest.mark.slow), signal.SIGTERM], ids=lambda number: number.name
)
def test_the_command_goes_on(tmp_path, uninterrupted, number):
    process = slow_run(tmp_path, *OFTEN, "--speed", "0.02")
    wait_for(lambda: list(tmp_path.glob(f"{FOLDER_NAME}/0*.bin")))
    process.send_signal(number)
    out, err = process.communicate(timeout=ENOUGH)
    assert number == signal.SIGKILL or f"Go on with it: weavesim resume {tmp_path}" in out, err
    again = run_forked(*COARSE, "--out", tmp_path)
    assert again.returncode == 2 and f"weavesim resume {tmp_path}" in again.stderr
    done = run("resume", tmp_path, "--threads", "1")
    assert done.returncode in (0, 3), done.stderr
    assert "resumed at step" in done.stderr and "Traceback" not in done.stderr
    assert comparable(tmp_path) == comparable(uninterrupted) and not (tmp_path / FOLDER_NAME).exists()
    log = (tmp_path / "run.log").read_text()
    assert log.count(" run 2") == 2 and "resumed at step" in log
    record = json.loads((tmp_path / "run.json").read_text())
    assert record["run_id"] == summary(tmp_path)["run_id"] and len(record["resumed"]) == 1
    finished = run_forked("resume", tmp_path)
    assert finished.returncode == 2 and "there is nothing to resume" in finished.stderr


def test_a_folder_without_a_run_is_refused(tmp_path):
    for folder in (tmp_path, tmp_path / "missing"):
        with pytest.raises(InputError, match="there is nothing to resume in it"):
            resume_folder(folder)


def test_cases_are_resumed_in_their_order(tmp_path, monkeypatch):
    """The command was killed in its first case: the second begins after it."""
    from weavesim.run.simulation import Simulation
    from weavesim.scenes import hemisphere

    class KilledError(Exception):
        pass

    def killed(self, *arguments, **given):
        raise KilledError

    parameters = hemisphere.SCENE.parameters(
        out=tmp_path, mesh_size=0.0195, duration=0.01, frame_count=2, write="summary,tables", accept_unusual=True
    )
    with monkeypatch.context() as patched:
        patched.setattr(Simulation, "_run_frames", killed)
        patched.setattr(ResultFolder, "write", killed)
        with pytest.raises(KilledError):
            hemisphere.SCENE.run(parameters)
    assert [has_job(tmp_path / case) for case in hemisphere.CASES] == [True, True]
    summaries = resume_folder(tmp_path)
    assert [name for name in summaries if name != "outcome"] == list(hemisphere.CASES)
    assert summaries["outcome"] == "finished"
    for case in hemisphere.CASES:
        assert summary(tmp_path / case)["outcome"] == "finished" and not has_job(tmp_path / case)
    with pytest.raises(InputError, match="there is nothing to resume"):
        resume_folder(tmp_path)


def run_without_room(folder, monkeypatch):
    """A short picture frame for whose tables there is no room on the disk; returns its summary."""
    from weavesim.output.writers.tables import TablesWriter
    from weavesim.scenes import picture_frame

    def full(self, results):
        raise OSError(28, "No space left on device")

    parameters = picture_frame.SCENE.parameters(
        out=folder, mesh_size=0.05, frame_count=2, speed=2.0, write="summary,tables"
    )
    with monkeypatch.context() as patched:
        patched.setattr(TablesWriter, "write", full)
        return picture_frame.SCENE.run(parameters)


def test_an_edited_set_up_is_refused_with_what_differs(tmp_path, monkeypatch, caplog):
    run_without_room(tmp_path, monkeypatch)
    path = tmp_path / "setup.json"
    original = path.read_text()
    values = json.loads(original)
    values["solver"].update(time_step=1.0e-6, threads=1)  # threads may be chosen anew
    values["frame_count"] = 7
    path.write_text(json.dumps(values))
    with pytest.raises(InputError, match=r"\(frame_count was 2 and is 7; solver.time_step was None and is 1e-06\)"):
        resume_folder(tmp_path)
    assert json.loads(path.read_text())["frame_count"] == 7 and has_job(tmp_path)
    # one that is damaged, as after a power failure, is told, and nobody's wish is lost with it
    path.write_text("{")
    assert resume_folder(tmp_path)["outcome"] == "finished"
    assert "the run goes on with the set-up that it began with, written anew" in caplog.text
    assert path.read_text() == original


def test_results_that_had_no_room_are_written_by_a_resume(tmp_path, monkeypatch):
    result = run_without_room(tmp_path, monkeypatch)
    assert result["missing"] == ["tables"] and has_job(tmp_path)
    again = resume_folder(tmp_path)
    assert again["missing"] == [] and not has_job(tmp_path) and again["step_count"] == result["step_count"]
    assert (tmp_path / "picture_frame.csv").exists() and again["run_id"] == result["run_id"]
