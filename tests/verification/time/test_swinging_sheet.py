"""A sheet that hangs by one edge and swings: no energy comes or goes."""

import numpy as np
import pytest

from tests.support.runs import one_sheet_run
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import Stabilisation
from weavesim.fabric.shear import LinearShear
from weavesim.process.dynamics import Dynamics
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank

SIDE = 0.1


def swinging(fabric, precision: str, time_step: float | None = None) -> Simulation:
    """Let go 20 degrees from the horizontal for 2.2 s, about three swings."""
    blank = Blank.rectangle((0.0, 0.0), (SIDE, SIDE), 0.01, yarn_angle=20.0, distortion=0.2)
    free = np.ones((blank.node_count, 6), dtype=bool)
    free[blank.node_position[:, 0] == 0.0, :3] = False
    angle = np.radians(20.0)
    simulation = one_sheet_run(
        name="swing", blank=blank, fabric=fabric, duration=2.2, free=free, frame_count=100, precision=precision,
        threads=1, lane_count=1, time_step=time_step,
        dynamics=Dynamics(gravity=(9.81 * np.sin(angle), 0.0, -9.81 * np.cos(angle))),
    )  # fmt: skip
    simulation.run()
    return simulation


def largest_error(simulation: Simulation) -> float:
    """Of the balance in any frame, over the largest work of the weight."""
    errors = [abs(entry["balance_error"]) for entry in simulation.history]
    return max(errors) / max(abs(entry["gravity_work"]) for entry in simulation.history)


@pytest.fixture
def cloth(fabric):
    """Soft, so that two swings take ten thousand steps."""
    return fabric(
        unit_cell=PlainWeave.straight(stiffness_per_width=500.0), shear=LinearShear(modulus=1.0e5),
        bending=IsotropicBending(modulus=1.0e6), transverse_shear_modulus=1.0e5, stabilisation=Stabilisation(),
    )  # fmt: skip


@pytest.mark.slow
def test_swinging_sheet_keeps_its_energy(cloth, manual):
    case = manual(
        "Energy and time step", "A swinging sheet keeps its energy",
        known="Nothing takes energy out of a sheet of 100 mm that is let go 20 degrees from the horizontal and "
        "swings about one edge for 2.2 s. The error of the balance is that of central differences, of second order "
        "in the step, plus rounding. The requirement is 0.1 % in 10,000 steps.",
    )  # fmt: skip
    rows, errors = [], {}
    for precision in ("float64", "float32"):
        simulation = swinging(cloth, precision)
        history = simulation.history
        assert simulation.stepper.step_count > 10_000
        assert history[-1]["damping_loss"] == 0.0
        # it swings down and up again, bending and wrinkling
        kinetic = np.array([entry["kinetic"] for entry in history])
        assert kinetic.max() > 10.0 * kinetic[np.argmax(kinetic) :].min()
        assert max(entry["internal"] for entry in history) > 0.02 * kinetic.max()
        errors[precision] = largest_error(simulation)
        rows.append([precision, simulation.stepper.step_count, f"{100 * errors[precision]:.2g} %"])
    slow = swinging(cloth, "float64", 0.25 * 2.2 / simulation.stepper.step_count)
    rows.append(["float64, a quarter of the step", slow.stepper.step_count, f"{100 * largest_error(slow):.2g} %"])
    case.table(["precision", "steps", "largest error of the balance over the work of the weight"], rows)
    assert max(errors.values()) < 1e-3
    assert largest_error(slow) < 0.2 * errors["float64"]
