"""Tools that run into each other through the sheet while a run goes on, told with place and time."""

import logging
from types import SimpleNamespace

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.fabric.presets import glass_polypropylene
from weavesim.process.strokes import Fixed, ForceDriven
from weavesim.run.guards import Level
from weavesim.run.guards.staging.crossing import ToolsCross, _near_sheets
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Plane, Sphere
from weavesim.tools.tool import Tool

HALF = 0.5 * glass_polypropylene().thickness
DOWN = (0.0, 0.0, -1.0)


def pressed(force: float):
    """A ball that a force presses onto a sheet on a table."""
    ball = Sphere(0.01, origin=(0.004, 0.0, 0.01 + HALF + 1e-4))
    return small_run(
        blank=Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.005), duration=2e-3, frame_count=4, accept_unusual=True,
        tools=[
            Tool("ball", ball, ForceDriven.constant(force, 0.02, 2e-4), axis=DOWN),
            Tool("table", Plane(origin=(0.0, 0.0, -HALF)), Fixed()),
        ],
    )  # fmt: skip


@pytest.mark.parametrize(("force", "trips"), [(50.0, False), (2.0e4, True)])
def test_a_ball_that_is_pressed_through_the_sheet(force, trips, caplog):
    run = pressed(force)
    with caplog.at_level(logging.WARNING, "weavesim"):
        run.run()
    doubts = [doubt for doubt in run.doubts() if doubt.guard == "tools_cross"]
    assert [doubt.level for doubt in doubts] == [Level.DO_NOT_USE] * trips
    told = [record.message for record in caplog.records if "run into each other at" in record.message]
    assert len(told) == trips
    if trips:
        (doubt,) = doubts
        assert "ball and table ran into each other, first at (" in doubt.text and 0.0 < doubt.time < 2e-3
        place = doubt.text.split("at (")[1].split(")")[0]
        x, y, _ = (float(value) for value in place.split(","))
        # under the ball, in millimetres
        assert np.hypot(x - 4.0, y) < 5.0
        assert told[0].startswith(f"at {doubt.time:.4g} s ball and table")


def test_it_remembers_what_it_found():
    guard, other = ToolsCross(), ToolsCross()
    guard._note("a and b", 0.1, np.array([1e-3, 0.0, 0.0]), 2e-3, 1e-3)
    guard._note("a and b", 0.2, np.zeros(3), 3e-3, 1e-3)
    other.recall(guard.memory())
    (doubt,) = other.after(None)
    assert doubt.time == 0.1 and doubt.value == 3e-3 and "(1, 0, 0) mm" in doubt.text


def test_a_point_over_the_middle_of_an_element_is_near_in_a_stack_too():
    """Plies are closer to each other than their nodes."""
    nodes = np.array([[x, y, 0.0] for x in (0.0, 5e-3, 1e-2) for y in (0.0, 5e-3, 1e-2)])
    points = np.array([[2.5e-3, 2.5e-3, 1e-3], [2.5e-3, 2.5e-3, 0.1]])
    sheets = [SimpleNamespace(name=name, position=nodes + [0.0, 0.0, z]) for name, z in (("a", 0.0), ("b", 3e-4))]
    for names in ({"a"}, {"b"}, {"a", "b"}):
        near = _near_sheets(points, SimpleNamespace(sheets=sheets), frozenset(names))
        assert near.tolist() == [True, False]
