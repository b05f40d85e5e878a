"""The USD film: what it holds, that USD's own validators accept it, and that it survives a run cut short."""

import dataclasses
import shutil

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdShade

from tests.support.films import SHEETS_OF_STACK, chosen, complaints, moved, write_film
from weavesim.errors import InputError
from weavesim.output import Film
from weavesim.output.film.film import prim_names
from weavesim.run.frame import Outcome
from weavesim.sheet.symmetry import Symmetry


def test_validators_accept_the_film(stage):
    assert complaints(stage) == []


def test_validators_do_complain(stage):
    stage.ClearDefaultPrim()
    stage.GetPrimAtPath("/World/sheets/sheet").RemoveAPI(UsdShade.MaterialBindingAPI)
    assert len(complaints(stage)) >= 2


def test_stage_metrics_and_time(stage, coarse_run):
    assert UsdGeom.GetStageUpAxis(stage) == "Z"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1.0
    assert stage.GetDefaultPrim().GetPath() == "/World"
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0.0, len(coarse_run[1]) - 1.0)
    assert stage.GetTimeCodesPerSecond() == 24.0


def test_every_frame_holds_the_points_of_the_run(stage, coarse_run):
    info, frames = coarse_run
    mesh = UsdGeom.Mesh.Get(stage, "/World/sheets/sheet")
    assert mesh.GetSubdivisionSchemeAttr().Get() == "none"
    assert mesh.GetDoubleSidedAttr().Get() is True
    assert np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 4).tolist() == info.sheet.blank.quads.tolist()
    assert mesh.GetPointsAttr().GetTimeSamples() == [float(frame.index) for frame in frames]
    for frame in frames:
        points = np.array(mesh.GetPointsAttr().Get(frame.index))
        assert np.array_equal(points, frame.position.astype(np.float32))
        extent = np.array(mesh.GetExtentAttr().Get(frame.index))
        assert np.array_equal(extent, [points.min(axis=0), points.max(axis=0)])


def test_the_clock_of_the_run_is_in_the_film(stage, coarse_run):
    world = stage.GetPrimAtPath("/World")
    for frame in coarse_run[1]:
        assert world.GetAttribute("weavesim:time").Get(frame.index) == frame.time
        assert world.GetAttribute("weavesim:stroke").Get(frame.index) == frame.stroke


def test_an_interrupted_film_ends_where_the_run_did(tmp_path, coarse_run):
    path = write_film(tmp_path / "cut.usdc", coarse_run, frame_count=4)
    stage = Usd.Stage.Open(str(path))
    assert stage.GetEndTimeCode() == 3.0
    assert complaints(stage) == []
    assert [file.name for file in tmp_path.iterdir()] == ["cut.usdc"]


def test_flushing_while_it_runs_loses_nothing(tmp_path, coarse_run, monkeypatch, film_path):
    monkeypatch.setattr("weavesim.output.film.film._FRAMES_PER_FLUSH", 3)
    stage = Usd.Stage.Open(str(write_film(tmp_path / "flushed.usdc", coarse_run)))
    flushed = UsdGeom.Mesh.Get(stage, "/World/sheets/sheet").GetPointsAttr()
    for frame in coarse_run[1]:
        assert np.array_equal(np.array(flushed.Get(frame.index)), frame.position.astype(np.float32))


def test_an_older_film_stays_until_the_new_one_has_a_frame(tmp_path, coarse_run):
    path = tmp_path / "film.usda"
    path.write_text("older")
    film = Film(path)
    film.start(coarse_run[0])
    assert path.read_text() == "older"
    film.frame(coarse_run[1][0])
    assert path.read_text().startswith("#usda")
    film.finish(Outcome.INTERRUPTED)
    assert path.read_text().startswith("#usda")


def test_a_film_does_not_depend_on_when_it_was_saved(tmp_path, coarse_run, monkeypatch):
    one = write_film(tmp_path / "one.usdc", coarse_run)
    monkeypatch.setattr("weavesim.output.film.film.Pace.due", lambda pace: True)
    other = write_film(tmp_path / "other.usdc", coarse_run)
    assert one.read_bytes() == other.read_bytes()
    assert {path.name for path in tmp_path.iterdir()} == {"one.usdc", "other.usdc"}


