"""Runs that trip a guard, and runs that just do not: in each pair only the size of one thing differs.

Guards with tests of their own have their pairs there: ``test_between.py``, ``test_closing.py``, ``test_holder.py``,
``test_law_range.py``, ``test_sheet.py``, ``test_stretch.py``, ``test_tool_mesh.py``, ``test_touch.py``.
"""

import json

import numpy as np
import pytest

from tests.support.frames import Frames
from tests.support.runs import small_run
from weavesim import Drive, Dynamics, SmoothStroke, Support, Tool
from weavesim.errors import RunError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.kernels.rows import CellReportRow, MotionRow
from weavesim.run.guards import Level
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Plane

BLANK = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)
X, Y = BLANK.node_position[:, :2].T


def levels(simulation, observers=()) -> dict[str, Level]:
    """Every guard that speaks after a run, with its level."""
    simulation.run(observers)
    return {doubt.guard: doubt.level for doubt in simulation.doubts()}


def pulled(duration: float, **given):
    """A square that is pulled by 0.1 mm within a time."""
    stroke = SmoothStroke.ramped(1e-4, 1.5e-4 / duration, 0.4 * duration)
    edges = np.flatnonzero(X < 1e-9), np.flatnonzero(X > 0.02 - 1e-9)
    supports = Support("held", edges[0]), Support("pulled", edges[1], (Drive(stroke, (1.0, 0.0, 0.0)),))
    return small_run(blank=BLANK, supports=supports, duration=duration, accept_unusual=True, **given)


@pytest.mark.parametrize(("duration", "trips"), [(1.0e-4, True), (3.0e-4, False)])
def test_kinetic_energy(duration, trips):
    assert levels(pulled(duration)) == ({"kinetic_energy": Level.WARNING} if trips else {})


@pytest.mark.parametrize(("damping", "trips"), [(5.5e4, True), (4.0e4, False)])
def test_damping(damping, trips):
    found = levels(pulled(1.0e-3, dynamics=Dynamics(damping=damping)))
    assert found == ({"damping_loss": Level.WARNING} if trips else {})


@pytest.mark.parametrize(("speed", "trips"), [(0.15, True), (0.12, False)])
def test_hourglass_energy(speed, trips):
    """Neighbouring nodes move against each other, out of the plane of a sheet that stretches."""
    velocity = np.zeros((BLANK.node_count, 3))
    velocity[:, 0] = 2.0 * X / 0.02
    velocity[:, 2] = speed * (-1.0) ** np.round((X + Y) / 0.005)
    found = levels(small_run(initial_velocity=velocity, duration=2e-4))
    assert ("hourglass_energy" in found) == trips and found["kinetic_energy"] == Level.WARNING


@pytest.mark.parametrize(
    ("speed", "level"), [(5.0, None), (10.0, None), (20.0, Level.WARNING), (95.0, Level.WARNING), (110.0, 2)]
)
def test_penetration(speed, level):
    """A sheet that is thrown on a table, up to 5 % of its thickness, up to half of it, and beyond."""
    table = Tool("table", Plane(origin=(0.0, 0.0, -0.5 * glass_polypropylene().thickness - 1e-5)))
    velocity = np.tile((0.0, 0.0, -speed), (BLANK.node_count, 1))
    simulation = small_run(tools=(table,), initial_velocity=velocity, duration=1e-4, accept_unusual=True)
    assert levels(simulation).get("penetration_at_nodes") == level


@pytest.mark.parametrize(("share", "trips"), [(1.04, False), (1.06, True)])
def test_added_mass(share, trips):
    """Mass grows with the square of the step that it is scaled for."""
    stable, low, high = small_run().stepper.stable_step(), 0.5, 1.5
    for _ in range(14):
        middle = 0.5 * (low + high)
        enough = small_run(target_step=middle * stable).model.sheet.added_mass_ratio > share - 1.0
        low, high = (low, middle) if enough else (middle, high)
    simulation = small_run(target_step=high * stable)
    assert simulation.model.sheet.added_mass_ratio == pytest.approx(share - 1.0, abs=5e-3)
    assert ("added_mass" in levels(simulation)) == trips


class Pushed(Frames):
    """Speeds a run up at its second frame by a share of its kinetic energy, which nothing has supplied."""

    def __init__(self, simulation, share: float) -> None:
        super().__init__()
        self._simulation, self._share = simulation, share

    def frame(self, frame) -> None:
        super().frame(frame)
        if frame.index == 1:
            (model,), (state,) = self._simulation.model.sheets, self._simulation.state.sheets
            motion = model.read_motion(state.motion)
            motion[MotionRow.velocity.vector] *= np.sqrt(1.0 + self._share)
            model.write_motion(state.motion, motion)


@pytest.mark.parametrize(("share", "trips"), [(0.02, False), (0.15, True)])
def test_energy_balance(share, trips):
    velocity = np.zeros((BLANK.node_count, 3))
    velocity[:, 0] = 2.0 * X / 0.02
    simulation = small_run(initial_velocity=velocity, duration=2e-4, frame_count=8)
    found = levels(simulation, [Pushed(simulation, share)])
    assert found.get("energy_balance") == (Level.DO_NOT_USE if trips else None)


@pytest.mark.parametrize(("residual", "trips"), [(0.9, False), (1.1, True)])
def test_unit_cells_that_fail(residual, trips):
    """The worst residual of every cell is kept over the run."""
    from weavesim.run.fields import UNIT_CELL_FAILURE

    simulation = pulled(3.0e-4)
    (state,) = simulation.state.sheets
    report = state.cell_report.numpy()
    report[CellReportRow.worst_residual, 3] = residual * UNIT_CELL_FAILURE
    state.cell_report.assign(report)
    assert levels(simulation) == ({"unit_cell_failures": Level.WARNING} if trips else {})


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf])
def test_a_state_that_is_not_finite_is_never_trusted(tmp_path, number):
    from weavesim.output import ResultFolder

    simulation = pulled(1.0e-3)
    (model,), (state,) = simulation.model.sheets, simulation.state.sheets
    motion = model.read_motion(state.motion)
    motion[MotionRow.velocity.vector][7] = number
    model.write_motion(state.motion, motion)
    folder = ResultFolder(tmp_path, writers=["summary"])
    with pytest.raises(RunError, match="non-finite"):
        simulation.run([folder])
    folder.write(simulation.summary())
    numbers = json.loads((tmp_path / "summary.json").read_text())
    assert (numbers["outcome"], numbers["verdict"]) == ("not finite", "do not use")
    (doubt,) = [doubt for doubt in numbers["doubts"] if doubt["guard"] == "not_finite"]
    assert doubt["level"] == "do not use" and doubt["time_s"] > 0.0 and doubt["sheet"] == "sheet"
    x, y = doubt["place_m"]
    assert 0.0 < x < 0.02 and 0.0 < y < 0.02 and "first suspect" in doubt["message"]


def test_a_state_that_is_merely_wild_is_finite():
    velocity = 30.0 * np.random.default_rng(0).normal(size=(BLANK.node_count, 3))
    assert "not_finite" not in levels(small_run(initial_velocity=velocity, duration=2e-5, accept_unusual=True))
