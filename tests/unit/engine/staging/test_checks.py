"""Stages that cannot be are refused with the stage, what is there, and the nearest name."""

import re

import numpy as np
import pytest

from tests.support.runs import one_sheet_setup
from weavesim import (
    AtForce,
    AtRest,
    AtStroke,
    Blank,
    Drive,
    Fixed,
    ForceDriven,
    Gripper,
    Plane,
    Pressure,
    SheetPressure,
    SmoothStroke,
    Stage,
    Stroke,
    Support,
    Tool,
    glass_polypropylene,
)
from weavesim.engine.setup import Setup
from weavesim.errors import InputError

DOWN = Stroke((0.0, 0.1), (0.0, 0.02))
FORCE = ForceDriven.constant(20.0, 0.1)


def staged(*stages: Stage, **given):
    """A square between a punch, a holder by force and a die, with supports and a gripper."""
    tools = (
        Tool("punch", Plane(origin=(0.0, 0.0, -0.1)), DOWN),
        Tool("holder", Plane(origin=(0.0, 0.0, -0.1)), FORCE),
        Tool("die", Plane(origin=(0.0, 0.0, -0.01))),
        Tool("stopping", Plane(origin=(0.0, 0.0, -0.1)), Stroke((0.0, 0.1), (0.0, 0.02), 50.0)),
    )
    supports = (Support("edge", np.array([0, 1])), Support("frame", np.array([5]), (Drive(DOWN, (0.0, 0.0, 1.0)),)))
    grippers = (Gripper("spring", np.array([24]), (1.0, 0.0, 0.0), 100.0),)
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005)
    values = {"tools": tools, "supports": supports, "grippers": grippers, "name": "staged", "stages": stages}
    return one_sheet_setup(blank=blank, fabric=glass_polypropylene(), accept_unusual=True, **(values | given))


def test_the_durations_add_up():
    setup = staged(Stage("a", 0.1), Stage("b", 0.25, frame_count=3), frame_count=7)
    assert setup.duration == 0.35 and setup.frame_counts == (2, 3)
    assert type(setup).from_json(setup.to_json()) == setup
    with pytest.raises(InputError, match="the stages take 0.35 s together"):
        staged(*setup.stages, duration=0.3)


@pytest.mark.parametrize(
    ("stages", "message"),
    [
        ((Stage("a", 0.1), Stage("a", 0.1)), "stages: the name 'a' of entry 1"),
        ((Stage("a", 0.1, tools=("pucnh",)),), "stage a: there is no tool 'pucnh'; there are punch, .*'punch'?"),
        ((Stage("a", 0.1, supports=("egde",)),), "stage a: there is no support 'egde'; .*did you mean 'edge'"),
        ((Stage("a", 0.1, grippers=("sprnig",)),), "stage a: there is no gripper 'sprnig'; .*did you mean 'spring'"),
        ((Stage("a", 0.1, moves={"punhc": DOWN}),), "no tool, support or gripper 'punhc'.*did you mean 'punch'"),
        ((Stage("a", 0.1, AtStroke("pnuch", 0.01)),), "stage a: there is no tool 'pnuch'; .*did you mean 'punch'"),
        ((Stage("a", 0.1, pressures=(SheetPressure(Pressure("top", (1.0,)), "sheat"),)),), "did you mean 'sheet'"),
        ((Stage("a", 0.1, pressures=(SheetPressure(Pressure("top", (1.0,), elements=np.array([16])),),)),),
         "stage a: pressure on the top: elements go from 16"),
        ((Stage("a", 0.1, tools=("punch",), moves={"holder": FORCE}),), "holder is moved, but does not act"),
        ((Stage("a", 0.1), Stage("b", 0.1, tools=()), Stage("c", 0.1, tools=("die",))),
         "stage c: tool die acts again, and needs a move"),
        ((Stage("a", 0.1, tools=()),), "stages: tool punch acts in none of them"),
        ((Stage("a", 0.1, grippers=()),), "stage a: gripper spring must pull from the start"),
        ((Stage("a", 0.1), Stage("b", 0.1, grippers=()), Stage("c", 0.1, grippers=("spring",))),
         "stage c: gripper spring cannot pull again"),
        ((Stage("a", 0.1, moves={"punch": Stroke((0.0, 1.0), (0.01, 0.02))}),), "move punch is at 0.01 m when"),
        ((Stage("a", 0.1, moves={"punch": SmoothStroke.ramped(0.1, 1.0, 0.01)}),), "SmoothStroke does not move tools"),
        ((Stage("a", 0.1, moves={"edge": DOWN}),), "move edge: the support has 0 drives"),
        ((Stage("a", 0.1, moves={"frame": Fixed()}),), "a support moves by a Stroke or a SmoothStroke"),
        ((Stage("a", 0.1, moves={"spring": FORCE}),), "a Stroke without a largest_force, Fixed, or a PathMotion"),
        # ends that cannot come
        ((Stage("a", 0.1, AtStroke("punch", 0.03)),), "at a stroke of 0.03 m: punch moves by at most 0.02"),
        ((Stage("a", 0.1, AtStroke("punch", -0.01)),), "at a stroke of -0.01 m: punch moves by at most 0 m"),
        ((Stage("a", 0.1, AtStroke("die", 0.01)),), "die moves by at most 0 m"),
        ((Stage("a", 0.05), Stage("b", 0.1, AtStroke("punch", 0.021))), "stage b: it can never end at a stroke"),
        ((Stage("a", 0.1), Stage("b", 0.1, AtForce("die", 5.0), tools=("punch",))), "can never end by die, which"),
        ((Stage("a", 0.1, AtForce("holder", 21.0)),), "can never end at 21 N: holder is pushed by at most 20 N"),
        ((Stage("a", 0.1, AtForce("stopping", 60.0)),), "stopping is pushed by at most 50 N"),
        ((Stage("a", 0.1, AtRest()),), "can never come to rest: punch moves for all of its 0.1 s"),
    ],
)  # fmt: skip
def test_stages_that_cannot_be_are_refused(stages, message):
    with pytest.raises(InputError, match=message):
        staged(*stages)


def test_a_run_in_stages_has_no_other_rest():
    from weavesim import Rest

    with pytest.raises(InputError, match=re.escape("rest: with stages, let the last one end AtRest")):
        staged(Stage("a", 0.1), rest=Rest(0.0, 1e-3))


def test_ends_that_may_come_are_taken():
    """A stroke that has begun in a stage before may be anywhere, since that may end earlier."""
    staged(Stage("a", 0.05, AtForce("die", 1.0)), Stage("b", 0.1, AtStroke("punch", 0.019)))
    staged(Stage("a", 0.2, AtRest()))
    staged(Stage("a", 0.1, AtForce("die", 1e6)), Stage("b", 0.1, AtForce("holder", 20.0)))


def test_tools_of_two_worlds_need_names_of_their_own():
    """Stages say by name what acts: of two tools of one name, both would get the motion of the last."""
    one = staged(Stage("a", 0.1))
    (world,) = one.worlds
    sheets = tuple(sheet.model_copy(update={"name": "other", "supports": (), "grippers": ()}) for sheet in world.sheets)
    other = world.model_copy(update={"name": "second", "sheets": sheets})
    with pytest.raises(InputError, match="tools: the name '.*' of entry"):
        Setup("two", (world, other), stages=one.stages, accept_unusual=True)
