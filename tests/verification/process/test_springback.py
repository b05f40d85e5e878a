"""A strip is bent and released: what stays is what its moment-curvature law says."""

import numpy as np
import pytest

from tests.support.bent_strips import bent_strip
from tests.support.runs import one_sheet_run
from weavesim.fabric.bending import YarnBending
from weavesim.fabric.bending.curve import BendingCurve
from weavesim.fabric.cell import LinearMembrane
from weavesim.process.dynamics import Dynamics
from weavesim.process.loads import NodalLoads

RIGIDITY, LOOP, SLIP = 2.0e-3, 8.0e-3, 0.5
LENGTH, WIDTH, COUNT = 0.05, 0.01, 10
MOMENT = 3.0e-2
RAMP = 0.4


def test_a_bent_strip_springs_back_by_its_law(fabric, frames, manual):
    curve = BendingCurve.from_kawabata(RIGIDITY, LOOP, slip_curvature=SLIP)
    strip = fabric(
        areal_density=0.5, thickness=5.0e-4, unit_cell=LinearMembrane(warp_stiffness=2.0e4, weft_stiffness=2.0e4),
        bending=YarnBending(warp=curve, weft=curve, twist=1.0e-3), transverse_shear_modulus=1.0e6,
    )  # fmt: skip
    blank, free, couple = bent_strip(LENGTH, WIDTH, COUNT, MOMENT)
    x = blank.node_position[:, 0]
    s = np.linspace(0.0, 1.0, 21)
    smooth = s * s * (3.0 - 2.0 * s)
    times, shares = (*(RAMP * s), *(RAMP * (1.5 + s))), (*smooth, *smooth[::-1])
    simulation = one_sheet_run(
        name="springback", blank=blank, fabric=strip, free=free, loads=NodalLoads(None, couple, times, shares),
        dynamics=Dynamics(damping=170.0, director_damping=170.0), duration=3.0 * RAMP, frame_count=90,
        precision="float64", lane_count=1, threads=1,
    )  # fmt: skip
    simulation.run([frames])

    def curvature(frame) -> np.ndarray:
        row = np.flatnonzero(blank.node_position[:, 1] < 1e-9)
        row = row[np.argsort(x[row])]
        turn = np.unwrap(np.arctan2(frame.director[row, 0], frame.director[row, 2]))
        return np.abs(np.diff(turn)) * COUNT / LENGTH

    # M = B kappa + HB where it is bent, M = B kappa - HB + what has slid back where it is released
    friction = 0.5 * LOOP
    bent = (MOMENT - friction) / RIGIDITY
    left = friction / RIGIDITY  # the slider has turned round: 2 SLIP is far less than the curvature that was lost
    assert bent - left > 2.0 * SLIP
    held = [frame for frame in frames.all if 1.3 * RAMP < frame.time < 1.5 * RAMP][-1]
    found = curvature(held), curvature(simulation.frame)
    assert found[0] == pytest.approx(np.full(COUNT, bent), rel=0.01)
    assert found[1] == pytest.approx(np.full(COUNT, left), rel=0.02)
    energies = simulation.frame.energies
    assert abs(energies["balance_error"]) < 0.01 * energies["load_work"] + 1e-3 * energies["bending_friction_loss"]
    loss = LENGTH * WIDTH * friction * ((bent - SLIP) + (bent - left - 2.0 * SLIP))
    assert energies["bending_friction_loss"] == pytest.approx(loss, rel=0.03)
    case = manual(
        "Process", "Springback of a bent strip",
        known="A strip with M = B kappa and friction of +-HB, B = 2 mN m, 2HB = 8 mN, is bent by M = 30 mN to "
        "(M - HB) / B = 13 1/m and released: HB / B = 2 1/m stays.",
    )  # fmt: skip
    case.table(
        ["", "expected", "got, of all elements"],
        [["bent [1/m]", f"{bent:.4g}", f"{found[0].min():.4g} to {found[0].max():.4g}"],
         ["released [1/m]", f"{left:.4g}", f"{found[1].min():.4g} to {found[1].max():.4g}"],
         ["lost in friction [J]", f"{loss:.4g}", f"{energies['bending_friction_loss']:.4g}"]],
    )  # fmt: skip
