"""The page of a run: numbers that come back, texts that stay texts, and what it says first."""

import base64
import json
import re
import zlib
from dataclasses import replace

import numpy as np
import pytest

from tests.support.made_run import made_info, made_run
from weavesim.measures.defects.judgement import Region
from weavesim.output import ResultFolder
from weavesim.output.run_page import recorder as recorder_module
from weavesim.output.run_page.judged_part import region_of_page, verdict_of
from weavesim.output.run_page.packing import COARSE_CODE, packed_series, rounded
from weavesim.output.run_page.provenance import provenance_rows
from weavesim.output.run_page.recorder import FrameRecorder
from weavesim.output.run_page.scene import scene_of
from weavesim.output.run_page.setup_rows import setup_tables
from weavesim.output.run_page.shown_fields import JUDGED_FIELDS
from weavesim.output.run_page.values import Row, number, rows_of, text_of, words
from weavesim.output.run_page.writing import in_script
from weavesim.process.strokes import Stroke
from weavesim.run.fields import FIELDS
from weavesim.run.frame import Outcome


def unpacked(series, frame_count):
    """What the page makes of a packed series, (frame_count, n component_count)."""
    low, step = np.array(series["low"]), np.array(series["step"])
    planes = np.frombuffer(zlib.decompress(base64.b64decode(series["data"])), np.uint8).reshape(2, -1)
    change = (planes[0].astype(np.uint16) + (planes[1].astype(np.uint16) << 8)).reshape(frame_count, -1)
    change = (change >> 1) ^ (0 - (change & 1))
    code = np.cumsum(change, axis=0, dtype=np.uint16).reshape(frame_count, -1, len(low))
    values = np.where(code == 65535, np.nan, low + step * code)
    values = 10.0**values if series["logarithmic"] else values
    return values.reshape(frame_count, -1)


# ---------------------------------------------------------------------------------------------------------- numbers


def test_a_series_comes_back_within_half_a_step():
    rng = np.random.default_rng(1)
    values = rng.normal(size=(5, 40, 3)) * (1.0, 100.0, 1.0e-3) + (0.0, 5.0, 1.0)
    series = packed_series(values)
    back = unpacked(series, 5).reshape(values.shape)
    assert np.abs(back - values).max(axis=(0, 1)) == pytest.approx(0.5 * np.array(series["step"]), rel=0.3)
    assert np.array(series["step"]) == pytest.approx(np.ptp(values, axis=(0, 1)) / 65534)


def test_fewer_steps_are_still_half_a_step_off():
    values = np.random.default_rng(2).normal(size=(4, 60))
    series = packed_series(values, largest_code=COARSE_CODE)
    assert series["step"] == pytest.approx([np.ptp(values) / COARSE_CODE])
    assert np.abs(unpacked(series, 4) - values).max() == pytest.approx(0.5 * series["step"][0], rel=0.1)


def test_any_change_of_a_code_comes_back():
    """Also the largest both ways, which wrap around."""
    values = np.array([[0.0, 1.0, 0.3], [1.0, 0.0, np.nan], [0.0, 0.5, 0.3], [np.nan, 0.50001, 0.29999]])
    assert unpacked(packed_series(values), 4) == pytest.approx(values, abs=1e-5, nan_ok=True)


def test_what_is_not_finite_stays_so_and_widens_no_range():
    values = np.array([[1.0, np.nan, 3.0], [2.0, np.inf, 2.5]])
    series = packed_series(values)
    assert series["low"] == [1.0] and series["step"][0] == pytest.approx(2.0 / 65534)
    back = unpacked(series, 2)
    assert np.isnan(back[:, 1]).all() and back[:, [0, 2]] == pytest.approx(values[:, [0, 2]], abs=2e-5)


def test_small_numbers_of_a_logarithmic_series_keep_their_digits():
    values = np.array([[1.0e-9, 1.0e-3], [3.0e-7, 0.0]])
    back = unpacked(packed_series(values, logarithmic=True), 2)
    assert back[:, 0] == pytest.approx(values[:, 0], rel=2e-4) and back[1, 1] == pytest.approx(1.0e-9, rel=1e-3)


