"""Stacks of plies as a user forms them: nothing passes through anything, plies without friction form as if alone."""

import json
import re

import numpy as np
import pytest

from tests.support.paths import ROOT
from weavesim.run.simulation import Simulation
from weavesim.run.watch.crossing_record import CrossingRecord
from weavesim.scenes.stack import SCENE, StackParameters, slips, stack

# Forming runs of seconds each.
pytestmark = pytest.mark.slow

COARSE = {"mesh_size": 0.015, "punch_speed": 0.5, "threads": 1, "frame_count": 10}


def formed(**given) -> tuple[Simulation, CrossingRecord]:
    simulation, record = Simulation(stack(StackParameters(**(COARSE | given)))), CrossingRecord()
    simulation.run([record])
    return simulation, record


@pytest.fixture(scope="module")
def pair():
    """Two plies without friction, a quarter."""
    return formed(lay_up="0/90")


def test_frictionless_plies_are_formed_as_if_alone(pair):
    """But for their distances from the punch: angles within half a degree on average."""
    simulation, record = pair
    assert record.total == 0
    alone, _ = formed(lay_up="0")
    own = np.degrees(np.abs(alone.frame.sheets[0].fields["shear_angle"]))
    assert own.max() > 15.0
    for sheet in simulation.frame.sheets:
        angle = np.degrees(np.abs(sheet.fields["shear_angle"]))
        assert np.abs(angle - own).mean() < 0.5


def test_energies_balance_and_slip_is_small_where_the_plies_are_alike(pair):
    simulation, _ = pair
    assert simulation.summary()["energy_balance_error"] < 0.01
    found = slips(simulation)
    assert 0.0 < found["mean_slip_mm"]["ply_1 and ply_2"] < found["largest_slip_mm"]["ply_1 and ply_2"] < 5.0


def test_the_dome_forms_three_plies_with_friction_and_leaves_all_results(tmp_path):
    parameters = StackParameters(
        **COARSE | {"mesh_size": 0.0095}, tools="double-dome", lay_up="0/90/0", ply_thickness=0.4e-3, stroke=0.015,
        out=tmp_path,
    )  # fmt: skip
    summary = SCENE.run(parameters)
    assert summary["outcome"] == "finished" and summary["missing"] == []
    assert summary["energy_balance_error"] < 0.01
    assert [found["total"] for found in summary["sheet_intersections"].values()] == [0] * 3
    assert summary["energies_j"]["ply_friction_loss"] > 0.0
    assert [sheet["name"] for sheet in summary["sheets"]] == ["ply_1", "ply_2", "ply_3"]
    assert json.loads((tmp_path / "summary.json").read_text()) == summary
    names = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")}
    assert names >= {
        "stack.usdc", "paraview/series.pvd", "paraview/final_state.vtm", "pictures/stack.png", "pictures/sections.png",
        "pictures/formed_sheet_ply_3.png", "sheets.csv", "draw_in_ply_1.csv", "shear_angle_ply_2.csv", "report.html",
    }  # fmt: skip


def test_the_example_of_the_page_runs(capsys):
    page = (ROOT / "docs" / "stacks.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL)
    exec(compile(code, "stacks.md", "exec"), {})
    assert capsys.readouterr().out.startswith("0/45/90 {'ply_1 and ply_2': {'at_end': 0, ")
