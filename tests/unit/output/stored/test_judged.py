"""A judged run: files, lines, and the distance to its own tools."""

import csv
import dataclasses
import json

import numpy as np
import pytest
from PIL import Image

from tests.support.runs import one_sheet_setup
from tests.support.sheet import plain_fabric
from tests.support.stored_runs import stored_run, stored_sheet
from tests.support.summary_keys import keys_without_unit
from weavesim.measures.defects.judgement import Limits
from weavesim.output.stored.file import StoredRun
from weavesim.output.stored.judged import ToolsOfRun, judge_run, tool_distance, write_judged
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Sphere
from weavesim.tools.tool import Tool


@pytest.fixture(scope="module")
def run() -> StoredRun:
    """A rippled sheet over a ball that has moved by 10 mm."""
    blank = Blank.rectangle((-0.05, -0.05), (0.05, 0.05), 0.0025)
    x, y = blank.material_coordinates.T
    count = blank.element_count
    sheet = stored_sheet(
        blank, np.column_stack([x, y, 2e-3 * np.sin(2.0 * np.pi * x / 0.02)]), warp_stretch=np.full(count, 0.99),
        weft_stretch=np.ones(count), warp_force=np.zeros(count), weft_force=np.zeros(count),
    )  # fmt: skip
    ball = Tool("ball", Sphere(origin=(0.0, 0.0, -0.13), radius=0.1))
    setup = one_sheet_setup(name="x", blank=blank, fabric=plain_fabric(), duration=1.0, tools=(ball,))
    whole = stored_run(dataclasses.replace(sheet, tools=(0,)))
    made = dataclasses.replace(whole, tool_displacement=np.array([0.01]))
    made.__dict__["setup"] = setup
    return made


def test_the_distance_is_that_to_the_tool_where_it_is(run):
    distance = tool_distance(run, run.sheets[0], ToolsOfRun(run.tools))
    assert distance(np.array([[0.0, 0.0, 0.0], [0.0, 0.05, 0.0]])) == pytest.approx([0.02, np.hypot(0.05, 0.12) - 0.1])


def test_a_tool_that_no_longer_acts_is_no_distance_away(run):
    free = dataclasses.replace(run, tool_acts=np.array([False]))
    free.__dict__["setup"] = run.setup
    assert tool_distance(free, run.sheets[0], ToolsOfRun(run.tools)) is None
    judged = judge_run(free, Limits())
    assert "gap" not in judged.sheets[0].fields and "gap" in judge_run(run, Limits()).sheets[0].fields
    assert judged.as_dict()["sheets"][0]["largest_gap_mm"] is None
    assert not keys_without_unit(judged.as_dict())


def test_files_and_lines_tell_the_same(run, tmp_path):
    judged = judge_run(run, Limits(longest_wavelength=0.04))
    files = write_judged(tmp_path, judged)
    assert [file.name for file in files] == ["verdict.json", "verdict.csv", "verdict.png"]
    told = json.loads(files[0].read_text())
    assert told["passed"] is judged.passed is False and told["run_id"] == run.run_id
    assert told["limits"]["longest_wavelength"] == 0.04
    regions = told["sheets"][0]["regions"]
    assert regions[0]["kind"] == "wrinkle" and regions[0]["wavelength_mm"] == pytest.approx(20.0, rel=0.2)
    with open(files[1], newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(regions)
    assert float(rows[0]["amplitude_mm"]) == pytest.approx(regions[0]["amplitude_mm"])
    lines = list(judged.lines())
    assert lines[0].startswith("beyond limits") and "wrinkle at (" in lines[1]
    red = np.asarray(Image.open(files[2]).convert("RGB")).astype(int)
    assert ((red[..., 0] > 150) & (red[..., 1] < 110)).sum() > 1000


def test_a_run_within_its_limits(run, tmp_path):
    judged = judge_run(run, Limits(wrinkle_amplitude=None))
    assert judged.passed and list(judged.lines()) == ["within all limits"]
    assert json.loads(write_judged(tmp_path, judged)[0].read_text())["sheets"][0]["regions"] == []


def test_a_tool_of_several_sheets_is_sampled_once(monkeypatch):
    made = []
    monkeypatch.setattr("weavesim.output.stored.judged.ToolDistance", lambda tool: made.append(tool) or len(made))
    tools = ToolsOfRun(["die", "punch"])
    assert [tools[1], tools[0], tools[1], tools[1]] == [1, 2, 1, 1] and made == ["punch", "die"]
