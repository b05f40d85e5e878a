"""The energy balance of a run whose fabric loses energy inside."""

import numpy as np

from tests.support.registered_laws import CURVE
from tests.support.runs import one_sheet_run
from weavesim.fabric.bending import BendingCurve, YarnBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.presets import glass_polypropylene
from weavesim.fabric.shear import ShearFriction
from weavesim.run.ledger import LOST
from weavesim.sheet.blank import Blank


def test_balance_is_closed_in_a_run_with_friction_inside():
    """A thrown sheet: what the yarns rub away is missing from the vibration, and nothing else is."""

    blank = Blank.rectangle((-0.02, -0.015), (0.02, 0.015), 0.005, yarn_angle=20.0, distortion=0.2)
    straight = PlainWeave.straight(stiffness_per_width=2.0e5)
    rubbing = BendingCurve.from_kawabata(rigidity=3e-3, hysteresis=2e-2, slip_curvature=2.0)
    fabric = glass_polypropylene().model_copy(
        update={
            "unit_cell": straight, "shear": CURVE, "in_plane_bending_stiffness": 0.0,
            "shear_friction": ShearFriction(stiffness=3000.0, limit=(20.0,)),
            "bending": YarnBending(warp=rubbing, weft=rubbing, twist=1e-3),
        }
    )  # fmt: skip
    x, y, _ = blank.node_position.T
    waves = np.column_stack([np.sin(100.0 * y), np.cos(120.0 * x), np.sin(150.0 * x) + np.cos(90.0 * y)])
    simulation = one_sheet_run(
        name="rubbing", blank=blank, fabric=fabric, duration=5e-3, initial_velocity=3.0 * waves, precision="float64",
        lane_count=1, threads=1, frame_count=20,
    )  # fmt: skip
    simulation.run()
    energies = simulation.frame.energies
    assert simulation.stepper.step_count > 500
    for name in ("shear_friction_loss", "bending_friction_loss"):
        assert energies[name] > 0.02 * energies["initial_kinetic"], name
    assert sum(energies[name] for name in LOST) > 0.1 * energies["initial_kinetic"]
    error = np.array([entry["balance_error"] for entry in simulation.history]) / energies["initial_kinetic"]
    assert np.abs(error).max() < 0.02
