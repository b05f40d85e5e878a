"""What a run looks at does not depend on its frames."""

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim import Simulation
from weavesim.errors import InputError
from weavesim.run.watch.watch import WATCH_COUNT
from weavesim.tools.shapes import Plane
from weavesim.tools.tool import Tool

VERDICT = (
    "kinetic_energy_ratio", "hourglass_energy_ratio", "energy_balance_error", "damping_loss_ratio", "verdict", "doubts",
    "penetration_at_nodes_mm", "penetration_of_surface_mm", "penetration_at_element_centres_mm",
    "max_shear_angle_deg", "energies_j", "step_count",
    "max_shear_angle_of_run_deg", "beyond_symmetry_mm", "most_self_intersections", "peak_tool_force_n",
)  # fmt: skip


def pulled(frame_count: int):
    """A square whose right half moves away, and comes back, above a table that it does not touch."""
    velocity = np.zeros((25, 3))
    velocity[:, 0] = 20.0 * np.linspace(0.0, 1.0, 5).repeat(5)
    table = Tool("table", Plane(origin=(0.0, 0.0, -0.001)))
    simulation = small_run(initial_velocity=velocity, duration=4e-4, frame_count=frame_count, tools=[table])
    simulation.run()
    return simulation


@pytest.fixture(scope="module")
def runs():
    return [pulled(frame_count) for frame_count in (1, 7, 80)]


def test_the_verdict_is_that_of_any_number_of_frames(runs):
    first, *others = ({key: run.summary()[key] for key in VERDICT} for run in runs)
    assert first["kinetic_energy_ratio"] > 0.0
    for other in others:
        assert other == first


def test_the_same_states_are_looked_at(runs):
    first, *others = (run.watch.history for run in runs)
    assert len(first) <= WATCH_COUNT + 1 and len(first) > 10
    for other in others:
        assert other == first


def test_states_are_about_evenly_spaced(runs):
    time = np.array([entry["time"] for entry in runs[0].watch.history])
    step = runs[0].state.step
    assert np.diff(time).max() < 4e-4 / WATCH_COUNT + 21 * step and np.diff(time).min() > 0.0


@pytest.mark.parametrize("count", [20, 200])
def test_a_run_that_goes_on_has_the_looks_that_it_began_with(count):
    """Also one with another number of them: a time in the past would be waited for without end."""
    setup = small_run(duration=4e-4).setup
    begun, other = Simulation(setup, watch_count=count), Simulation(setup)
    begun.run()
    other.run()
    assert other.watch.next_time != begun.watch.next_time
    other.watch.recall(begun.watch.memory())
    assert other.watch.next_time == begun.watch.next_time


def test_a_state_that_was_looked_at_is_not_waited_for(runs):
    """A run that goes on may begin with it."""
    run = runs[0]
    memory = run.watch.memory()
    run.watch.recall({**memory, "next": 1})
    run.watch.look(run.frame)
    assert run.watch.next_time > run.frame.time and len(run.watch.history) == len(memory["history"])


@pytest.mark.parametrize("count", [-1, 0, 20_000])
def test_an_impossible_number_of_looks_is_refused(count):
    with pytest.raises(InputError, match=f"watch_count = {count}: 1 to"):
        Simulation(small_run().setup, watch_count=count)
