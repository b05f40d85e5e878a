"""Samples across the borders of tiles, their marks, and the clearance by which contact is skipped."""

import numpy as np
import pytest
import warp as wp

from tests.support.runs import small_run
from tests.support.solids import ball, box, sheet
from weavesim.process.strokes import Stroke
from weavesim.tools.mesh_tool import MeshShape, MeshSurface
from weavesim.tools.samples.grid import chosen_grid
from weavesim.tools.samples.tiles import filled_values
from weavesim.tools.sampling import exact_distance, sampled_distance
from weavesim.tools.solid_triangles import SolidTriangles
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


def bent_bar(length):
    """A bar bent to a ring of radius 30 mm: a longer one than 188 mm runs into itself."""
    vertices, faces = box((length, 0.01, 0.01), cuts=4)
    x, y, z = np.asarray(vertices).T
    return np.column_stack([(0.03 + y) * np.cos(x / 0.03), (0.03 + y) * np.sin(x / 0.03), z]), faces


def folded_sheet():
    vertices, faces = sheet(count=5)
    return vertices + np.array([0.0, 0.0, 0.4]) * np.abs(vertices[:, :1]), faces


@pytest.mark.parametrize("mesh", [bent_bar(0.17), bent_bar(0.22), folded_sheet(), box((0.1, 0.08, 0.0005))])
def test_the_side_of_each_sample_is_that_of_the_winding_number(mesh):
    surface = MeshSurface(*mesh, spacing=0.002)
    triangles = SolidTriangles(surface, "cpu", 0.002)
    grid = chosen_grid(triangles, 0.002, 0.0)
    tiles = wp.array(grid.tiles, dtype=wp.int32, device="cpu")
    values = filled_values(triangles, grid, tiles, 0.004).numpy().reshape(len(grid.first_voxel), -1)
    corner = np.stack(np.meshgrid(*3 * (np.arange(9),), indexing="ij"), axis=-1).reshape(-1, 3)
    points = surface.centre + grid.first + grid.spacing * (grid.first_voxel[:, None] + corner)
    near = np.abs(values[:, : len(corner)]) < 0.006
    exact = triangles.distance(points[near], triangles.mesh, 1)  # the winding number alone
    assert np.count_nonzero(near) > 10_000
    # single precision: nearest places on the long walls below a sheet are rounded to some micrometres
    np.testing.assert_allclose(values[:, : len(corner)][near], exact, atol=1e-5)