def test_equal_numbers_need_no_data():
    series = packed_series(np.full((3, 7), 2.5))
    assert series["data"] == "" and series["low"] == [2.5]


def test_rounded_numbers_are_those_of_json():
    assert rounded(np.array([1.234567, np.nan, -1.0e-9])) == [1.2346, None, -1.0e-9]


# ----------------------------------------------------------------------------------------------------------- frames


def sizes_of(info, frames):
    """Bytes of the positions and main fields of a frame, and of its other fields: three, since one is left out."""
    count = info.sheet.blank.element_count
    return 4 * (frames[0].position.size + 2 * count), 4 * 3 * count


def recorded(info, frames, **limits):
    recorder = FrameRecorder(**limits)
    recorder.start(info)
    for frame in frames:
        recorder.frame(frame)
    return recorder


def test_frames_are_thinned_evenly_and_the_last_is_there():
    info, frames = made_run(0.03, frame_count=12)
    main, _ = sizes_of(info, frames)
    recorder = recorded(info, frames, limit=5 * main)
    assert recorder.places == [0, 4, 8, 11] and recorder.stride == 4 and recorder.frame_count == 12
    assert np.array_equal(recorder.positions(0)[-1], frames[-1].position.astype(np.float32))
    assert all(field.at == [0, 1, 2, 3] for field in recorder.fields(0).values())


def test_only_other_fields_are_thinned_as_long_as_positions_fit():
    info, frames = made_run(0.03, frame_count=12)
    _, other = sizes_of(info, frames)
    recorder = recorded(info, frames, other_limit=4 * other)
    fields = recorder.fields(0)
    assert recorder.places == list(range(12)) and recorder.stride == 1 and recorder.other_stride == 4
    assert fields["shear_angle"].at == fields["thickness"].at == list(range(12))
    assert fields["warp_stretch"].at == [0, 4, 8, 11]
    stretch = [frames[k].fields["warp_stretch"].astype(np.float32) for k in (0, 4, 8, 11)]
    assert np.array_equal(fields["warp_stretch"].values, stretch)
    # the page tells where they are
    _, history = _recorded(info, frames)
    shown = {field["name"]: field for field in scene_of(info, recorder, history)["sheets"][0]["fields"]}
    assert shown["warp_stretch"]["at"] == [0, 4, 8, 11] and shown["shear_angle"]["at"] is None
    assert unpacked(shown["warp_stretch"]["values"], 4) == pytest.approx(np.array(stretch), abs=1e-6)


def test_very_many_values_are_rounded_more_before_frames_are_left_out(monkeypatch):
    info, frames = made_run(0.03, frame_count=12)
    _, other = sizes_of(info, frames)
    monkeypatch.setattr(recorder_module, "COARSE_BYTES", 8 * other)
    recorder, (_, history) = recorded(info, frames), _recorded(info, frames)
    fields = recorder.fields(0)
    assert fields["warp_stretch"].coarse and not fields["shear_angle"].coarse and not fields["thickness"].coarse
    shown = {field["name"]: field for field in scene_of(info, recorder, history)["sheets"][0]["fields"]}
    assert shown["warp_stretch"]["at"] is None and shown["warp_stretch"]["steps"] == COARSE_CODE
    assert shown["shear_angle"]["steps"] is None
    back, given = unpacked(shown["warp_stretch"]["values"], 12), fields["warp_stretch"].values
    assert np.abs(back - given).max() <= 0.51 * np.ptp(given) / COARSE_CODE


def test_a_page_of_a_run_in_progress_has_few_frames_with_all_fields():
    info, frames = made_run(0.03, frame_count=50)
    fewer = recorded(info, frames).thinned(24)
    assert fewer.places == [*range(0, 50, 3), 49] and fewer.frame_count == 50
    assert all(len(field.at) == 18 for field in fewer.fields(0).values())
    assert recorded(info, frames[:24]).thinned(24).places == list(range(24))


