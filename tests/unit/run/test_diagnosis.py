"""Where and why a state became non-finite."""

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.kernels.rows import ClockEntry, MotionRow
from weavesim.run.diagnosis import find_failure


@pytest.mark.parametrize("node", [0, 12, 24])
def test_the_suspect_is_at_the_node_that_is_lost(node):
    simulation = small_run()
    assert find_failure(simulation.model, simulation.state, simulation.frame) is None
    (model,), (state,) = simulation.model.sheets, simulation.state.sheets
    motion = model.read_motion(state.motion)
    motion[MotionRow.position.vector][node] = np.nan
    model.write_motion(state.motion, motion)
    failure = find_failure(simulation.model, simulation.state, simulation.frame)
    assert failure is not None and failure.sheet == "sheet" and failure.time == 0.0
    assert np.hypot(*(np.array(failure.place) - model.blank.node_position[node, :2])) < 0.005
    assert "non-finite after 0 steps" in failure.text and "the last good frame is 0" in failure.text


@pytest.mark.parametrize("step", [np.nan, np.inf, 0.0, -1e-6])
def test_a_step_that_is_none_is_a_failure(step):
    simulation = small_run()
    clock = simulation.state.clock.numpy()
    clock[ClockEntry.step] = step
    simulation.state.clock.assign(clock)
    failure = find_failure(simulation.model, simulation.state, simulation.frame)
    assert failure is not None and "is the first suspect" in failure.text
