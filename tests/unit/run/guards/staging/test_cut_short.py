"""Motions, pressures and releases that a stage or a run does not leave enough time for."""

import pytest

from tests.support.runs import small_run
from weavesim import AtForce, Fixed, ForceDriven, Gripper, PathMotion, Pressure, Stage, Stroke, Tool
from weavesim.run.guards import Level
from weavesim.tools.shapes import Sphere

END = 1e-5


FORCE = ForceDriven.constant(1.0, 1e-3)


def ball(motion):
    return Tool("ball", Sphere(0.012, origin=(0.01, 0.01, -0.0126)), motion)


def notes(**given):
    found = [doubt for doubt in small_run(**given).doubts() if doubt.guard == "cut_short"]
    assert all(doubt.level == Level.NOTE and doubt.advice for doubt in found)
    return [doubt.text for doubt in found]


def gripped(**given):
    return Gripper("clamp", [20, 24], (1.0, 0.0, 0.0), 1e3, **given)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"tools": [ball(Stroke((0.0, 4 * END), (0.0, 4e-4)))]}, "ball is to move until 4e-05 s, 0.3 of its 0.4 mm"),
        ({"tools": [ball(Stroke((2 * END, 3 * END), (0.0, 4e-4)))]}, "0.4 of its 0.4 mm are missing"),
        (
            {"tools": [ball(PathMotion((0.0, 2 * END), ((0.0, 0.0, 0.0), (1e-4, 0.0, 0.0))))]},
            "ball is to move along its path or to turn until 2e-05 s",
        ),
        (
            {"tools": [ball(PathMotion((0.0, 2 * END), ((0.0, 0.0, 0.0), (1e-4, 0.0, 0.0)), None, FORCE))]},
            "ball is to move along its path or to turn until 2e-05 s",
        ),
        ({"tools": [ball(Stroke((0.0, 4 * END, 8 * END), (0.0, 4e-4, 0.0)))]}, "0.3 of its 0.4 mm are missing"),
        ({"grippers": [gripped(motion=Stroke((0.0, 2 * END), (0.0, 1e-4)))]}, "clamp is to move until 2e-05 s"),
        ({"grippers": [gripped(release_time=1.0)]}, "clamp is to open at 1 s, and the run ends at 1e-05 s"),
        (
            {"pressures": [Pressure("top", (0.0, 1e3), (0.0, 4 * END))]},
            "the pressure on the top of sheet is to reach 1000 Pa at 4e-05 s, it is at 250 Pa",
        ),
    ],
)  # fmt: skip
def test_what_is_not_over_at_the_end_is_noted(given, text):
    (note,) = notes(**given)
    assert text in note


@pytest.mark.parametrize(
    "given",
    [
        {"tools": [ball(Stroke((0.0, END), (0.0, 4e-4)))]},
        {"tools": [ball(Stroke((0.0, 1.0), (0.0, 4e-4), 5.0))]},  # it waits at its force
        {"tools": [ball(Fixed())]},
        # the path is over, and of the stroke almost nothing is left
        {
            "tools": [
                ball(
                    PathMotion(
                        (0.0, END), ((0.0, 0.0, 0.0), (1e-4, 0.0, 0.0)), None, Stroke((0.0, 1.001 * END), (0.0, 4e-4))
                    )
                )
            ]
        },
        {"grippers": [gripped(release_time=0.5 * END)]},
        {"grippers": [gripped(motion=Stroke((0.0, 2 * END), (0.0, 1e-4)), release_time=0.5 * END)]},
        {"pressures": [Pressure("top", (0.0, 1e3), (0.0, END))]},
    ],
)
def test_what_is_over_is_silent(given):
    assert not notes(**given)


def test_stages_are_judged_each_by_its_time():
    motion = Stroke((0.0, 2 * END), (0.0, 4e-4))
    first, second = Stage("a", END), Stage("b", END)
    assert not notes(tools=[ball(motion)], stages=(first, second), duration=2 * END)  # it goes on
    (note,) = notes(tools=[ball(motion)], stages=(first, Stage("b", END, moves={"ball": Fixed()})), duration=2 * END)
    assert "0.2 of its 0.4 mm are missing, and stage a ends" in note
    ended = Stage("a", END, AtForce("ball", 1.0))
    assert not notes(tools=[ball(motion)], stages=(ended, Stage("b", END, moves={"ball": Fixed()})), duration=2 * END)


def test_a_gripper_that_a_stage_opens_is_cut_short_by_the_stage_before():
    clamp = gripped(motion=Stroke((0.0, 2 * END), (0.0, 1e-4)))
    (note,) = notes(grippers=[clamp], stages=(Stage("a", END), Stage("b", END, grippers=())), duration=2 * END)
    assert "clamp is to move until 2e-05 s" in note and "stage a ends" in note
