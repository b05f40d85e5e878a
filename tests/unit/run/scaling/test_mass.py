"""The largest mass scaling that keeps a stated error."""

import logging

import numpy as np
import pytest

from weavesim.engine.model import Model
from weavesim.engine.setup import Setup, Solver
from weavesim.errors import InputError, RunError
from weavesim.fabric import glass_polypropylene
from weavesim.process.dynamics import Dynamics
from weavesim.process.scaling.mass import MassScaling
from weavesim.process.strokes import Stroke
from weavesim.run.guards import Level
from weavesim.run.scaling import mass
from weavesim.run.scaling.mass import COARSENING, choose_mass_scaling, with_mass_scaling
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools.shapes import Sphere
from weavesim.tools.tool import Tool

SIZE = 0.008


def pressed(mesh_size: float, target_step: float | None) -> Setup:
    """A quarter of a small free sheet that a ball pushes."""
    fabric = glass_polypropylene()
    half = 0.5 * fabric.thickness
    ball = Tool("ball", Sphere(0.02, origin=(0.0, 0.0, 0.02 + half)), Stroke.smooth(0.006, 0.5, 4e-3),
                axis=(0.0, 0.0, -1.0))  # fmt: skip
    return Setup(
        "pressed", sheets=(Sheet(Blank.rectangle((0.0, 0.0), (0.036, 0.036), mesh_size), fabric),),
        tools=(ball,), symmetry=("x", "y"), duration=0.02, frame_count=1,
        dynamics=Dynamics(damping=100.0),
        solver=Solver(precision="float64", lane_count=1, threads=1, target_step=target_step),
    )  # fmt: skip


def test_the_largest_factor_within_both_tolerances_is_chosen():
    found = choose_mass_scaling(pressed, SIZE, angle_tolerance=5.0, draw_in_tolerance=0.02, factors=(1.5, 2.0))
    assert [each.accepted for each in found.tries] == [True, True] and found.factor == 2.0
    assert found.coarse_size == pytest.approx(COARSENING * SIZE)
    assert found.tries[1].speed_up == pytest.approx(2.0, rel=0.1)
    # the step of the run itself, not that of the coarse mesh
    assert found.target_step == pytest.approx(2.0 * Model(pressed(SIZE, None)).reference_step)
    text = found.report()
    assert "chosen: step x 2" in text and "step x 1.5 (mass x 2.25)" in text


def test_the_search_ends_where_a_tolerance_is_lost(caplog):
    errors = choose_mass_scaling(pressed, SIZE, angle_tolerance=5.0, draw_in_tolerance=0.02, factors=(2.0, 6.0)).tries
    assert errors[1].angle_error > errors[0].angle_error > 0.0 < errors[0].draw_in_error
    between = 0.5 * (errors[0].angle_error + errors[1].angle_error)
    found = choose_mass_scaling(
        pressed, SIZE, angle_tolerance=between, draw_in_tolerance=0.02, factors=(2.0, 6.0, 9.0)
    )  # fmt: skip
    assert [each.accepted for each in found.tries] == [True, False] and found.factor == 2.0
    assert "too much" in found.report()
    found = choose_mass_scaling(pressed, SIZE, draw_in_tolerance=1e-12, factors=(2.0, 6.0))
    assert found.target_step is None and found.factor == 1.0 and "no scaling keeps" in found.report()
    # what guards say of the tries is not said of a run
    assert not [record for record in caplog.records if record.levelno >= logging.WARNING]


@pytest.mark.parametrize("given", [{"factors": ()}, {"factors": (1.0, 2.0)}, {"factors": (3.0, 2.0)}])
def test_factors_that_cannot_be_are_refused(given):
    with pytest.raises(InputError, match="increasing numbers above 1"):
        choose_mass_scaling(pressed, SIZE, **given)
    with pytest.raises(InputError, match="angle_tolerance"):
        choose_mass_scaling(pressed, SIZE, angle_tolerance=0.0)


def test_a_run_tells_how_its_scaling_was_found_and_repeats_from_what_it_tells():
    found = choose_mass_scaling(pressed, SIZE, angle_tolerance=5.0, draw_in_tolerance=0.02, factors=(2.0,))
    run = Simulation(with_mass_scaling(pressed(SIZE, None), found))
    run.run()
    told = run.summary()["mass_scaling"]
    assert told["target_step_s"] == found.target_step and told["factor"] == 2.0
    assert told["angle_tolerance_deg"] == 5.0 and told["tries"][0]["draw_in_error_m"] == found.tries[0].draw_in_error
    assert any("chosen: step x 2" in note for note in run.info.notes)
    # from the set-up that it keeps, and from the numbers of its summary
    for again in (Setup.from_json(run.setup.to_json()), pressed(SIZE, told["target_step_s"])):
        other = Simulation(again)
        other.run()
        assert np.array_equal(other.frame.position, run.frame.position)
        assert other.state.step_count == run.state.step_count
    assert run.summary()["added_mass_ratio"] > 0.05
    doubts = {doubt.guard: doubt for doubt in run.doubts()}
    assert doubts["added_mass"].level is Level.NOTE and "stated error" in doubts["added_mass"].advice
    # the same run without the words is warned of
    assert next(each for each in other.doubts() if each.guard == "added_mass").level is Level.WARNING


def test_a_step_that_was_not_found_is_refused():
    found = choose_mass_scaling(pressed, SIZE, angle_tolerance=5.0, draw_in_tolerance=0.02, factors=(2.0,))
    with pytest.raises(InputError, match="mass_scaling found target_step"):
        Solver(mass_scaling=found, target_step=2.0 * found.target_step)


def test_a_mesh_that_has_one_size_and_a_given_step_are_refused():
    with pytest.raises(InputError, match="sheet sheet: its mesh does not depend on the mesh size"):
        choose_mass_scaling(lambda size, step: pressed(SIZE, step), SIZE)

    def stepped(size: float, step: float | None) -> Setup:
        setup = pressed(size, step)
        return setup.model_copy(update={"solver": setup.solver.model_copy(update={"time_step": 1e-7})})

    with pytest.raises(InputError, match="time_step"):
        choose_mass_scaling(stepped, SIZE)


def test_a_run_that_stops_is_too_much(monkeypatch):
    real = mass._run

    def stops(setup: Setup) -> Simulation:
        if setup.solver.target_step is not None:
            raise RunError("no longer finite")
        return real(setup)

    monkeypatch.setattr(mass, "_run", stops)
    found = choose_mass_scaling(pressed, SIZE, factors=(2.0, 3.0))
    assert found.factor == 1.0 and len(found.tries) == 1 and "the run stopped: too much" in found.report()
    assert MassScaling.from_json(found.to_json()) == found
