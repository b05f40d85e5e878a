"""The registry of guards, what a doubt says, and what a run makes of it."""

import json

import pytest

from tests.support.runs import small_run
from weavesim.errors import InputError
from weavesim.output.files import plain
from weavesim.run.guards import Doubt, Guard, Level, known_guards, verdict_of
from weavesim.run.guards import guard as guard_module


@pytest.fixture
def guards_forgotten():
    """What is defined during a test is unknown afterwards."""
    before = dict(known_guards())
    yield
    guard_module._known.clear()
    guard_module._known.update(before)


def test_every_guard_has_a_name_and_says_what_it_watches():
    for name, guard in known_guards().items():
        assert guard.name == name and guard.watches and guard.__doc__


def test_two_guards_of_one_name_are_refused(guards_forgotten):
    with pytest.raises(TypeError, match="guard energy_balance: .*energy already has one of this name"):
        type("Other", (Guard,), {"name": "energy_balance"})


def test_a_doubt_says_what_where_when_and_what_to_do():
    doubt = Doubt("fold", Level.WARNING, "1 folded element", "refine", "upper", (0.1, 0.02), 0.5, 1.0, 0.0)
    assert doubt.message == ("1 folded element (sheet upper, at (0.1, 0.02) m on the flat blank, at 0.5 s): refine")
    assert json.loads(json.dumps(plain(doubt.as_dict()))) == {
        "guard": "fold", "level": "warning", "text": "1 folded element", "advice": "refine", "sheet": "upper",
        "place_m": [0.1, 0.02], "time_s": 0.5, "value": 1.0, "limit": 0.0, "message": doubt.message,
    }  # fmt: skip
    assert Doubt("fold", Level.NOTE, "1 folded element").message == "1 folded element"


@pytest.mark.parametrize(
    ("levels", "verdict"),
    [
        ([], "trusted"),
        ([Level.NOTE], "trusted"),
        ([Level.WARNING, Level.NOTE], "doubtful"),
        ([Level.WARNING, Level.DO_NOT_USE], "do not use"),
    ],
)
def test_the_verdict_is_the_worst_level(levels, verdict):
    assert verdict_of(Doubt("one", level, "text") for level in levels) == verdict


def test_what_a_guard_says_reaches_every_output_of_a_run(guards_forgotten):
    class Everything(Guard):
        """Speaks at every occasion."""

        name = "everything"
        watches = "everything"
        seen = 0

        def before(self, start):
            yield self.doubt(Level.NOTE, f"{start.frame.index} steps so far")

        def watch(self, frame, ledger):
            self.seen += 1

        def after(self, run):
            yield self.doubt(Level.WARNING, "the run ended", "look again", time=run.run.frame.time)

    simulation = small_run()
    assert simulation.info.notes == ("0 steps so far",)
    simulation.run()
    own = [doubt for doubt in simulation.doubts() if doubt.guard == "everything"]
    assert [doubt.level for doubt in own] == [Level.WARNING, Level.NOTE]
    assert own[0].message in simulation.warnings and "0 steps so far" not in simulation.warnings
    summary = simulation.summary()
    assert summary["verdict"] == simulation.verdict == "doubtful" and not simulation.trusted
    assert [doubt for doubt in summary["doubts"] if doubt["guard"] == "everything"] == [d.as_dict() for d in own]


def test_a_guard_that_fails_is_a_doubt_and_stops_nothing(guards_forgotten):
    class Broken(Guard):
        """Fails always."""

        name = "broken"
        watches = "nothing"

        def after(self, run):
            raise ZeroDivisionError("by zero")

    simulation = small_run()
    simulation.run()
    (doubt,) = (doubt for doubt in simulation.doubts() if doubt.guard == "broken")
    assert doubt.level == Level.WARNING and "failed (ZeroDivisionError: by zero)" in doubt.message


def test_a_guard_may_refuse_a_run(guards_forgotten):
    class Strict(Guard):
        """Refuses."""

        name = "strict"
        watches = "everything"

        def before(self, start):
            raise InputError(f"a duration of {start.model.setup.duration} s is no good")

    with pytest.raises(InputError, match="is no good"):
        small_run(duration=1e-5)


def test_nothing_is_said_of_a_small_sound_run():
    simulation = small_run()
    simulation.run()
    assert simulation.doubts() == [] and simulation.trusted and simulation.verdict == "trusted"
