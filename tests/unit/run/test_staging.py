"""Runs in stages: the same bits as without, as in a script, and after a resume; ends, and what is booked."""

import logging

import numpy as np
import pytest

from tests.support.every_kind import IN_LANES, ONE_LANE, in_stages, pressed
from tests.support.frames import Frames
from weavesim import (
    AtForce,
    AtRest,
    AtStroke,
    Dynamics,
    Fixed,
    Model,
    Simulation,
    Sphere,
    Stage,
    Stepper,
    Stroke,
    Tool,
)
from weavesim.errors import RunError
from weavesim.run.checkpoint import checkpoints as module
from weavesim.run.checkpoint.checkpoints import Checkpoints
from weavesim.run.frame import Outcome

DURATION = 6e-4
BALL = Sphere(0.02, origin=(0.0, 0.0, -0.0206))


def bits(state) -> dict[str, bytes]:
    return {name: array.numpy().tobytes() for name, array in state.arrays()}


def plain(**given):
    """A strip that falls on a ball that rises, under a weight that a force moves."""
    return pressed(ONE_LANE, [BALL]).model_copy(update={"duration": DURATION, "frame_count": 4} | given)


def staged(*stages: Stage, **given):
    return plain(stages=stages, duration=sum(stage.duration for stage in stages), **given)


def ran(setup) -> Simulation:
    simulation = Simulation(setup)
    assert simulation.run() is Outcome.FINISHED
    return simulation


@pytest.fixture(scope="module")
def whole():
    return ran(plain())


def test_stages_that_change_nothing_leave_every_bit(whole):
    simulation = ran(staged(Stage("a", 0.25 * DURATION), Stage("b", 0.5 * DURATION), Stage("c", 0.25 * DURATION)))
    assert bits(simulation.state) == bits(whole.state)
    last = simulation.frame.energies
    assert last.pop("stage_work") == 0.0 and last == whole.frame.energies
    assert [stage["ended_by"] for stage in simulation.stages.ended] == 3 * ["duration"]


def test_three_stages_are_a_script_of_three_parts():
    """The script knows nothing of stages: it makes a set-up of each part, on the state of the part before."""
    third = DURATION / 3.0
    back = Stroke((0.0, 1e-4), (0.0, -2e-5))
    simulation = ran(staged(
        Stage("close", third),
        Stage("back", third, moves={"rising 0": back}, damping=200.0),
        Stage("still", third, moves={"rising 0": Fixed(), "weight": Fixed()}, gravity=(0.0, 1.0, -9.81)),
    ))  # fmt: skip
    first = ran(plain(duration=third))
    state, setup, world = first.state, first.setup, first.setup.worlds[0]
    for damping, gravity, still in ((200.0, (0.0, 0.0, -9.81), False), (200.0, (0.0, 1.0, -9.81), True)):
        time, place = state.time, state.tool_displacement.numpy().tolist()
        ball = Stroke((time,), (place[0],)) if still else Stroke((time, time + 1e-4), (place[0], place[0] - 2e-5))
        tools = [world.tools[0].model_copy(update={"motion": ball}), *world.tools[1:]]
        if still:
            tools[1] = tools[1].model_copy(update={"motion": Stroke((time,), (place[1],))})
        dynamics = Dynamics(gravity=gravity, damping=damping)
        part = world.model_copy(update={"tools": tuple(tools), "dynamics": dynamics})
        drive = state.tool_drive.numpy()
        drive[:, : 1 + still] = np.array([[0.0], [time]])
        state.tool_drive.assign(drive)
        stepper = Stepper(Model(setup.model_copy(update={"worlds": (part,)})), state)
        stepper.advance_to(third * (3 if still else 2))
    assert bits(simulation.state) == bits(state)
    last = simulation.frame.energies
    assert abs(last["balance_error"]) < 0.02 * last["used"]


