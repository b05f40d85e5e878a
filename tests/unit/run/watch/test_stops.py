"""Guards that end a run, by the choice of its user."""

import numpy as np
import pytest

from tests.support.frames import Frames
from tests.support.runs import small_run
from weavesim import Drive, Setup, Simulation, Stroke, Support, run_batch
from weavesim.errors import InputError
from weavesim.run.checkpoint.checkpoints import Checkpoints
from weavesim.run.frame import Outcome
from weavesim.run.guards import Level, known_guards
from weavesim.run.watch.stops import stop_levels
from weavesim.sheet.blank import Blank

BLANK = Blank.rectangle((0.0, 0.0), (0.02, 0.01), 0.005)
LASTING = [name for name, guard in known_guards().items() if guard.lasting]
# Of a guard whose limits are at strains of 10 % and 25 %.
GUARD, LIMITS = "yarn_stretch", {Level.WARNING: 0.1, Level.DO_NOT_USE: 0.25}


def pulled(strain: float = 0.3, frame_count: int = 1) -> Setup:
    """A strip that is pulled slowly, by so much at its end."""
    x = BLANK.node_position[:, 0]
    pull = Drive(Stroke((0.0, 1.0e-3), (0.0, 1.0)), (0.02 * strain, 0.0, 0.0))
    supports = Support("held", np.flatnonzero(x < 1e-9)), Support("pulled", np.flatnonzero(x > 0.0199), (pull,))
    given = {"blank": BLANK, "supports": supports, "duration": 1.0e-3, "frame_count": frame_count}
    return small_run(**given).setup


def ran(setup: Setup, *stop_on: str, **given) -> Simulation:
    simulation = Simulation(setup, stop_on=stop_on)
    simulation.run(**given)
    return simulation


def digest(simulation: Simulation) -> dict[str, bytes]:
    """Every bit of the state."""
    return {name: array.tobytes() for name, array in simulation.state.content().items()}


def test_what_ends_a_run_is_a_guard_or_a_level():
    assert stop_levels([]) == {}
    assert stop_levels([GUARD]) == {GUARD: Level.WARNING}
    assert stop_levels([f"{GUARD}:do-not-use", "energy_balance"]) == {
        GUARD: Level.DO_NOT_USE, "energy_balance": Level.WARNING,
    }  # fmt: skip
    assert stop_levels(["do-not-use"]) == dict.fromkeys(LASTING, Level.DO_NOT_USE)
    assert stop_levels(["do-not-use", GUARD])[GUARD] == stop_levels([GUARD, "do-not-use"])[GUARD] == Level.WARNING


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("yarn_strech", r"guard 'yarn_strech': choose from .*; did you mean 'yarn_stretch'\?"),
        ("note", "choose from warning, do-not-use, between_nodes"),
        ("yarn_stretch:stop", "the level is one of warning, do-not-use"),
        ("kinetic_energy", "judges a run by its end, .* and cannot end it; choose from between_nodes"),
        ("narrow_tool", "before it starts, and cannot end it"),
        ("", "choose from"),
    ],
)
def test_anything_else_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        stop_levels([given])
    with pytest.raises(InputError, match="guard"):
        Simulation(pulled(), stop_on=[given])


def test_a_lone_name_is_no_list():
    with pytest.raises(InputError, match="give a list"):
        stop_levels(GUARD)


def test_guards_that_judge_the_end_cannot_end_a_run():
    """What they say half-way need not be so at the end, or they speak before the run only."""
    assert {"kinetic_energy", "hourglass_energy", "damping_loss", "never_touched", "unloading"}.isdisjoint(LASTING)
    assert "waiting_stroke" not in LASTING
    wanted = {"energy_balance", "unit_cell_failures", "bouncing_holder", "law_range"}
    assert wanted | {GUARD, "self_intersection", "folded_elements", "penetration_at_nodes"} <= set(LASTING)


