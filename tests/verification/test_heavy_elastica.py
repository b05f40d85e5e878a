"""A clamped strip that hangs under its own weight, far beyond small deflections."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from weavesim.blank import Blank
from weavesim.fabric import IsotropicBending, Stabilisation, UnitCell
from weavesim.model import MotionParameters
from weavesim.simulation import Simulation

LENGTH = 0.2
GRAVITY = 9.81


def elastica_tip(load: float) -> tuple[float, float]:
    """Tip (x, drop) over the length of a clamped, inextensible strip with q L^3 / D = ``load``.

    theta is the angle below the horizontal, s the arc length over the length: theta'' = -load (1 - s) cos(theta),
    theta(0) = 0, theta'(1) = 0.
    """
    s = np.linspace(0.0, 1.0, 201)
    guess = np.zeros((4, len(s)))
    for part in np.linspace(0.1, 1.0, 10) * load:
        solution = solve_bvp(
            lambda s, y, part=part: np.array([y[1], -part * (1.0 - s) * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]),
            lambda a, b: np.array([a[0], b[1], a[2], a[3]]),
            s,
            guess,
            tol=1e-8,
            max_nodes=20_000,
        )
        assert solution.success, solution.message
        guess = solution.sol(s)
    return float(guess[2, -1]), float(guess[3, -1])


@pytest.mark.parametrize(("load", "tip"), [(10.0, (0.6564, 0.7002)), (49.0, (0.2482, 0.9068))])
def test_tip_of_a_hanging_strip(load, tip, fabric):
    """40 elements along, one across, nu = 0, by damping the motion out."""
    reference = elastica_tip(load)
    assert reference == pytest.approx(tip, abs=2e-4)

    thickness, areal_density = 1.0e-3, 0.5
    weight = areal_density * GRAVITY  # per area
    bending = weight * LENGTH**3 / load
    # hard enough to stretch by less than 0.05 %, soft enough for a large time step
    laws = fabric(
        areal_density=areal_density, thickness=thickness,
        unit_cell=UnitCell.straight(stiffness_per_width=6000.0 * weight * LENGTH),
        bending=IsotropicBending(modulus=12.0 * bending / thickness**3),
        transverse_shear_modulus=1000.0 * weight * LENGTH / thickness, stabilisation=Stabilisation(),
    )  # fmt: skip
    blank = Blank.rectangle((0.0, 0.0), (LENGTH, 0.005), 0.005)
    assert blank.element_count == 40
    free = np.ones((blank.node_count, 6), dtype=bool)
    free[blank.node_position[:, 0] == 0.0] = False
    # in the plane x z: bent sideways, a single row of elements has nothing but its stabilisation
    free[:, [1, 3, 5]] = False
    # the strip swings about as fast as a pendulum of its length
    damping = 2.0 * np.sqrt(GRAVITY / LENGTH)
    simulation = Simulation(
        name="elastica", blank=blank, fabric=laws, free=free, duration=2.5, frame_count=5, precision="float64",
        lane_count=1, threads=1, motion=MotionParameters(gravity=(0.0, 0.0, -GRAVITY), damping=damping),
    )  # fmt: skip
    simulation.run()

    frame = simulation.frame
    ends = blank.node_position[:, 0] == blank.node_position[:, 0].max()
    found = frame.position[ends].mean(axis=0) / LENGTH
    assert frame.energies["kinetic"] < 1e-6 * frame.energies["internal"]
    assert max(np.abs(frame.fields[f"{yarn}_stretch"] - 1.0).max() for yarn in ("warp", "weft")) < 5e-4
    assert found[0] == pytest.approx(reference[0], abs=0.01)
    assert -found[2] == pytest.approx(reference[1], abs=0.01)
    assert frame.energies["hourglass"] < 1e-3 * frame.energies["internal"]
    # at rest the weight has done the elastic energy's work and what was damped away
    assert abs(frame.energies["balance_error"]) < 1e-3 * frame.energies["gravity_work"]
