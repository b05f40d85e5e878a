"""A strip that is drawn over a cylinder: Euler and Eytelwein."""

import math

import pytest

from tests.support.capstan import RADIUS, THICKNESS, drawn, strip
from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell import LinearMembrane
from weavesim.fabric.fabric import Stabilisation
from weavesim.fabric.shear import LinearShear
from weavesim.tools.shapes import Capsule
from weavesim.tools.tool import Tool

FRICTION = 0.25


@pytest.mark.parametrize("degrees", [90, 180])
def test_the_tension_grows_exponentially_with_the_angle(degrees, fabric, frames, manual):
    cloth = fabric(
        areal_density=0.5, thickness=THICKNESS, unit_cell=LinearMembrane(warp_stiffness=2.0e4, weft_stiffness=2.0e4),
        bending=IsotropicBending(modulus=1.0e4), transverse_shear_modulus=1.0e5,
        shear=LinearShear(modulus=4.0e6), stabilisation=Stabilisation(),
    )  # fmt: skip
    turn = math.radians(degrees)
    cylinder = Tool("cylinder", Capsule(RADIUS, 0.1), friction=FRICTION)
    forces, simulation = drawn(frames, (strip(cloth, turn),), (cylinder,))
    ratio = float(forces.mean())
    expected = math.exp(FRICTION * turn)
    energies = simulation.frame.energies
    error = abs(energies["balance_error"]) / energies["support_work"]
    assert ratio == pytest.approx(expected, rel=0.003)
    assert error < 0.01
    case = manual(
        "Process", f"A strip drawn over a cylinder by {degrees} degrees",
        known="Euler and Eytelwein: the tension grows by exp(mu theta), with mu = 0.25. A dead load at the tail, the "
        "other end is drawn at 50 mm/s; radius 20 mm, elements of 2 mm.",
    )  # fmt: skip
    case.table(
        ["expected ratio of tensions", "got", "deviation", "balance error / work"],
        [[f"{expected:.5g}", f"{ratio:.5g}", f"{100.0 * (ratio / expected - 1.0):+.2g} %", f"{error:.1e}"]],
    )
