"""A blank on springs at its edges is formed over a hemisphere and released."""

import numpy as np
import pytest

from weavesim.run.guards import Level
from weavesim.run.simulation import Simulation
from weavesim.scenes.grippers import SCENE, GrippersParameters, dome_depth, grippers

FORCE = 20.0


@pytest.fixture(scope="module")
def formed():
    """The run on a coarse mesh, with its frames."""

    class Kept:
        def __init__(self):
            self.all = []

        def start(self, info):
            pass

        def frame(self, frame):
            self.all.append(frame)

        def finish(self, outcome):
            pass

    parameters = GrippersParameters(mesh_size=0.01, gripper_force=FORCE, frame_count=60)
    run, kept = Simulation(grippers(parameters)), Kept()
    run.run([kept])
    return parameters, run, kept.all


def test_the_springs_pull_evenly_slip_and_let_go(formed):
    parameters, _, frames = formed
    force, slip = (np.array([getattr(frame, name) for frame in frames]) for name in ("gripper_force", "gripper_slip"))
    time = np.array([frame.time for frame in frames])
    # the blank and its yarns are the same along both edges
    assert np.abs(force[:, :2] - force[:, 2:]).max() < 0.01 * FORCE
    held = (time > 0.01) & (time < parameters.release_time)
    assert force[held].min() > 0.8 * parameters.pretension and force.max() <= FORCE * (1.0 + 1e-6)
    assert (np.diff(slip, axis=0) >= 0.0).all()
    # those in the middle of an edge have to give way
    assert slip[-1, 0] > 1e-3 > 5e-4 > slip[-1, 1]
    assert np.abs(force[time > parameters.release_time + 1e-3]).max() == 0.0


def test_the_dome_springs_back(formed):
    parameters, run, frames = formed
    blank = run.setup.sheet.blank
    at = [frame for frame in frames if frame.time < parameters.release_time][-1]
    depth = dome_depth(blank, at.position)
    assert 0.5 * parameters.stroke < depth < parameters.stroke
    assert frames[-1].stroke == pytest.approx(0.0, abs=1e-9)
    # without friction inside the fabric nothing keeps it formed
    assert abs(dome_depth(blank, frames[-1].position)) < 0.3 * depth
    found = SCENE.findings(parameters, run, None)
    assert found["dome_depth_mm"] == pytest.approx(1e3 * dome_depth(blank, frames[-1].position))
    assert list(found["gripper_slip_mm"]) == ["gripper_x1", "gripper_x2", "gripper_y1", "gripper_y2"]


def test_the_ledger_closes(formed):
    _, run, frames = formed
    energies = frames[-1].energies
    assert abs(energies["balance_error"]) < 0.01 * energies["supplied"]
    assert energies["gripper_loss"] > FORCE * 1e-3
    assert max((doubt.level for doubt in run.doubts()), default=Level.NOTE) < Level.DO_NOT_USE