def test_threads_and_frames_change_no_bit(of_every_kind):
    setup = in_stages(IN_LANES)
    stages = tuple(stage.model_copy(update={"frame_count": 3}) for stage in setup.stages)
    solver = setup.solver.model_copy(update={"threads": 1})
    simulation = ran(setup.model_copy(update={"stages": stages, "solver": solver}))
    assert bits(simulation.state) == bits(of_every_kind[0].state)
    assert simulation.watch.history == of_every_kind[0].watch.history
    assert simulation.stages.ended == of_every_kind[0].stages.ended


@pytest.fixture(scope="module")
def of_every_kind():
    simulation, frames = Simulation(in_stages(IN_LANES)), Frames()
    simulation.run([frames])
    return simulation, frames.all


def test_a_run_goes_on_in_any_stage(tmp_path, monkeypatch, of_every_kind):
    """From the last checkpoints of every stage, to the bit, and with all that it knew."""
    monkeypatch.setattr(module, "LARGEST_SHARE", 1e9)
    monkeypatch.setattr(module, "KEPT_COUNT", 10_000)
    Simulation(in_stages(IN_LANES)).run(checkpoints=Checkpoints(tmp_path, 1e-9))
    reference, frames = of_every_kind
    folder, met = tmp_path / module.FOLDER_NAME, set()
    for path in sorted(folder.glob("0*.bin"), reverse=True)[::12]:
        for later in folder.glob("0*.bin"):
            if later.name > path.name:
                later.unlink()
        checkpoints, again, shown = Checkpoints(tmp_path), Simulation(in_stages(IN_LANES)), Frames()
        assert checkpoints.find() is not None
        again.resume(checkpoints)
        met.add(again.stages.name)
        assert again.run([shown]) is Outcome.FINISHED
        assert bits(again.state) == bits(reference.state)
        assert again.history == reference.history and again.watch.history == reference.watch.history
        assert again.stages.ended == reference.stages.ended and again.stages.trimmed == reference.stages.trimmed
        kept, wanted = again.stages.frames, reference.stages.frames
        assert {name: frame.time for name, frame in kept.items()} == {
            name: frame.time for name, frame in wanted.items()
        }
        assert [frame.stage for frame in shown.all] == [frame.stage for frame in frames]
    assert len(met) >= 2


def test_frames_tell_their_stage_and_what_acts(of_every_kind):
    simulation, frames = of_every_kind
    assert list(dict.fromkeys(frame.stage for frame in frames)) == ["close", "hold", "release", "carry on"]
    assert [frame.index for frame in frames] == list(range(len(frames)))
    acts = {frame.stage: frame.tool_acts.tolist() for frame in frames}
    assert acts == {
        "close": [True, False], "hold": [True, True], "release": [False, False], "carry on": [False, True]
    }  # fmt: skip
    assert simulation.info.frame_count == 6


def test_a_tool_that_no_longer_acts_takes_its_springs_with_it():
    stages = Stage("close", 3e-4), Stage("free", 3e-4, tools=())
    simulation = Simulation(staged(*stages, frame_count=20))
    frames = Frames()
    simulation.run([frames])
    last = [frame for frame in frames.all if frame.stage == "close"][-1]
    free = [frame for frame in frames.all if frame.stage == "free"]
    springs = last.energies["contact"] + last.energies["friction_spring"]
    assert springs > 1e-9 and np.abs(last.tool_reaction).max() > 0.1
    for frame in free:
        assert frame.energies["contact"] == frame.energies["friction_spring"] == 0.0 and not frame.tool_reaction.any()
        # the weight's kinetic energy goes with it too
        lost = springs + last.energies["tool_kinetic"]
        assert frame.energies["stage_work"] == pytest.approx(-lost, rel=1e-4)
    work = last.energies["supplied"]
    errors = [abs(frame.energies["balance_error"] - last.energies["balance_error"]) for frame in free]
    assert max(errors) < 1e-3 * work
    # where nothing pushes, the sheet falls: it is where gravity takes it
    assert np.ptp([frame.sheet.position[:, 2].mean() for frame in free]) > 0.0