@pytest.mark.parametrize("count", [19, 25, 31, 48])
def test_a_page_in_progress_keeps_frames_between_those_with_all_fields(count):
    info, frames = made_run(0.03, frame_count=count)
    _, other = sizes_of(info, frames)
    fewer = recorded(info, frames, other_limit=6 * other).thinned(24)
    assert 12 <= len(fewer.places) <= 25 and fewer.places[-1] == count - 1
    fields = fewer.fields(0)
    assert fields["shear_angle"].at == list(range(len(fewer.places)))
    assert 3 <= len(fields["warp_stretch"].at) <= 7


def test_the_view_has_every_field_in_units_for_readers(coarse_run):
    info, frames = coarse_run
    recorder, folder_history = _recorded(info, frames)
    scene = scene_of(info, recorder, folder_history)
    fields = {field["name"]: field for field in scene["sheets"][0]["fields"]}
    assert list(fields)[:2] == ["shear_angle", "thickness"] and fields["thickness"]["unit"] == "mm"
    thickness = unpacked(fields["thickness"]["values"], len(frames))
    assert thickness[-1] == pytest.approx(1e3 * frames[-1].fields["thickness"], abs=1e-4)
    angle = unpacked(fields["shear_angle"]["values"], len(frames))
    assert angle[-1] == pytest.approx(np.rad2deg(frames[-1].fields["shear_angle"]), abs=2e-3)
    assert [tool["name"] for tool in scene["tools"]] == ["punch", "die", "blank holder"]


def test_frames_tell_their_stage(coarse_run):
    info, frames = coarse_run
    recorder = FrameRecorder()
    recorder.start(info)
    for frame in (frames[0], replace(frames[1], stage="pressing")):
        recorder.frame(frame)
    assert recorder.stages == ["", "pressing"]


def _recorded(info, frames):
    from weavesim.output.history import History

    recorder, history = FrameRecorder(), History()
    for observer in (recorder, history):
        observer.start(info)
        for frame in frames:
            observer.frame(frame)
    return recorder, history


# ------------------------------------------------------------------------------------------------------------ words


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.0612, "m", "61.2\u202fmm"), (0.0, "m", "0\u202fmm"), (12.0, "m", "12\u202fm"),
        (31.8e9, "Pa", "31.8\u202fGPa"),
        (0.5, "rad", "28.65°"), (1.7e-6, "s", "1.7\u202fµs"), (0.0, "s", "0\u202fs"), (0.2, "1", "0.2"),
        (15210583.0, "1/s", "15\u202f210\u202f583\u202f1/s"), (4.7e-16, "m^4", "0.00047\u202fmm⁴"),
        (-3.0e-7, "", "−3·10⁻⁷"), (float("nan"), "m", "–"),
    ],
)  # fmt: skip
def test_numbers_have_units_that_readers_expect(value, unit, text):
    assert number(value, unit) == text


def test_values_are_words_and_no_python():
    stroke = Stroke(times=tuple(np.linspace(0.0, 0.1, 50)), displacements=tuple(np.linspace(0.0, 0.06, 50)))
    rows = {row.label: row.text for row in rows_of(stroke)}
    assert rows["times"] == "50 values, 0\u202fs to 0.1\u202fs"
    assert rows["displacements"] == "50 values, 0\u202fmm to 60\u202fmm"
    assert text_of((0.0, 0.0, -9.81), "m/s^2") == "(0, 0, −9.81)\u202fm/s²"
    assert text_of(np.zeros((408, 3), dtype=int)) == "408" and text_of(np.eye(3)) == "(1, 0, 0), (0, 1, 0), (0, 0, 1)"
    assert text_of({"warp_axial": True, "n": 3}) == "warp axial yes, n 3" and words("ForceDriven") == "force driven"


