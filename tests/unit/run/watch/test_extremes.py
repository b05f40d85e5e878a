"""Extremes over all steps, kept on the device."""

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.process.strokes import Stroke
from weavesim.tools.shapes import Plane
from weavesim.tools.tool import Tool


def thrown(lane_count: int, frame_count: int = 3, **given):
    """A square of which one corner is thrown, and swings."""
    velocity = np.zeros((25, 3))
    velocity[0] = (-3.0, -2.0, 4.0)
    settings = {"initial_velocity": velocity, "duration": 2e-4, "frame_count": frame_count, "lane_count": lane_count}
    simulation = small_run(**(settings | given))
    simulation.run()
    return simulation


@pytest.mark.parametrize("lane_count", [1, 16])
def test_extremes_are_those_of_every_block(lane_count):
    """Frames as dense as the blocks see the same extremes as the device."""
    run = thrown(lane_count, frame_count=1000)
    (extremes,) = run.watch.extremes.sheets
    seen = {"min": 1.0, "max": 1.0, "angle": 0.0}
    again = small_run(**_given(lane_count))
    while again.state.time < 2e-4:
        again.stepper.advance()
        fields = again.take_frame().fields
        stretch = np.concatenate([fields["warp_stretch"], fields["weft_stretch"]])
        seen["min"], seen["max"] = min(seen["min"], stretch.min()), max(seen["max"], stretch.max())
        seen["angle"] = max(seen["angle"], np.abs(fields["shear_angle"]).max())
    assert extremes.min_stretch.value == pytest.approx(seen["min"], abs=1e-9)
    assert extremes.max_stretch.value == pytest.approx(seen["max"], abs=1e-9)
    assert extremes.angle.value == pytest.approx(seen["angle"], abs=1e-9)
    assert 0.0 < extremes.angle.time <= again.frame.time
    assert np.hypot(*extremes.angle.place) < 0.005


def _given(lane_count):
    velocity = np.zeros((25, 3))
    velocity[0] = (-3.0, -2.0, 4.0)
    return {"initial_velocity": velocity, "duration": 2e-4, "frame_count": 1000, "lane_count": lane_count}


def test_they_are_those_of_any_number_of_frames():
    few, many = thrown(1, 1).watch.extremes.sheets[0], thrown(1, 50).watch.extremes.sheets[0]
    for name in ("min_stretch", "max_stretch", "angle", "depth"):
        assert getattr(few, name) == getattr(many, name)


def test_the_deepest_node_knows_its_tool_and_place():
    """A table rises against a sheet and goes down again; another one is never touched."""
    table = Tool("table", Plane(origin=(0.0, 0.0, -0.0007)), Stroke((0.0, 1e-4, 2e-4), (0.0, 3e-4, 0.0)))
    far = Tool("far", Plane(origin=(0.0, 0.0, -0.1)))
    run = thrown(1, 1, tools=[far, table], initial_velocity=None)
    (extremes,) = run.watch.extremes.sheets
    assert extremes.touched.tolist() == run.watch.extremes.touched.tolist() == [False, True]
    assert extremes.depth.tool == 1 and 0.0 < extremes.depth.value < 3e-4
    assert run.summary()["penetration_at_nodes_mm"] == 1e3 * extremes.depth.value
    assert run.summary()["peak_tool_force_n"]["table"] > 0.0 == run.summary()["peak_tool_force_n"]["far"]
    assert run.penetration.at_nodes <= extremes.depth.value
