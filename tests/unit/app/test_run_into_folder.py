"""Runs in processes of their own: whatever happens to them, what was computed is kept, and the exit code tells."""

import json
import os
import signal
import subprocess
import sys

import pytest
from pxr import Usd

from tests.support.kills import tiny_setup
from tests.support.processes import (
    COARSE,
    ENOUGH,
    LIGHT,
    command,
    environment,
    run,
    run_forked,
    slow_run,
    summary,
    wait_for,
)
from weavesim.app.run_into_folder import run_into_folder
from weavesim.output import ResultFolder
from weavesim.run.checkpoint.checkpoints import has_job

SLOW = pytest.mark.slow
SIGNALS = [
    pytest.param(signal.SIGINT, marks=SLOW, id="SIGINT"),
    pytest.param(signal.SIGTERM, id="SIGTERM"),
    pytest.param(signal.SIGHUP, marks=SLOW, id="SIGHUP"),
]
ONLY_SUMMARY = ("--write", "summary")


# The picture frame, whose report says that it is being written, and waits until the test says "go".
REPORTING = """
import sys, time
from pathlib import Path
from weavesim.app import command_line
from weavesim.output.writers.report import ReportWriter

write = ReportWriter.write

def told(self, results):
    (self.folder / "reporting").touch()
    while not (self.folder / "go").exists():
        time.sleep(0.02)
    write(self, results)

ReportWriter.write = told
command_line.main()
"""


def film_of(folder) -> Usd.Stage:
    """As it is now: USD remembers a file that it has opened."""
    stage = Usd.Stage.Open(str(folder / "picture_frame.usdc"))
    stage.Reload()
    return stage


def rows_of(folder) -> list[str]:
    return (folder / "history.csv").read_text().splitlines()[1:]


def is_readable(folder) -> None:
    """Summary, history and film of a run tell of the same frames."""
    numbers, rows, stage = summary(folder), rows_of(folder), film_of(folder)
    assert len(rows) == numbers["frame_count"] == stage.GetEndTimeCode() + 1 >= 2
    assert stage.GetRootLayer().customLayerData["weavesim"]["run_id"] == numbers["run_id"]


@pytest.mark.parametrize("number", SIGNALS)
def test_every_signal_ends_a_run_in_order(tmp_path, number):
    process = slow_run(tmp_path)
    process.send_signal(number)
    out, err = process.communicate(timeout=ENOUGH)
    assert process.returncode == 128 + number, err
    numbers = summary(tmp_path)
    assert (numbers["outcome"], numbers["interrupted_by"]) == ("interrupted", number.name)
    assert numbers["missing"] == [] and "max_shear_angle_deg" in numbers
    assert "results so far are kept" in out and "Traceback" not in err
    is_readable(tmp_path)
    assert not list(tmp_path.glob(".*partial*"))


@SLOW
def test_two_signals_at_once_lose_nothing(tmp_path):
    process = slow_run(tmp_path)
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=ENOUGH)
    assert process.returncode == 130 and summary(tmp_path)["outcome"] == "interrupted"
    is_readable(tmp_path)