def test_a_set_up_is_told_without_python():
    from weavesim.scenes.double_dome import DoubleDomeParameters, double_dome

    setup = double_dome(DoubleDomeParameters(mesh_size=0.02))
    info = replace(made_info(setup.sheets[0].blank), setup=setup, duration=setup.duration)
    tables = dict(setup_tables(info))
    assert {"Run", "Motion and contact", "Sheet", "Tool: punch", "Tool: die"} <= set(tables)
    rows = {row.label: row.text for row in tables["Tool: punch"]}
    assert rows["radius"] == "60\u202fmm" and rows["friction"] == "0.2" and rows["shape"] == "dome punch"
    every = " ".join(f"{row.label} {row.text}" for items in tables.values() for row in items)
    assert not re.search(r"array\(|\w+=|None|True|False|<\w|np\.|\w\(\w+", every)


def test_provenance_names_the_command_and_every_hash():
    record = {
        "started": "2026-01-02T03:04:05+00:00", "host": "here", "command": ["weavesim", "double-dome", "--out", "a b"],
        "versions": {"weavesim": "1.2", "numpy": "2.0"}, "commit": "abc", "setup_hash": "123",
        "input_files": {"punch": {"path": "/p.stl", "bytes": 9, "sha256": "fed"}}, "device": "cpu",
        "precision": "float32", "processor": "a processor", "system": "a system",
    }  # fmt: skip
    rows = provenance_rows(record, "run-1")
    text = {row.label: row.text for row in rows}
    assert (
        text["started"] == "2026-01-02 03:04:05 UTC on here" and text["command"] == "weavesim double-dome --out 'a b'"
    )
    assert text["commit"] == "abc" and text["SHA-256"] == "fed" and text["set-up, SHA-256"] == "123"
    assert text["machine"] == "a processor, a system" and Row("run", "run-1") in rows
    assert provenance_rows({}, "run-1") == [Row("run", "run-1")]


@pytest.mark.parametrize(
    ("summary", "outcome", "word", "tone"),
    [
        ({"verdict": "trusted"}, "finished", "trusted", "good"),
        ({"verdict": "doubtful", "doubts": [{"level": "warning"}]}, "finished", "doubtful", "doubtful"),
        ({"verdict": "do not use", "doubts": [{"level": "do not use"}]}, "finished", "do not use", "bad"),
        ({"verdict": "trusted"}, "interrupted", "trusted", "doubtful"),
        ({}, "running", "running", "open"), ({}, "finished", "not judged", "open"),
    ],
)  # fmt: skip
def test_the_verdict_says_how_the_run_ended(summary, outcome, word, tone):
    found = verdict_of(summary, outcome, None)
    assert (found["word"], found["tone"]) == (word, tone)
    assert ("did not reach its end" in found["text"]) == (outcome == "interrupted")


# ------------------------------------------------------------------------------------------------------------- page


def written(folder_path, info, frames, summary=None, outcome=Outcome.FINISHED, **options):
    """The page of a run of these frames."""
    folder = ResultFolder(folder_path, writers=["report"], **options)
    folder.start(info)
    for frame in frames:
        folder.frame(frame)
    folder.finish(outcome)
    folder.write(summary or {})
    return (folder_path / "report.html").read_text(encoding="utf-8")


def test_no_name_of_a_run_becomes_html(tmp_path, coarse_run):
    evil = "</script><script>alert(1)</script><i>&"
    info, frames = coarse_run
    sheet = replace(info.sheet, fabric=info.sheet.fabric.model_copy(update={"name": evil}))
    doubts = [{"guard": "x", "level": "warning", "text": evil, "advice": evil, "message": evil}]
    page = written(
        tmp_path, replace(info, sheets=(sheet,)), frames, {"doubts": doubts, "notes": [evil], "verdict": evil}
    )
    assert "<script>alert" not in page and "<i>&" not in page
    data = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1]
    assert json.loads(data)["scene"]["sheets"][0]["fabric"] == evil
    assert in_script("</a>\u2028") == "\\u003c/a>\\u2028"


def test_the_page_asks_for_nothing(tmp_path, coarse_run):
    page = written(tmp_path, *coarse_run)
    own = re.sub(r"<script.*?</script>|<style>.*?</style>", "", page, flags=re.DOTALL)
    assert not re.search(r"""(?:src|href)=["'](?!data:|#)""", own) and "@import" not in page
    assert "three.js authors" in page and "Leon Sorokin" in page  # their licences ask for it
    assert len(page) < 4_000_000


