"""Guard of tools that are driven by a force and do not carry it."""

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.errors import InputError
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import ForceDriven, Stroke
from weavesim.run.frame import Outcome
from weavesim.run.guards import Level
from weavesim.tools.shapes import Plane, rotation_matrix
from weavesim.tools.tool import Tool

FACE_DOWN = rotation_matrix((1.0, 0.0, 0.0), np.pi)


def held(gap: float, force: float, ramp: float, mass: float = 0.05, frame_count: int = 1, **given):
    """A sheet on a table under a holder that starts ``gap`` [m] above it; ``given`` are attributes of its motion."""
    table = Tool("table", Plane(origin=(0.0, 0.0, -0.0006)))
    motion = ForceDriven.constant(force, mass, ramp, **given)
    holder = Tool("holder", Plane(origin=(0.0, 0.0, 0.0006 + gap), rotation=FACE_DOWN), motion, axis=(0.0, 0.0, -1.0))
    run = small_run(tools=[table, holder], duration=8e-3, frame_count=frame_count, dynamics=Dynamics(damping=100.0))
    run.run()
    return run


def test_a_running_command_is_told_once(caplog):
    with caplog.at_level("WARNING"):
        held(0.0005, 5.0, 0.0, damping_ratio=0.0)
    said = [record.getMessage() for record in caplog.records if "% of its force" in record.getMessage()]
    assert len(said) == 1 and said[0].startswith("at 0.0") and "holder carries 0 % of its force" in said[0]


def pressed(depth: float, largest_force: float | None):
    """A sheet between a table and a press that would go ``depth`` [m] into it."""
    table = Tool("table", Plane(origin=(0.0, 0.0, -0.0006)))
    motion = Stroke.smooth(depth + 1e-3, 0.5, 5e-4, largest_force=largest_force)
    lid = Tool("lid", Plane(origin=(0.0, 0.0, 0.0006 + 1e-3), rotation=FACE_DOWN), motion, axis=(0.0, 0.0, -1.0))
    run = small_run(tools=[table, lid], duration=5e-3, frame_count=1, dynamics=Dynamics(damping=100.0))
    run.run()
    return run


def test_a_stroke_stops_at_its_largest_force_and_says_so():
    """0.8 mm too deep: refused without a limit, since the tools would meet; with one the press waits at it."""
    with pytest.raises(InputError, match=r"table and lid run into each other .* or give the stroke a largest_force"):
        pressed(1.4e-3, None)
    run = pressed(0.8e-3, 200.0)
    assert run.frame.tool_reaction[1, 2] == pytest.approx(200.0, rel=0.02)
    watch = {name: values[1] for name, values in run.watch.extremes.tools.items()}
    assert watch["peak"] < 2.0 * 200.0
    (doubt,) = [doubt for doubt in run.doubts() if doubt.guard == "waiting_stroke"]
    assert doubt.level == Level.NOTE and "lid is 0.7" in doubt.text and "largest force of 200 N" in doubt.text
    energies = run.frame.energies
    assert abs(energies["balance_error"]) < 0.01 * energies["supplied"]


def test_a_stroke_that_needs_less_than_its_largest_force_is_silent():
    run = pressed(0.0, 200.0)
    assert "waiting_stroke" not in {doubt.guard for doubt in run.doubts()}


def doubt_of(run):
    found = [doubt for doubt in run.doubts() if doubt.guard == "bouncing_holder"]
    return found[0] if found else None


def test_a_holder_that_carries_its_force_is_silent():
    run = held(0.0, 20.0, 4e-3)
    assert doubt_of(run) is None
    watch = {name: values[1] for name, values in run.watch.extremes.tools.items()}
    assert watch["carried_impulse"] == pytest.approx(watch["wanted_impulse"], rel=0.1)


def test_its_damper_keeps_a_holder_from_bouncing():
    run = held(0.0005, 20.0, 0.0)
    watch = {name: values[1] for name, values in run.watch.extremes.tools.items()}
    assert watch["idle"] < 0.05 * watch["wanted"] and watch["peak"] < 10.0 * 20.0
    hard, late = [doubt for doubt in run.doubts() if doubt.guard == "bouncing_holder"]
    assert "N at its peak" in hard.text and "lands hard" in hard.advice
    assert "met the sheet only after 0.001582 s" in late.text and "in_touch" in late.advice
    assert -run.frame.tool_reaction[1, 2] == pytest.approx(-20.0, rel=0.02)


def test_one_that_starts_in_touch_need_not_land():
    run = held(0.01, 20.0, 0.0, in_touch=True)
    assert doubt_of(run) is None
    assert run.frame.tool_displacement[1] == pytest.approx(0.01, rel=0.01)
    watch = {name: values[1] for name, values in run.watch.extremes.tools.items()}
    assert watch["peak"] < 2.0 * 20.0 and watch["waited"] < 1e-3 * watch["wanted"]


def test_one_that_can_touch_nothing_is_refused():
    with pytest.raises(InputError, match="holder: it starts in_touch, but along its axis it meets no sheet within"):
        held(0.01, -20.0, 0.0, in_touch=True)


@pytest.mark.parametrize(("gap", "force"), [(0.002, 20.0), (0.0005, 5.0)])
def test_one_without_a_damper_falls_and_bounces_and_is_doubted_with_its_numbers(gap, force):
    run = held(gap, force, 0.0, damping_ratio=0.0)
    doubt = doubt_of(run)
    assert doubt is not None and doubt.level >= Level.WARNING
    assert "holder carried less than half of its force for" in doubt.text and f"where {force:.4g} N" in doubt.text


def test_it_is_the_same_with_any_number_of_frames():
    few, many = (doubt_of(held(0.002, 20.0, 0.0, frame_count=count)) for count in (1, 40))
    assert few == many


def test_one_that_never_met_the_sheet_does_not_bounce():
    """At its end the run says that it touched nothing; before, that it is not there yet."""
    run = held(0.01, 1.0, 0.0, mass=0.5)
    assert doubt_of(run) is None and run.verdict == "do not use"
    assert "holder never touched a node of the sheet" in {doubt.text for doubt in run.doubts()}
    run.outcome = Outcome.INTERRUPTED
    doubt = doubt_of(run)
    assert doubt.level == Level.DO_NOT_USE and "has not met the sheet yet" in doubt.advice