def test_a_signal_while_results_are_written_loses_nothing(tmp_path):
    """The report comes last, when the summary tells the end."""
    words = [sys.executable, "-P", "-c", REPORTING, *COARSE, "--frame-count", "4", "--out", tmp_path]
    process = subprocess.Popen(words, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    wait_for((tmp_path / "reporting").exists)
    assert summary(tmp_path)["outcome"] == "finished"
    process.send_signal(signal.SIGINT)
    process.send_signal(signal.SIGTERM)
    (tmp_path / "go").touch()
    out, err = process.communicate(timeout=ENOUGH)
    assert process.returncode == 130 and "Traceback" not in err
    assert (tmp_path / "report.html").exists() and summary(tmp_path)["missing"] == []


def test_a_killed_run_leaves_what_can_be_read(tmp_path):
    process = slow_run(tmp_path)
    # each writer saves at its own pace
    wait_for(lambda: film_of(tmp_path).GetEndTimeCode() >= 1 and len(rows_of(tmp_path)) >= 2)
    process.kill()
    process.communicate()
    assert summary(tmp_path)["outcome"] == "running"
    assert film_of(tmp_path).GetEndTimeCode() >= 1 and len(rows_of(tmp_path)) >= 2
    # the lock died with it, and the next run leaves nothing of it
    again = run_forked(*COARSE, *ONLY_SUMMARY, "--frame-count", "2", "--out", tmp_path, "--overwrite")
    assert again.returncode == 0, again.stderr
    assert {path.name for path in tmp_path.iterdir()} == {
        "summary.json", "run.json", "setup.json", "run.log", ".weavesim.lock",
    }  # fmt: skip
    assert summary(tmp_path)["outcome"] == "finished"


def test_a_second_run_in_the_same_folder_is_refused(tmp_path):
    process = slow_run(tmp_path)
    try:
        first = summary(tmp_path)["run_id"]
        second = run_forked(*COARSE, *ONLY_SUMMARY, "--out", tmp_path, "--overwrite")
        assert second.returncode == 2 and "Traceback" not in second.stderr
        assert f"run {first}" in second.stderr and "is writing to it" in second.stderr
    finally:
        process.kill()
        process.communicate()
    assert summary(tmp_path)["run_id"] == first


@SLOW
def test_old_results_are_kept_unless_the_user_says_otherwise(tmp_path):
    arguments = (*COARSE, *ONLY_SUMMARY, "--frame-count", "2", "--out", tmp_path)
    assert run_forked(*arguments).returncode == 0
    first = summary(tmp_path)["run_id"]
    refused = run_forked(*arguments)
    assert refused.returncode == 2 and "--overwrite" in refused.stderr and summary(tmp_path)["run_id"] == first
    assert run_forked(*arguments, "--overwrite").returncode == 0
    assert summary(tmp_path)["run_id"] != first


@SLOW
def test_the_run_id_is_the_first_line_of_the_log(tmp_path):
    assert run_forked(*COARSE, *ONLY_SUMMARY, "--frame-count", "2", "--out", tmp_path).returncode == 0
    first = (tmp_path / "run.log").read_text().splitlines()[0]
    assert first.endswith(f"run {summary(tmp_path)['run_id']}")
    record = json.loads((tmp_path / "run.json").read_text())
    assert record["options"]["mesh_size"] == 0.05 and "run.log" in record["files"]


@pytest.mark.parametrize(
    "closing",
    [
        "2>&1 | head -1",
        *(pytest.param(one, marks=SLOW) for one in ("2>&-", ">&- 2>&-", "2>/dev/full", ">/dev/full", "| true")),
    ],
)
def test_a_terminal_that_goes_away_costs_no_run(tmp_path, closing):
    line = subprocess.list2cmdline(command(*COARSE, *LIGHT, "--out", tmp_path))
    done = subprocess.run(
        ["bash", "-c", f"{line} {closing}; exit ${{PIPESTATUS[0]}}"], env=environment(), capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert summary(tmp_path)["outcome"] == "finished" and "Traceback" not in done.stderr
    is_readable(tmp_path)


def full_disk():
    """Let no file of a process grow at all."""
    import resource

    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))


@pytest.mark.parametrize("size", [pytest.param(0, marks=SLOW), 4000, pytest.param(60_000, marks=SLOW)])
def test_a_full_disk_is_told(tmp_path, size):
    words = (*COARSE, *LIGHT, "--out", tmp_path)
    # what a fork says goes to a file, which could not grow either
    done = run_forked(*words, largest_file=size) if size else run(*words, preexec_fn=full_disk)
    assert done.returncode == 4, done.stderr
    assert "Not all results could be written" in done.stdout and "Results are in" not in done.stdout
    assert "film could not be written" in done.stderr and "Traceback" not in done.stderr


def test_a_folder_whose_name_is_no_text(tmp_path):
    done = run(*COARSE, "--out", tmp_path / os.fsdecode(b"gr\xf6\xdfe"))
    assert done.returncode == 2 and "not valid UTF-8" in done.stderr and "Traceback" not in done.stderr


@SLOW
@pytest.mark.parametrize("name", ["größe", "with spaces", "部品", "-dash"])
def test_other_names_of_folders(tmp_path, name):
    # how arguments are decoded is part of the start
    start_and_run = run_forked if name.isascii() else run
    done = start_and_run(*COARSE, *LIGHT, "--frame-count", "2", "--out", tmp_path / name)
    assert done.returncode == 0, done.stderr
    is_readable(tmp_path / name)


@pytest.mark.parametrize(
    ("interval", "short", "synced"),
    [
        (0.0, 60.0, []), (600.0, 60.0, []), (1.0e-6, 60.0, ["results", "gone"]),
        # a long run without checkpoints
        (0.0, 0.0, ["results", "gone"]), (600.0, 0.0, ["results", "gone"]),
    ],
)  # fmt: skip
def test_results_are_on_the_disk_before_checkpoints_go(tmp_path, monkeypatch, interval, short, synced):
    """A short run, which has none, is not waited for."""
    done = []

    def sync(self):
        assert bool(list((tmp_path / "checkpoint").glob("0*.bin"))) == (interval == 1.0e-6)
        done.append("results")

    monkeypatch.setattr(ResultFolder, "sync", sync)
    monkeypatch.setattr("weavesim.app.run_into_folder.SHORT_RUN", short)
    folder = ResultFolder(tmp_path, writers=["summary"])
    run_into_folder(tiny_setup(1, short=True), folder, options={}, checkpoint_interval=interval)
    done += ["gone"] if done and not has_job(tmp_path) else []
    assert done == synced and not has_job(tmp_path)
