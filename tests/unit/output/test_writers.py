"""What the writers leave of a run of several sheets; of one sheet see test_folder."""

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
        "stack.usdc", "paraview", "pictures", "history.csv", "report.html", "summary.json",
        "run.json", "results.h5", ".weavesim.lock",
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
    for part in ("Sheet upper", "Sheet lower", "Fabric of upper", "quarter of the blank, whole blank", "punch 2"):
        assert part in text
    assert text.count("data:image/png;base64") == 10


def test_the_history_names_tools_of_both_worlds(finished):
    header = (finished[0] / "history.csv").read_text().splitlines()[0].split(",")
    assert len(set(header)) == len(header) and {"punch_displacement_m", "punch_2_displacement_m"} <= set(header)