def test_the_forces_are_those_of_the_whole_part(tmp_path, coarse_run):
    info, frames = coarse_run
    page = written(tmp_path, info, frames, {"peak_tool_force_n": {"punch": 300.0}})
    assert info.sheet.symmetry.share == 0.25
    force = 4.0 * abs(float(frames[-1].tool_reaction[0, 2]))
    row = re.search(r"<tr><th>punch</th><td>(.*?)</td><td>(.*?)</td>", page)
    assert row[1] == number(force, "N") and row[2] == number(1200.0, "N")


def test_a_run_that_was_stopped_at_once_has_a_page(tmp_path, coarse_run):
    info, frames = coarse_run
    page = written(tmp_path, info, frames[:1], outcome=Outcome.INTERRUPTED)
    assert "did not reach its end (interrupted)" in page and 'data-charts="forces' in page


def test_two_plies_are_two_sheets(tmp_path, stack):
    page = written(tmp_path, *stack)
    data = json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])
    assert [sheet["name"] for sheet in data["scene"]["sheets"]] == [sheet.name for sheet in stack[0].sheets]
    assert [sheet["level"] for sheet in data["scene"]["sheets"]] == list(stack[0].levels)


def test_regions_have_units_that_readers_expect_and_no_minus_nothing():
    region = Region("gap", np.array([3]), 3, 2.194e-3, (0.072, -0.0001, -0.012), (0.0, 0.1), 1e-3, 2.0)
    text = region_of_page(region, 0, "sheet", np.arange(5))["text"]
    assert text == "sheet: gap at (72, 0, -12) mm: gap 1.00 mm, 2 times the limit, 2194 mm²"


def test_forces_and_energies_are_those_of_the_whole_part_and_it_is_said_once(tmp_path, coarse_run):
    info, frames = coarse_run
    page = written(tmp_path, info, frames, {"energies_j": {"shear": 0.5}})
    own = re.sub(r"<script.*?</script>|<style>.*?</style>", "", page, flags=re.DOTALL)
    assert own.count("are those of the whole part") == 1 and "computed part" not in own
    assert re.search(r"shear</th><td>2\u202fJ<", own)
    charts = json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])["charts"]
    shear = next(line for chart in charts if chart["name"] == "energies" for line in chart["lines"]
                 if line["label"] == "shear")  # fmt: skip
    assert shear["y"][-1] == pytest.approx(4.0 * frames[-1].energies["shear"], rel=1e-4)


def test_the_page_draws_the_force_that_a_tool_should_carry(tmp_path, coarse_run):
    info, frames = coarse_run
    forces = [np.array([np.nan, np.nan, 160.0 * min(1.0, frame.index / 3.0)]) for frame in frames]
    page = written(tmp_path, info, [replace(f, tool_wanted=each) for f, each in zip(frames, forces, strict=True)])
    charts = json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])["charts"]
    lines = {line["label"]: line for chart in charts if chart["name"] == "forces" for line in chart["lines"]}
    assert set(lines) == {"punch", "die", "blank holder", "blank holder, wanted"}
    assert lines["blank holder, wanted"]["y"] == pytest.approx([4.0 * each[2] for each in forces], rel=1e-4)
    assert lines["blank holder"]["y"] == pytest.approx([640.0] * len(frames))
    assert lines["blank holder, wanted"]["dashed"] and not lines["blank holder"]["dashed"]


@pytest.mark.parametrize("kind", ["wrinkle", "bridging", "locking", "gap", "self-contact"])
def test_a_region_of_any_kind_leads_to_a_field_of_the_menu(kind):
    region = Region(kind, np.array([3, 5]), 5, 1e-4, (0.0, 0.1, 0.2), (0.0, 0.1), 1e-3, 2.0, 0.02, 2)
    found = region_of_page(region, 0, "sheet", np.arange(100) + 5)
    # by the elements that the page shows: a stage may have trimmed some
    assert found["worst"] == 10 and found["elements"] == [8, 10]
    assert found["field"] in {field.name for field in (*JUDGED_FIELDS, *FIELDS)}
