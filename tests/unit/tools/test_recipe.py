"""The recipe of CONTRIBUTING for a tool, as it stands there: it adds a shape, on which a sheet comes to rest."""

import numpy as np
import pytest

from tests.support.kinds import imported, kinds_forgotten
from tests.support.recipes import written_recipe
from tests.support.runs import small_run
from weavesim.engine.compilation import KernelSet
from weavesim.engine.setup import Setup
from weavesim.errors import InputError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.process.dynamics import Dynamics
from weavesim.tools import Sphere, Tool, Union, rotation_matrix

RADIUS, HALF_HEIGHT, EDGE = 0.03, 0.008, 0.003
GRAVITY = 2000.0


@pytest.fixture
def disc(tmp_path):
    """The recipe's class; forgotten afterwards."""
    with pytest.MonkeyPatch.context() as patch, kinds_forgotten():
        imported(written_recipe("disc_device.py", tmp_path), patch)
        yield imported(written_recipe("disc.py", tmp_path), patch).Disc


def profile(points: np.ndarray) -> np.ndarray:
    """Distance to the disc: a rectangle in the plane of radius and height, grown by the radius of the edge."""
    over = np.column_stack([np.linalg.norm(points[:, :2], axis=1), np.abs(points[:, 2])])
    over -= np.array([RADIUS, HALF_HEIGHT]) - EDGE
    return np.linalg.norm(np.maximum(over, 0.0), axis=1) + np.minimum(over.max(axis=1), 0.0) - EDGE


def test_the_recipe_of_a_tool(disc, tmp_path):
    assert Tool("t", disc(radius=1.0, half_height=1.0, edge_radius=1.0)).shape.kinds()["Disc"] is disc
    turn = np.array(rotation_matrix((1.0, 2.0, 0.5), 0.7))
    centre = np.array([0.01, -0.02, 0.03])
    shape = disc(radius=RADIUS, half_height=HALF_HEIGHT, edge_radius=EDGE, origin=centre, rotation=turn)
    tool = Tool("disc", shape)
    points = np.random.default_rng(0).uniform(-0.05, 0.05, (500, 3))
    value, normal = tool.distance(centre + points @ turn.T)
    np.testing.assert_allclose(value, profile(points), atol=1e-15)
    change = 1e-7 * np.eye(3)
    slope = np.column_stack([(profile(points + h) - profile(points - h)) / 2e-7 for h in change])
    np.testing.assert_allclose(normal @ turn, slope, atol=1e-6)

    # beside a kind of weavesim, in one tool
    both = Tool("both", Union([shape, Sphere(0.02)])).distance(points)[0]
    np.testing.assert_allclose(both, np.minimum(tool.distance(points)[0], np.linalg.norm(points, axis=1) - 0.02))

    mesh = tool.display_mesh()
    mesh.merge_vertices()
    assert mesh.is_volume and mesh.volume == pytest.approx(2.0 * np.pi * RADIUS**2 * HALF_HEIGHT, rel=0.05)
    np.testing.assert_allclose(tool.distance(mesh.vertices)[0], 0.0, atol=1e-12)
    assert Tool.from_json(tool.to_json()) == tool


def test_a_sheet_rests_on_the_tool_of_the_recipe(disc):
    fabric = glass_polypropylene()
    top = -0.5 * fabric.thickness  # the lower face just touches it
    die = disc(radius=RADIUS, half_height=HALF_HEIGHT, edge_radius=EDGE, origin=(0.0, 0.0, top - HALF_HEIGHT))
    simulation = small_run(
        tools=[Tool("die", die)], dynamics=Dynamics(gravity=(0.0, 0.0, -GRAVITY), damping=2000.0), duration=5e-3,
        accept_unusual=True,
    )  # fmt: skip
    setup = simulation.setup
    assert Setup.from_json(setup.to_json()) == setup
    ledger = simulation.ledger.sheets[0]
    launched = {command.kernel for gaps in (ledger._contact_gaps, ledger._judged_gaps) for command in gaps.launches}
    assert launched <= set(KernelSet.of_setups([setup]).kernels())

    simulation.run()
    frame, weight = simulation.frame, GRAVITY * fabric.areal_density * 0.02**2
    assert frame.tool_reaction[0] == pytest.approx([0.0, 0.0, -weight], rel=0.01, abs=0.01 * weight)
    assert np.abs(frame.sheets[0].position[:, 2]).max() < 0.05 * fabric.thickness


def test_the_recipe_leaves_nothing_behind():
    shape = {"kind": "Disc", "radius": 0.1, "half_height": 0.1, "edge_radius": 0.1}
    with pytest.raises(InputError, match="kind = 'Disc': one of"):
        Tool("disc", shape)
