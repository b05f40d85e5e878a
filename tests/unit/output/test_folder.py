"""The folder as a whole: what is in it after a run, after a run cut short, and when the disk refuses."""

import base64
import csv
import dataclasses
import errno
import html.parser
import json
import logging
import os
import re
import shutil

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.measures.angles import ten_points
from weavesim.output import ParaViewSeries, Report, ResultFolder, write_report, write_summary
from weavesim.output.report.page import shown
from weavesim.run.frame import Outcome

POINTS = ten_points(0.235, 0.135)


def run_into(folder, run, outcome=Outcome.FINISHED):
    info, frames = run
    folder.start(info)
    for frame in frames:
        folder.frame(frame)
    folder.finish(outcome)


class Page(html.parser.HTMLParser):
    """Collects text and addresses, and checks that tags close."""

    def __init__(self, text):
        super().__init__()
        self.open, self.addresses, self.text = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.addresses += [value for name, value in attrs if name in ("src", "href")]
        if tag not in ("meta", "img", "link"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


@pytest.fixture(scope="module")
def finished(tmp_path_factory, coarse_run):
    path = tmp_path_factory.mktemp("results") / "new" / "double_dome"
    folder = ResultFolder(path, points=POINTS)
    run_into(folder, coarse_run)
    summary = folder.write(
        {"wall_time_s": 12.5, "energy_balance_error": float("nan"), "warnings": ["coarse <mesh>"]},
        setup={"punch_speed": "1 m/s"},
    )
    return path, summary


def test_everything_is_there_and_nothing_else(finished):
    path, _ = finished
    assert {file.name for file in path.iterdir()} == {
        "double_dome.usdc", "paraview", "pictures", "shear_angle.csv", "draw_in.csv", "history.csv", "report.html",
        "progress.json", "summary.json", "run.json", "results.h5", ".weavesim.lock",
    }  # fmt: skip
    assert {file.name for file in (path / "pictures").iterdir()} == {
        "formed_sheet.png", "point_angles.png", "draw_in.png", "sections.png", "tool_forces.png", "energies.png",
    }  # fmt: skip


def test_summary_agrees_with_the_tables(finished):
    path, returned = finished
    summary = json.loads((path / "summary.json").read_text())
    assert summary == returned
    assert summary["energy_balance_error"] is None
    assert summary["wall_time_s"] == 12.5
    with open(path / "shear_angle.csv", newline="") as file:
        angles = [float(row["shear_angle_deg"]) for row in csv.DictReader(file)]
    assert summary["shear_angle_points_deg"] == pytest.approx(angles)
    with open(path / "draw_in.csv", newline="") as file:
        border = [float(row["draw_in_mm"]) for row in csv.DictReader(file)]
    assert summary["draw_in_long_axis_mm"] == pytest.approx(border[0])
    assert summary["draw_in_short_axis_mm"] == pytest.approx(border[-1])
    assert summary["min_stretch"] < summary["max_stretch"] == pytest.approx(1.004)
    assert summary["integrated_yarn_stretch_short_axis_mm"] == pytest.approx(0.002 * 135.0)
    assert summary["outcome"] == "finished"


def test_summary_tells_thickness_and_fibres_of_the_last_frame(finished, coarse_run):
    _, summary = finished
    fields = coarse_run[1][-1].fields
    assert summary["min_thickness_mm"] == pytest.approx(1e3 * fields["thickness"].min())
    assert 1.2 < summary["max_thickness_mm"] == pytest.approx(1e3 * fields["thickness"].max())
    assert summary["max_fibre_volume_fraction"] == pytest.approx(fields["fibre_volume_fraction"].max())
    assert summary["min_fibre_volume_fraction"] < summary["max_fibre_volume_fraction"]


def test_a_scene_may_leave_the_draw_in_out(tmp_path, coarse_run):
    folder = ResultFolder(tmp_path, draw_in=False, writers=["tables", "pictures", "report", "summary"])
    run_into(folder, coarse_run)
    summary = folder.write({})
    assert not [name for name in summary if "draw_in" in name or "integrated_yarn_stretch" in name]
    names = {file.name for file in tmp_path.rglob("*")}
    assert "sections.png" in names and not [name for name in names if "draw_in" in name]
    assert "draw-in" not in (tmp_path / "report.html").read_text().lower()


def test_report_is_whole_by_itself(finished):
    path, summary = finished
    page = Page((path / "report.html").read_text(encoding="utf-8"))
    assert page.open == []
    pictures = [address for address in page.addresses if not address.startswith("#") and address != "data:,"]
    # forces and energies are charts
    assert len(pictures) == 4
    for address in pictures:
        kind, data = address.split(",", 1)
        assert kind == "data:image/png;base64"
        assert base64.b64decode(data).startswith(b"\x89PNG")
    text = " ".join(page.text)
    assert "coarse <mesh>" in text and "1 m/s" in text and "glass/polypropylene plain weave" in text
    assert f"{summary['max_shear_angle_deg']:.4g}°" in text
    assert "did not reach its end" not in text
    own = re.sub(r"<script>.*?</script>", "", (path / "report.html").read_text(encoding="utf-8"), flags=re.DOTALL)
    assert not re.search(r"https?://|@import", own)


def test_an_interrupted_run_says_so(tmp_path, coarse_run):
    folder = ResultFolder(tmp_path, writers=["report", "summary"])
    run_into(folder, (coarse_run[0], coarse_run[1][:3]), Outcome.INTERRUPTED)
    summary = folder.write({})
    assert summary["outcome"] == "interrupted" and summary["frame_count"] == 3
    assert "did not reach its end (interrupted)" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert not (tmp_path / "shear_angle.csv").exists()


def test_nothing_is_touched_before_the_run_starts(tmp_path):
    old = tmp_path / "summary.json"
    old.write_text("old")
    folder = ResultFolder(tmp_path, overwrite=True)
    assert [file.name for file in tmp_path.iterdir()] == ["summary.json"] and old.read_text() == "old"
    with pytest.raises(InputError, match="no frame to write"):
        folder.write({})


def test_a_folder_that_cannot_be_written_to(tmp_path):
    (tmp_path / "file").write_text("")
    for path in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(InputError, match="cannot be written to") as caught:
            ResultFolder(path)
        assert str(path) in str(caught.value)


@pytest.mark.parametrize("name", [b"gr\xf6\xdfe", b"\xff", b"a\xe9/b", b"out/\x80"])
def test_a_folder_whose_name_is_no_text(tmp_path, name):
    with pytest.raises(InputError, match="not valid UTF-8") as caught:
        ResultFolder(tmp_path / os.fsdecode(name))
    assert str(caught.value).encode() and list(tmp_path.iterdir()) == []


def test_folders_that_cannot_be(tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "dangling").symlink_to("nowhere")
    for name, message in (
        ("file", "it is a file"), ("dangling", "a link to nowhere, which does not exist"), ("x" * 300, "too long"),
        ("/proc/nothing", "cannot be written to"), ("a\0b", "null"), ("file/below", "cannot be written to"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=message):
            ResultFolder(tmp_path / name)


def test_a_relative_folder_stays_where_it_was(tmp_path, coarse_run, monkeypatch):
    (tmp_path / "else").mkdir()
    monkeypatch.chdir(tmp_path)
    folder, (info, frames) = ResultFolder("out", writers=["tables", "summary"]), coarse_run
    folder.start(info)
    monkeypatch.chdir(tmp_path / "else")
    for frame in frames:
        folder.frame(frame)
    folder.finish(Outcome.FINISHED)
    assert folder.write({})["missing"] == [] and list((tmp_path / "else").iterdir()) == []
    assert {"summary.json", "history.csv", "run.json"} <= {path.name for path in (tmp_path / "out").iterdir()}


@pytest.mark.parametrize("name", ["", "  "])
def test_a_folder_needs_a_name(name):
    with pytest.raises(InputError, match="current folder"):
        ResultFolder(name)


@pytest.mark.parametrize("name", ["../../evil", "/tmp/evil", "..", "a/b", "a\nb", "nul", "x" * 300, "gr\udcf6\udcdfe"])
def test_a_run_cannot_write_outside_its_folder(tmp_path, coarse_run, name):
    """Whoever makes the information on a run: set-ups refuse such names already."""
    info, _ = coarse_run
    with pytest.raises(InputError, match="name of the run = "):
        ResultFolder(tmp_path / "out").start(dataclasses.replace(info, name=name))
    assert [path.name for path in tmp_path.iterdir()] == ["out"] and list((tmp_path / "out").iterdir()) == []


def test_measured_angles_need_their_points(tmp_path):
    measured = (np.array([11]), np.array([20.0]))
    with pytest.raises(InputError, match="point 11 is given, but the run has 10 points"):
        ResultFolder(tmp_path, points=POINTS, measured_angles=measured)
    with pytest.raises(InputError, match="has 0 points"):
        ResultFolder(tmp_path, measured_angles=measured)


def test_a_full_disk_costs_the_file_but_not_the_run(tmp_path, coarse_run, monkeypatch, caplog):
    calls = []

    def no_space(*arguments):
        calls.append(arguments)
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("weavesim.output.paraview.series.ParaViewSeries._write", no_space)
    monkeypatch.setattr("weavesim.output.history.History.write", no_space)
    folder = ResultFolder(tmp_path)
    with caplog.at_level(logging.WARNING, "weavesim"):
        run_into(folder, coarse_run)
        summary = folder.write({})
    assert sum(isinstance(first, ParaViewSeries) for first, *_ in calls) == 1  # given up at the first failure
    tried_again, *given_up = sorted((record.message for record in caplog.records), key=lambda text: "given up" in text)
    assert "history.csv could not be saved during the run, and is tried again at its end" in tried_again
    assert summary["missing"] == ["ParaView series", "history.csv"]
    assert (
        given_up
        == summary["warnings"]
        == [
            f"{what} could not be written and is given up: No space left on device"
            for what in ("ParaView series", "history.csv")
        ]
    )
    assert (tmp_path / "double_dome.usdc").exists()
    assert "No space left on device" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_folder_that_vanishes_during_the_run(tmp_path, coarse_run, monkeypatch):
    monkeypatch.setattr("weavesim.output.film.film._FRAMES_PER_FLUSH", 2)
    info, frames = coarse_run
    folder = ResultFolder(tmp_path / "gone")
    folder.start(info)
    shutil.rmtree(tmp_path / "gone")
    for frame in frames:
        folder.frame(frame)
    folder.finish(Outcome.FINISHED)
    summary = folder.write({})
    assert summary["draw_in_long_axis_mm"] > 20.0
    assert any("film could not be written" in warning for warning in summary["warnings"])
    assert any("ParaView series could not be written" in warning for warning in summary["warnings"])
    assert not any("\n" in warning or "pxr" in warning for warning in summary["warnings"])


def test_summary_is_plain_json(tmp_path):
    path = tmp_path / "summary.json"
    write_summary(path, {
        "a": np.float32(1.5), "b": np.arange(3), "c": [float("inf"), np.nan], "d": {"e": np.bool_(True), "f": None},
        "g": tmp_path, "h": np.int64(7),
    })  # fmt: skip
    assert json.loads(path.read_text()) == {
        "a": 1.5, "b": [0, 1, 2], "c": [None, None], "d": {"e": True, "f": None}, "g": str(tmp_path), "h": 7,
    }  # fmt: skip
    assert [file.name for file in tmp_path.iterdir()] == ["summary.json"]


def test_a_report_that_fails_leaves_the_old_one(tmp_path, monkeypatch):
    path = tmp_path / "report.html"
    path.write_text("old")

    def full(*arguments):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(OSError, match="No space"):
        write_report(path, Report("title", "subtitle"))
    assert path.read_text() == "old" and [file.name for file in tmp_path.iterdir()] == ["report.html"]


def test_values_as_a_person_reads_them():
    for value, text in (
        (None, "–"),
        (float("nan"), "–"),
        (True, "yes"),
        (3, "3"),
        (1234567, "1\u202f234\u202f567"),
        (0.000123456, "0.0001235"),
        (45678.9, "45\u202f679"),
        ([1.0, 2], "1, 2"),
        ({"a_b": 1}, "a b 1"),
        (list(range(40)), "40 values from 0 to 39"),
    ):
        assert shown(value) == text
