"""Guard of tools that are driven by a force and do not carry it."""

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.process.dynamics import Dynamics
from weavesim.process.strokes import ForceDriven
from weavesim.run.frame import Outcome
from weavesim.run.guards import Level
from weavesim.tools.shapes import Plane, rotation_matrix
from weavesim.tools.tool import Tool

FACE_DOWN = rotation_matrix((1.0, 0.0, 0.0), np.pi)


def held(gap: float, force: float, ramp: float, mass: float = 0.05, duration: float = 8e-3, frame_count: int = 1):
    """A sheet on a table under a holder that starts ``gap`` [m] above it."""
    table = Tool("table", Plane(origin=(0.0, 0.0, -0.0006)))
    motion = ForceDriven.constant(force, mass, ramp)
    holder = Tool("holder", Plane(origin=(0.0, 0.0, 0.0006 + gap), rotation=FACE_DOWN), motion, axis=(0.0, 0.0, -1.0))
    run = small_run(tools=[table, holder], duration=duration, frame_count=frame_count, dynamics=Dynamics(damping=100.0))
    run.run()
    return run


def doubt_of(run):
    found = [doubt for doubt in run.doubts() if doubt.guard == "bouncing_holder"]
    return found[0] if found else None


def test_a_holder_that_carries_its_force_is_silent():
    run = held(0.0, 20.0, 4e-3, mass=0.5)
    assert doubt_of(run) is None
    watch = {name: values[1] for name, values in run.watch.extremes.tools.items()}
    assert watch["carried_impulse"] == pytest.approx(watch["wanted_impulse"], rel=0.1)


@pytest.mark.parametrize(("gap", "force"), [(0.01, 50.0), (0.002, 20.0), (0.0005, 5.0)])
def test_one_that_falls_and_bounces_is_doubted_with_its_numbers(gap, force):
    run = held(gap, force, 0.0)
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
