"""Guards of tools against the size of the elements."""

import math

from tests.support.runs import small_run
from weavesim.tools.shapes import Sphere
from weavesim.tools.tool import Tool


def ball(radius: float) -> Tool:
    return Tool("ball", Sphere(radius=radius, origin=(0.01, 0.01, -0.0006 - radius)))


def test_a_radius_that_the_mesh_cannot_follow_is_warned_of():
    (warning,) = small_run(tools=[ball(0.005)]).warnings
    # a quarter of its circumference over 5 mm
    assert warning.startswith(f"ball: {0.5 * math.pi * 5.0 / 5.0:.1f} elements of 5 mm")


def test_a_radius_that_it_follows_coarsely_is_a_note():
    simulation = small_run(tools=[ball(0.01)])
    assert simulation.warnings == []
    (note,) = simulation.info.notes
    assert note.startswith("ball: 3.1 elements of 5 mm")


def test_nothing_is_said_of_a_large_radius():
    simulation = small_run(tools=[ball(0.02)])
    assert simulation.warnings == [] and simulation.info.notes == ()