def test_a_stroke_ends_a_stage_within_a_thousandth():
    simulation = ran(staged(Stage("close", DURATION, AtStroke("rising 0", 1e-4)), Stage("then", 1e-5)))
    (told, _), end = simulation.stages.ended, simulation.stages.begins[1]
    assert told["ended_by"] == "stroke" and told["reached"]
    # 0.5 m/s, and a block of 20 steps
    step = simulation.state.step
    assert 1e-4 <= end.tools[0] <= 1e-4 + 0.5 * (1e-3 * DURATION + 21.0 * step)
    assert end.time == end.planned == told["end_s"]


def test_a_force_ends_a_stage():
    frames = Frames()
    simulation = Simulation(staged(Stage("close", DURATION, AtForce("rising 0", 0.5)), Stage("then", 1e-5)))
    simulation.run([frames])
    assert simulation.stages.ended[0]["ended_by"] == "force" and simulation.stages.ended[0]["end_s"] < DURATION
    last = [frame for frame in frames.all if frame.stage == "close"][-1]
    assert abs(last.tool_reaction[0, 2]) >= 0.5


def test_rest_that_never_comes_is_said_with_time_and_advice(caplog):
    end = AtRest(1e-12, 1e-9)
    stages = Stage("close", 1e-4), Stage("swing", 1e-4, end, moves={"rising 0": Fixed()}), Stage("then", 1e-5)
    with caplog.at_level(logging.WARNING, "weavesim"):
        simulation = ran(staged(*stages))
    (doubt,) = [doubt for doubt in simulation.doubts() if doubt.guard == "stage_ends"]
    assert (
        "stage swing took all of its 0.0001 s: rest never came" in doubt.message
        and f"at {simulation.stages.begins[2].time:.4g} s" in doubt.message
    )
    assert "give it more damping or a longer duration" in doubt.message and doubt.message in simulation.warnings
    assert "stage swing took all of its" in caplog.text
    begins = [k for k, record in enumerate(caplog.records) if "stage swing took all of its time" in record.message]
    assert begins and begins[0] < next(k for k, record in enumerate(caplog.records) if doubt.text in record.message)
    assert simulation.stages.ended[1]["reached"] is False


def test_a_sheet_at_rest_ends_a_stage_after_three_looks():
    simulation = ran(staged(Stage("still", DURATION, AtRest(1e3, 1e3), moves={"rising 0": Fixed()})))
    told = simulation.stages.ended[0]
    assert told["ended_by"] == "rest" and told["end_s"] == simulation.frame.time
    assert "stage_ends" not in {doubt.guard for doubt in simulation.doubts()}
    # looks are a hundredth apart, or a block of 20 steps
    assert 0.03 * DURATION <= told["end_s"] <= 3.0 * (0.01 * DURATION + 21.0 * simulation.state.step)


def test_a_rest_without_damping_is_doubted_before():
    given = Stage("still", DURATION, AtRest(), moves={"rising 0": Fixed()}, damping=0.0)
    (doubt,) = [doubt for doubt in Simulation(staged(given)).prepare().guards.first if doubt.guard == "stage_ends"]
    assert "stage still ends at rest, but has no damping" in doubt.message


def test_a_tool_that_arrives_within_the_sheet_stops_the_run():
    setup = plain()
    world = setup.worlds[0]
    inside = Tool("inside", Sphere(0.02, origin=(0.0, 0.0, -0.0199)))
    world = world.model_copy(update={"tools": (*world.tools, inside)})
    names = tuple(tool.name for tool in world.tools)
    stages = Stage("close", 1e-4, tools=names[:-1]), Stage("late", 1e-4, tools=names)
    setup = setup.model_copy(update={"worlds": (world,), "stages": stages, "duration": 2e-4})
    with pytest.raises(RunError, match="stage late: inside begins to act at .* s, where it overlaps sheet sheet by"):
        Simulation(setup).run()