@pytest.mark.parametrize("level", LIMITS)
@pytest.mark.parametrize("frame_count", [1, 7])
def test_a_guard_ends_a_run_within_a_look_of_it(level, frame_count):
    simulation, frames = (
        Simulation(pulled(0.3, frame_count), stop_on=[f"{GUARD}:{level.label.replace(' ', '-')}"]),
        Frames(),
    )
    assert simulation.run([frames]) is Outcome.STOPPED is simulation.outcome
    (doubt,) = [doubt for doubt in simulation.doubts() if doubt.guard == GUARD]
    assert doubt.level == level and simulation.stops.by.guard == GUARD
    assert LIMITS[level] <= doubt.value < LIMITS[level] + 0.02 and doubt.value == simulation.stops.by.value
    # the frame of its end is the last one
    assert simulation.frame is frames.all[-1] and simulation.frame.time == simulation.state.time == doubt.time
    assert 0.25e-3 < doubt.time < 0.95e-3 and simulation.summary()["outcome"] == "stopped"


def test_it_ends_at_the_same_step_with_any_number_of_frames():
    few, many = (ran(pulled(0.3, count), GUARD) for count in (1, 13))
    assert few.state.step_count == many.state.step_count and digest(few) == digest(many)


def test_nothing_ends_a_run_unless_it_is_wanted_and_said():
    assert ran(pulled(0.3)).outcome is Outcome.FINISHED
    near_miss = ran(pulled(0.09), GUARD, "do-not-use")
    assert near_miss.outcome is Outcome.FINISHED and near_miss.stops.by is None
    other = ran(pulled(0.2), "self_intersection", f"{GUARD}:do-not-use")
    assert other.outcome is Outcome.FINISHED and GUARD in {doubt.guard for doubt in other.doubts()}


def test_a_run_that_ended_goes_on_with_the_bits_of_one_that_did_not(tmp_path):
    whole, frames = Simulation(pulled(0.3, 9)), Frames()
    whole.run([frames])
    ran(pulled(0.3, 9), GUARD, checkpoints=Checkpoints(tmp_path, 1e9))
    # it would end there again
    again, checkpoints = Simulation(pulled(0.3, 9), stop_on=[GUARD]), Checkpoints(tmp_path, 1e9)
    assert checkpoints.find() is not None
    again.stops.pass_over([GUARD])
    again.resume(checkpoints)
    later = Frames()
    assert again.run([later]) is Outcome.FINISHED
    assert digest(again) == digest(whole) and again.history == whole.history
    assert [frame.time for frame in later.all] == [frame.time for frame in frames.all]
    assert again.watch.history == whole.watch.history
    assert [doubt.message for doubt in again.doubts()] == [doubt.message for doubt in whole.doubts()]


def test_a_run_that_is_cut_off_before_ends_there_too(tmp_path):
    class CutOffError(Exception):
        pass

    class CutOff(Frames):
        def frame(self, frame) -> None:
            super().frame(frame)
            if frame.index == 2:
                simulation.checkpoint()
                raise CutOffError

    simulation, stopped = Simulation(pulled(0.3, 9), stop_on=[GUARD]), ran(pulled(0.3, 9), GUARD)
    with pytest.raises(CutOffError):
        simulation.run([CutOff()], checkpoints=Checkpoints(tmp_path, 1e9))
    again, checkpoints = Simulation(pulled(0.3, 9), stop_on=[GUARD]), Checkpoints(tmp_path, 1e9)
    checkpoints.find()
    again.resume(checkpoints)
    assert again.run() is Outcome.STOPPED
    assert digest(again) == digest(stopped) and again.history == stopped.history


def test_variants_of_a_batch_end_alone():
    soft, hard = run_batch([pulled(0.05), pulled(0.3)], threads=1, stop_on=[GUARD])
    assert soft.finished and hard.outcome is Outcome.STOPPED and hard.frame.time < soft.frame.time
    with pytest.raises(InputError, match="guard 'nothing'"):
        run_batch([pulled(0.05)], stop_on=["nothing"])
