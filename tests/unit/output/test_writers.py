"""What the writers leave of a run of several sheets; of one sheet see test_folder."""

import csv
import dataclasses
import json

import numpy as np
import pytest

from tests.support.made_run import formed
from weavesim.measures.findings import SHEET_FINDINGS, found
from weavesim.output import ResultFolder
from weavesim.run.frame import Outcome

POINTS = np.array([[0.1, 0.05], [0.05, 0.1]])


@pytest.fixture(scope="module")
def finished(tmp_path_factory, stack):
    path = tmp_path_factory.mktemp("stack")
    folder = ResultFolder(path, points=POINTS)
    info, frames = stack
    folder.start(info)
    for frame in frames:
        folder.frame(frame)
    folder.finish(Outcome.FINISHED)
    return path, folder.write({"wall_time_s": 1.5, "max_shear_angle_deg": 40.0})


def test_every_sheet_has_its_files(finished):
    path, _ = finished
    per_sheet = {f"{name}_{sheet}.csv" for name in ("draw_in", "shear_angle") for sheet in ("upper", "lower")}
    assert {file.name for file in path.iterdir()} == per_sheet | {
        "stack.usdc", "paraview", "pictures", "history.csv", "sheets.csv", "report.html", "summary.json",
        "progress.json", "run.json", "results.h5", ".weavesim.lock",
    }  # fmt: skip
    drawn = {f"{name}_{sheet}.png" for name in ("formed_sheet", "point_angles", "draw_in", "sections")
             for sheet in ("upper", "lower")}  # fmt: skip
    assert {file.name for file in (path / "pictures").iterdir()} == drawn | {"tool_forces.png", "energies.png"}


def test_findings_of_each_sheet_stand_in_a_list(finished, stack):
    path, returned = finished
    info, frames = stack
    summary = json.loads((path / "summary.json").read_text())
    assert summary == returned
    assert list(summary) == [
        "outcome", "frame_count", "run_id", "wall_time_s", "max_shear_angle_deg", "sheets", "missing", "warnings",
    ]  # fmt: skip
    for k, entry in enumerate(summary["sheets"]):
        one = [type(part)(**{**vars(part), "sheets": part.sheets[k : k + 1]}) for part in (info, frames[-1])]
        assert entry == {"name": info.sheets[k].name, **found(SHEET_FINDINGS, formed(*one, POINTS))}


def test_the_report_names_the_sheets(finished):
    text = (finished[0] / "report.html").read_text(encoding="utf-8")
    for part in ("Sheet upper", "Sheet lower", "(upper, lower)", "quarter of the blank, whole blank", "punch 2"):
        assert part in text
    assert text.count("data:image/png;base64") == 8  # without forces and energies, which are charts


def test_sheets_stand_side_by_side_in_a_table(finished):
    path, summary = finished
    with open(path / "sheets.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["sheet"] for row in rows] == ["upper", "lower"]
    for row, entry in zip(rows, summary["sheets"], strict=True):
        for key in ("max_shear_angle_deg", "draw_in_long_axis_mm", "draw_in_short_axis_mm", "max_stretch"):
            assert float(row[key]) == pytest.approx(entry[key], rel=1e-8)


def test_the_history_has_what_there_is_of_each_sheet(finished, stack):
    with open(finished[0] / "history.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for row, frame in zip(rows, stack[1], strict=True):
        for sheet in frame.sheets:
            angle = np.degrees(np.abs(sheet.fields["shear_angle"]).max())
            assert float(row[f"{sheet.name}_max_shear_angle_deg"]) == pytest.approx(angle)


def test_sheets_of_one_world_are_drawn_together(tmp_path, stack):
    info, frames = stack
    sheets = tuple(dataclasses.replace(sheet, world="world", tools=info.sheets[0].tools) for sheet in info.sheets)
    folder = ResultFolder(tmp_path, writers=["pictures"])
    folder.start(dataclasses.replace(info, sheets=sheets))
    for frame in frames:
        folder.frame(frame)
    folder.finish(Outcome.FINISHED)
    folder.write({})
    drawn = {file.name for file in (tmp_path / "pictures").iterdir()}
    assert {"stack.png", "sections.png", "formed_sheet_upper.png"} <= drawn and "sections_upper.png" not in drawn


def test_the_history_names_tools_of_both_worlds(finished):
    header = (finished[0] / "history.csv").read_text().splitlines()[0].split(",")
    assert len(set(header)) == len(header) and {"punch_displacement_m", "punch_2_displacement_m"} <= set(header)
