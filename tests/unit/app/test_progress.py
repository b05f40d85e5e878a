"""Progress bar and log: what they show, when they write, and that they never stop a run."""

import io
import logging
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from tests.support.made_run import made_info
from weavesim.app.progress import ProgressBar, RunLog, clock_text, kinetic_ratio
from weavesim.errors import InputError
from weavesim.process.strokes import Stroke
from weavesim.run.frame import Frame, Outcome, SheetFrame
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import Symmetry
from weavesim.tools.shapes import Plane
from weavesim.tools.tool import Tool

FRAME_COUNT = 40
DURATION = 0.1
LOGGER = logging.getLogger("weavesim")


@pytest.fixture
def info():
    times = np.linspace(0.0, DURATION, 200)
    return made_info(
        Blank.rectangle((0.0, 0.0), (0.235, 0.135), 0.005),
        Symmetry(("x", "y")),
        tools=(Tool("punch", Plane(), Stroke(tuple(times), tuple(0.6 * times))),),
        duration=DURATION,
        thread_counts=(2,),
        notes=("die: 1200 triangles, open sheet",),
        warnings=["die: 3.1 elements [of 5 mm] along 90 degrees"],
    )


def frame(index: int) -> Frame:
    share = index / FRAME_COUNT
    return Frame(
        index=index,
        step_count=100 * index,
        time=share * DURATION,
        stroke=share * 0.06,
        sheets=(SheetFrame("sheet", np.zeros((4, 3)), np.zeros((4, 3)), {}, {}),),
        tool_displacement=np.array([-share * 0.06]),
        tool_reaction=np.array([[0.0, 0.0, -30.0 * share]]),
        energies={"kinetic": 0.02, "internal": 2.0, "shear": 1.5},
    )


def play(observer, info, outcome=Outcome.FINISHED) -> None:
    observer.start(info)
    for index in range(FRAME_COUNT + 1):
        observer.frame(frame(index))
    observer.finish(outcome)


def show(terminal: bool, info, outcome=Outcome.FINISHED) -> str:
    out = io.StringIO()
    play(ProgressBar(Console(file=out, force_terminal=terminal, width=120)), info, outcome)
    return out.getvalue()


@pytest.mark.parametrize("terminal", [False, True])
def test_a_last_step_beyond_the_end_is_no_more_than_all_of_it(info, terminal):
    out = io.StringIO()
    bar = ProgressBar(Console(file=out, force_terminal=terminal, width=120))
    bar.start(info)
    bar.frame(frame(0))
    bar.frame(replace(frame(FRAME_COUNT), time=1.02 * DURATION))
    bar.finish(Outcome.FINISHED)
    assert "100%" in out.getvalue() and "102%" not in out.getvalue()


def test_kinetic_ratio():
    assert kinetic_ratio(frame(1).energies) == pytest.approx(0.01)
    assert kinetic_ratio({"kinetic": 1.0, "internal": 0.0}) is None


@pytest.mark.parametrize(("seconds", "text"), [(0.2, "0:00"), (59.7, "1:00"), (83.0, "1:23"), (3725.0, "1:02:05")])
def test_clock_text(seconds, text):
    assert clock_text(seconds) == text


def test_plain_output_is_a_line_for_each_tenth(info):
    lines = show(False, info).splitlines()
    assert len(lines) == 2 + 11 + 1
    assert lines[0] == "double dome: warning: die: 3.1 elements [of 5 mm] along 90 degrees"
    assert lines[1] == "double dome: 1269 elements, 1344 nodes"
    assert "50%" in lines[7] and "stroke 30.0 mm" in lines[7] and "left" in lines[7] and "1.00%" in lines[7]
    assert lines[-1].startswith("double dome: finished after")


def test_terminal_shows_a_bar_with_stroke_and_energies(info):
    text = show(True, info)
    assert "100%" in text and "stroke 60.0 mm" in text and "kinetic/internal 1.00%" in text


def test_outcome_is_named(info):
    assert "interrupted after" in show(False, info, Outcome.INTERRUPTED)


def test_warnings_are_shown_once_and_only_during_the_run(info):
    out = io.StringIO()
    bar = ProgressBar(Console(file=out, width=120))
    handlers = list(LOGGER.handlers)
    bar.start(info)
    LOGGER.warning("five elements per radius")
    bar.finish(Outcome.FINISHED)
    assert out.getvalue().count("five elements per radius") == 1
    assert LOGGER.handlers == handlers


def test_log_keeps_set_up_frames_warnings_and_outcome(info, tmp_path):
    log = RunLog(tmp_path)
    LOGGER.warning("told before the start")
    play(log, info)
    text = log.path.read_text()
    for part in (
        "told before the start",
        "double_dome: float32 on cpu with 2 threads",
        "glass",
        "x, y",
        "source of its values: Aridhi",
        "finished after",
    ):
        assert part in text
    lines = [line for line in text.splitlines() if re.search(r"frame \d+: time", line)]
    assert len(lines) == FRAME_COUNT + 1 and max(map(len, lines)) < 200
    # four quarters
    assert "stroke 60.00 mm; punch 120 N on the whole part; kinetic/internal 1.00%" in lines[-1]
    # values are words
    assert "tool punch: plane" in text and "stroke, times 200 values, 0 s to 0.1 s" in text
    assert not re.search(r"\w+\(|\w=", text) and max(map(len, text.splitlines())) < 450


def test_log_is_readable_after_an_interrupt(info, tmp_path):
    log = RunLog(tmp_path)
    log.start(info)
    log.frame(frame(0))
    assert "frame 0" in log.path.read_text()
    log.finish(Outcome.INTERRUPTED)
    assert "interrupted" in log.path.read_text()


def test_log_tells_why_a_run_had_to_stop(info, tmp_path):
    log = RunLog(tmp_path)
    log.start(info)
    LOGGER.info("element 7 is not finite")
    log.finish(Outcome.NOT_FINITE)
    assert re.search(r"element 7 is not finite\n.*not finite after", log.path.read_text())


def test_older_log_is_kept_until_the_run_starts(info, tmp_path):
    (tmp_path / "run.log").write_text("older")
    log = RunLog(tmp_path)
    log.close()
    assert log.path.read_text() == "older"
    play(RunLog(tmp_path), info)
    assert "older" not in log.path.read_text()


def test_logger_is_left_as_it_was(info, tmp_path):
    before = LOGGER.level, list(LOGGER.handlers)
    play(RunLog(tmp_path), info)
    assert (LOGGER.level, LOGGER.handlers) == before


def test_log_in_a_missing_folder_is_refused(info, tmp_path):
    log = RunLog(tmp_path / "missing")
    with pytest.raises(InputError, match="cannot be written"):
        log.start(info)
    log.close()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no device that is always full")
def test_full_disk_is_warned_about_once_and_the_run_goes_on(info, tmp_path, caplog):
    (tmp_path / "run.log").symlink_to("/dev/full")
    with caplog.at_level(logging.WARNING, "weavesim"):
        play(RunLog(tmp_path), info)
    assert [record.levelname for record in caplog.records].count("WARNING") == 1