def test_a_save_without_room_costs_no_film(tmp_path, coarse_run, monkeypatch):
    def full(*arguments):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("shutil.copyfile", full)
    monkeypatch.setattr("weavesim.output.film.film.Film._publish", full)
    path = write_film(tmp_path / "film.usdc", coarse_run)
    assert Usd.Stage.Open(str(path)).GetEndTimeCode() == len(coarse_run[1]) - 1


def test_a_killed_run_leaves_a_film(tmp_path, coarse_run, monkeypatch):
    """Every save is a whole film under its own name, with camera and light, in the middle of the run."""
    info, frames = coarse_run
    due = iter([True, True, True, False, True, False])
    monkeypatch.setattr("weavesim.output.film.film.Pace.due", lambda pace: next(due))
    film = Film(tmp_path / "film.usdc")
    film.start(info)
    for index, frame in enumerate(frames[:6]):
        film.frame(frame)
        stage = Usd.Stage.Open(str(shutil.copy(film.path, tmp_path / f"copy_{index}.usdc")))
        assert stage.GetEndTimeCode() == {3: 2, 5: 4}.get(index, index)
        assert stage.GetPrimAtPath("/World/camera") and stage.GetPrimAtPath("/World/lights/key")
        assert stage.GetRootLayer().customLayerData["weavesim"]["run_id"] == info.run_id


def test_a_full_blank_has_no_copies(tmp_path, coarse_run):
    info, frames = coarse_run
    whole = dataclasses.replace(info, sheets=(dataclasses.replace(info.sheet, symmetry=Symmetry()),))
    stage = Usd.Stage.Open(str(write_film(tmp_path / "full.usdc", (whole, frames))))
    assert not [prim for prim in stage.Traverse() if "mirrored" in prim.GetName()]


def test_unknown_endings_are_refused():
    with pytest.raises(InputError, match="must end in .usdc"):
        Film("film.mp4")


def test_names_of_prims_are_valid_and_differ():
    assert prim_names(["ply 1", "ply-1", "ply_1", "2nd"]) == ["ply_1", "ply_1_2", "ply_1_3", "_nd"]


def test_validators_accept_every_view_of_several_sheets(stack_path):
    for view in ("stacked", "exploded"):
        for colours in ("shear_angle", "sheets"):
            assert complaints(chosen(stack_path, view=view, colours=colours)) == []


def test_several_sheets_are_seen_as_they_are_unless_they_are_moved_apart(stack_path, stack):
    info, frames = stack
    stage = Usd.Stage.Open(str(stack_path))
    for path in (*SHEETS_OF_STACK, "/World/sheets/upper_mirrored_x"):
        assert moved(stage, path) == pytest.approx(0.0)
    apart = chosen(stack_path, view="exploded")
    points = np.concatenate([sheet.position for frame in frames for sheet in frame.sheets])
    gap = moved(apart, SHEETS_OF_STACK[1])[2]  # both are at one height: the first counts as the lower one
    assert gap == pytest.approx(max(0.6 * np.ptp(points[:, 2]), 0.2 * np.abs(points[:, :2]).max()))
    assert moved(apart, SHEETS_OF_STACK[0]) == pytest.approx(0.0)
    # mirrored copies go with their sheet, and are mirrored still
    for name in ("_mirrored_x", "_mirrored_y", "_mirrored_x_y"):
        assert moved(apart, f"{SHEETS_OF_STACK[0]}{name}") == pytest.approx(0.0)
        scale = UsdGeom.Xformable(apart.GetPrimAtPath(f"{SHEETS_OF_STACK[0]}{name}")).ComputeLocalToWorldTransform(0.0)
        assert abs(scale.GetDeterminant()) == pytest.approx(1.0) and scale != Gf.Matrix4d(1.0)
    # tools move out of the way, and still with their strokes
    last = frames[-1]
    for k, (name, away) in enumerate(zip(info.tool_names, (2.0 * gap, -gap, 2.0 * gap) * 2, strict=True)):
        stroke = last.tool_displacement[k] * np.array(info.tools[k].axis)
        assert moved(apart, f"/World/tools/{name}", last.index) == pytest.approx(stroke + (0.0, 0.0, away)), name


def test_one_sheet_has_nothing_to_choose(stage):
    assert stage.GetPrimAtPath("/World").GetVariantSets().GetNames() == []
    assert not stage.GetPrimAtPath("/World/camera_exploded")
