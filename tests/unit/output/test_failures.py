"""Every writer and every number fails alone: the others are there, and what is missing is named."""

import json
from contextlib import nullcontext

import numpy as np
import pytest

from tests.support.processes import summary as summary_of
from weavesim.errors import InputError
from weavesim.measures import findings as findings_module
from weavesim.measures.findings import Finding
from weavesim.measures.units import PURE
from weavesim.output import ResultFolder, Writer, known_writers
from weavesim.output import results as results_module
from weavesim.output import writer as writer_module
from weavesim.output.curves import Curves
from weavesim.run.checkpoint.checkpoints import FOLDER_NAME, has_job
from weavesim.run.frame import Outcome
from weavesim.scenes import picture_frame

ERRORS = [
    KeyError("node 7"), ZeroDivisionError("division by zero"), InputError("too thick"), OSError(28, "No space left"),
    MemoryError(), np.linalg.LinAlgError("singular"),
]  # fmt: skip
OF_THE_OTHERS = ("history.csv", "draw_in.csv", "report.html", "summary.json", "run.json")


@pytest.fixture(autouse=True)
def _writers_forgotten():
    before = dict(known_writers())
    yield
    writer_module._known.clear()
    writer_module._known.update(before)


def play(folder, run):
    info, frames = run
    folder.start(info)
    for frame in frames[:3]:
        folder.frame(frame)
    folder.finish(Outcome.FINISHED)
    return folder.write({})


@pytest.mark.parametrize("stage", ["start", "frame", "finish", "begin", "write", "conclude"])
@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_a_writer_that_fails_in_any_way_costs_only_its_own_file(tmp_path, coarse_run, stage, error):
    def fail(self, *arguments):
        raise error

    type("Mine", (Writer,), {"name": "mine", "title": "my file", stage: fail})
    summary = play(ResultFolder(tmp_path, writers=["mine", "tables", "report", "summary"]), coarse_run)
    assert summary["missing"] == ["my file"] and len(summary["warnings"]) == 1
    assert all((tmp_path / name).stat().st_size > 0 for name in OF_THE_OTHERS)
    on_disk = summary_of(tmp_path)
    assert on_disk["outcome"] == "finished" and on_disk["missing"] == ["my file"]
    assert json.loads((tmp_path / "run.json").read_text())["missing"] == ["my file"]


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_a_number_that_fails_costs_only_itself(tmp_path, coarse_run, monkeypatch, error):
    def fail(sheet):
        raise error

    mine = Finding("mine", PURE, "fails", fail)
    monkeypatch.setattr(results_module, "SHEET_FINDINGS", (mine, *findings_module.SHEET_FINDINGS))
    summary = play(ResultFolder(tmp_path, writers=["tables", "report", "summary"]), coarse_run)
    assert summary["missing"] == ["mine"] and "mine" not in summary and summary["max_shear_angle_deg"] > 0.0
    assert all((tmp_path / name).exists() for name in OF_THE_OTHERS)


@pytest.mark.parametrize("at", [0, 2])
def test_a_curve_that_fails_keeps_its_rows(tmp_path, coarse_run, at):
    def measure(frame):
        if frame.index >= at:
            raise KeyError("zone")
        return {"time_s": frame.time}

    summary = play(
        ResultFolder(tmp_path, curves=Curves("mine", measure, []), writers=["tables", "summary"]), coarse_run
    )
    assert summary["missing"] == ["mine.csv"] and "KeyError: 'zone'" in summary["warnings"][0]
    assert (tmp_path / "history.csv").exists() and summary["outcome"] == "finished"
    if at:
        assert len((tmp_path / "mine.csv").read_text().splitlines()) == 1 + at


def test_a_file_that_vanishes_is_missed(tmp_path, coarse_run):
    info, frames = coarse_run
    folder = ResultFolder(tmp_path, writers=["paraview", "summary"])
    folder.start(info)
    folder.frame(frames[0])
    (tmp_path / "paraview" / "frame_0000_sheet.vtu").write_bytes(b"")
    folder.finish(Outcome.FINISHED)
    summary = folder.write({})
    assert summary["missing"] == ["paraview/frame_0000_sheet.vtu"]
    assert "is missing or empty" in summary["warnings"][0]


def test_the_summary_comes_first(tmp_path, coarse_run):
    """When the first other result is written, the summary is already there."""
    seen = []

    class Mine(Writer):
        name = "mine"
        rank = 0

        def write(self, results):
            seen.append(summary_of(tmp_path))

    summary = play(ResultFolder(tmp_path, writers=["mine", "summary"]), coarse_run)
    assert seen == [summary]


