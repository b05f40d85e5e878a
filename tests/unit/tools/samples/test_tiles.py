"""Samples across the borders of tiles, their marks, and the clearance by which contact is skipped."""

import numpy as np

from tests.support.runs import small_run
from tests.support.solids import ball
from weavesim.process.strokes import Stroke
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.sampling import exact_distance, sampled_distance
from weavesim.tools.tool import Tool


def test_the_distance_errs_no_more_across_tiles_than_within():
    shape = MeshShape.from_triangles(*ball(0.05))
    sampled = sampled_distance(shape.surface)
    line = np.linspace(0.048, 0.052, 2001)[:, None]
    for direction in np.random.default_rng(1).normal(size=(20, 3)):
        points = line * direction / np.linalg.norm(direction)
        value, normal = Tool("ball", shape).distance(points)
        assert np.abs(value - exact_distance(shape.surface, points)).max() < 1.5 * sampled.tolerance
        assert np.all(normal @ direction > 0.99 * np.linalg.norm(direction))


def test_no_node_comes_nearer_than_its_block_was_said_to_be_clear():
    ball_below = MeshShape.from_triangles(*ball(0.03), origin=(0.01, 0.01, -0.0345))
    tool = Tool("ball", ball_below, Stroke((0.0, 3e-3), (0.0, 0.006)))
    run = small_run(tools=[tool], duration=3e-3, precision="float32", lane_count=16)
    half = 0.5 * run.setup.sheet.fabric.thickness
    clear, nearest = 0, np.inf
    for step in range(1, 31):
        run.stepper.advance_to(step * 1e-4)
        frame = run.ledger.frame(step)
        points = np.asarray(frame.position) - tool.shape.origin - frame.tool_displacement[0] * np.array(tool.axis)
        distance = exact_distance(tool.shape.surface, points)
        gap = run.stepper.state.sheets[0].gap.numpy()[0]
        left = np.array([block.min() for block in np.array_split(distance, np.arange(16, len(distance), 16))]) - half
        assert np.all(gap[: len(left)] <= left + 2e-6)
        clear, nearest = clear + np.count_nonzero(gap > 0.0), min(nearest, distance.min())
    assert clear > 0 and nearest < half
