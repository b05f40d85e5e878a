"""The account of what the time integration makes at kinks; see also tests/verification/time/test_slack_sheet.py."""

import math

import numpy as np
import pytest

from tests.support.runs import small_run
from tests.support.sheet import plain_fabric
from weavesim.engine.setup import STEP_SAFETY
from weavesim.fabric.cell.membrane import LinearMembrane
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.kernels.cell.surplus import LARGEST_CORRECTION, LARGEST_SURPLUS
from weavesim.kernels.rows import CellReportRow
from weavesim.process.dynamics import Dynamics
from weavesim.run.simulation import Simulation

LINEAR = {
    "membrane": LinearMembrane(warp_stiffness=1e4, weft_stiffness=1e4),
    "straight yarns": PlainWeave.straight(stiffness_per_width=1e4),
}


def rattled(cell) -> Simulation:
    """A small sheet with random velocities, after 5 ms."""
    velocity = np.random.default_rng(3).normal(scale=0.02, size=(25, 3))
    simulation = small_run(
        fabric=plain_fabric(unit_cell=cell), duration=5e-3, initial_velocity=velocity,
        dynamics=Dynamics(gravity=(0.0, 0.0, 0.0)),
    )  # fmt: skip
    simulation.run()
    return simulation


def largest_account(simulation: Simulation) -> float:
    """Over the mean energy per area at the start."""
    found = simulation.state.sheet.cell_report.numpy()[CellReportRow.surplus, :16]
    return float(np.abs(found).max()) * 0.02**2 / simulation.frame.energies["initial_kinetic"]


@pytest.mark.parametrize("name", LINEAR)
def test_a_straight_law_has_no_surplus(name):
    assert largest_account(rattled(LINEAR[name])) < 1e-9


def test_a_kink_has_one_and_the_ledger_shows_it():
    straight = LINEAR["straight yarns"]
    axial = 0.3 * straight.axial_stiffness[0]
    changes = {"warp_compressive_stiffness": axial, "weft_compressive_stiffness": axial}
    simulation = rattled(straight.model_copy(update=changes))
    assert 1e-6 < largest_account(simulation) < 0.5
    ahead = simulation.stepper.look_ahead().sheets[0].cell_report.numpy()[CellReportRow.surplus, :16]
    area = simulation.model.sheet.geometry.area
    assert simulation.frame.energies["surplus"] == pytest.approx(float(ahead @ area))


def test_the_corrected_step_is_stable_and_no_kink_is_cut_off():
    assert math.sqrt(1.0 - 0.5 * float(LARGEST_CORRECTION)) > STEP_SAFETY
    assert float(LARGEST_SURPLUS) > 3.0 * (2.0 * STEP_SAFETY) ** 2 / 8.0