@pytest.mark.parametrize("error", [None, KeyboardInterrupt])
def test_what_a_writer_has_begun_ends_when_all_have_written(tmp_path, coarse_run, error):
    """Each begins when the summary is there and before any writes; nothing goes on after an interruption either."""
    seen = []

    class Mine(Writer):
        name = "mine"
        rank = 7

        def begin(self, results, meanwhile):
            seen.append((tmp_path / "draw_in.csv").exists())
            assert summary_of(tmp_path)["outcome"] == "finished"
            meanwhile.callback(seen.append, "ended")

        def write(self, results):
            seen.append((tmp_path / "draw_in.csv").exists())
            if error:
                raise error

    with pytest.raises(error) if error else nullcontext():
        play(ResultFolder(tmp_path, writers=["mine", "tables", "summary"]), coarse_run)
    assert seen == [False, True, "ended"]


def scene_that(**given):
    """The coarse picture frame, but for what is given."""
    return picture_frame.SCENE.__class__(
        name="picture-frame", help="", parameters=picture_frame.PictureFrameParameters,
        make=picture_frame.picture_frame, **given,
    )  # fmt: skip


def options(folder, **given):
    return picture_frame.PictureFrameParameters(
        mesh_size=0.1, out=folder, frame_count=2, write="summary", threads=1, **given
    )


@pytest.mark.parametrize(
    "error", [KeyError("a"), ZeroDivisionError(), InputError("too thick")], ids=lambda e: type(e).__name__
)
def test_findings_of_a_scene_that_fail_at_the_end_cost_only_themselves(tmp_path, error):
    def findings(parameters, simulation, wanted):
        if simulation.frame.index > 0:
            raise error
        return {"mine": 1}

    summary = scene_that(findings=findings).run(options(tmp_path))
    assert summary["outcome"] == "finished" and summary["missing"] == ["the findings of the scene"]
    assert summary_of(tmp_path) == summary and "max_shear_angle_deg" in summary


def test_findings_that_cannot_be_are_refused_before_the_run(tmp_path):
    def findings(parameters, simulation, wanted):
        raise InputError("the clearance is too small")

    with pytest.raises(InputError, match="the clearance is too small"):
        scene_that(findings=findings).run(options(tmp_path))
    assert not (tmp_path / "summary.json").exists()


@pytest.mark.parametrize("points", [[[1.0, 0.0]], [[0.0, 0.0], [0.2, 0.2]], [[np.nan, 0.0]]])
def test_points_outside_the_blank_are_refused_before_the_run(tmp_path, points, monkeypatch):
    monkeypatch.setattr("weavesim.run.start.Model", None)

    def wanted(parameters, setup):
        return results_module.Wanted(points=np.array(points))

    with pytest.raises(InputError, match="point"):
        scene_that(wanted=wanted).run(options(tmp_path))
    assert not (tmp_path / "summary.json").exists()


def test_old_results_survive_what_is_refused(tmp_path):
    first = scene_that().run(options(tmp_path))

    def findings(parameters, simulation, wanted):
        raise InputError("too thick")

    with pytest.raises(InputError):
        scene_that(findings=findings).run(options(tmp_path, overwrite=True))
    assert summary_of(tmp_path) == first


def test_cases_of_two_runs_do_not_mix(tmp_path):
    """A run that ends in its first case leaves nothing of older runs in the folders of the others."""
    failing = False

    def findings(parameters, simulation, wanted):
        if failing and simulation.frame.index > 0:
            raise KeyboardInterrupt
        return {}

    scene = picture_frame.SCENE.__class__(
        name="picture-frame", help="", parameters=picture_frame.PictureFrameParameters,
        make=lambda parameters, case: picture_frame.picture_frame(parameters), findings=findings,
        cases=lambda parameters: ("one", "two"),
    )  # fmt: skip
    first = scene.run(options(tmp_path))
    assert summary_of(tmp_path / "two")["run_id"] == first["two"]["run_id"] != first["one"]["run_id"]
    failing = True
    with pytest.raises(KeyboardInterrupt):
        scene.run(options(tmp_path, overwrite=True))
    assert summary_of(tmp_path / "one")["run_id"] != first["one"]["run_id"]
    # but the job of this command, which can be resumed
    assert {path.name for path in (tmp_path / "two").iterdir()} == {".weavesim.lock", FOLDER_NAME}
    assert has_job(tmp_path / "one") and has_job(tmp_path / "two")
