"""Nodes held at a velocity pull a strip: their work is in the ledger."""

import numpy as np

from weavesim.blank import Blank
from weavesim.fabric import glass_polypropylene
from weavesim.model import MotionParameters
from weavesim.simulation import Simulation


def test_work_of_moving_supports_closes_the_balance():
    blank = Blank.rectangle((0.0, 0.0), (0.1, 0.05), 0.01)
    free = np.ones((blank.node_count, 6), dtype=bool)
    x = blank.node_position[:, 0]
    ends = (x < 1e-9) | (x > 0.1 - 1e-9)
    free[ends] = False
    velocity = np.zeros((blank.node_count, 3))
    velocity[x > 0.1 - 1e-9, 0] = 0.5
    # the rest starts along, so that no wave is launched
    velocity[:, 0] = 0.5 * x / 0.1
    simulation = Simulation(
        name="strip", blank=blank, fabric=glass_polypropylene(), duration=4e-3, free=free, initial_velocity=velocity,
        motion=MotionParameters(damping=50.0), precision="float64", lane_count=1, frame_count=10,
    )  # fmt: skip
    simulation.run()
    energies = simulation.frame.energies
    assert energies["support_work"] > 10.0 * energies["initial_kinetic"]
    assert abs(energies["balance_error"]) < 2e-3 * energies["supplied"]
    # 2 mm of 100 mm in 4 ms
    np.testing.assert_allclose(simulation.frame.fields["warp_stretch"].mean(), 1.02, atol=1e-3)
