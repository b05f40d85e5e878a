"""Guards of tools against the size of the elements."""

import math

import pytest
import trimesh

from tests.support.runs import small_run
from weavesim.engine.setup import Setup, Solver, World
from weavesim.fabric.presets import glass_polypropylene
from weavesim.run.guards.guard import Level
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools.mesh_tool import MeshShape
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
    (note,) = [doubt for doubt in simulation.doubts() if doubt.guard == "tool_radius"]
    assert note.level == Level.NOTE and note.message.startswith("ball: 3.1 elements of 5 mm")


def test_nothing_is_said_of_a_large_radius():
    simulation = small_run(tools=[ball(0.02)])
    assert simulation.warnings == [] and simulation.info.notes == ()


def mesh_tool(size, centre, **options) -> Tool:
    mesh = trimesh.creation.box(size)
    return Tool("block", MeshShape.from_triangles(mesh.vertices, mesh.faces, origin=centre, **options))


def test_sharp_edges_that_face_the_sheet_are_warned_of_with_their_number_and_place():
    size = (0.01, 0.008, 0.004)
    warnings = small_run(tools=[mesh_tool(size, (0.01, 0.01, -0.0006 - 0.002))]).warnings
    assert any("block: 4 sharp edges face the sheet, one about (" in warning for warning in warnings)


@pytest.mark.parametrize(
    ("size", "centre"),
    [((0.2, 0.2, 0.004), (0.01, 0.01, -0.0026)), ((0.1, 0.1, 0.02), (0.01, 0.01, -0.0106))],
    ids=["wide plate", "wide block"],
)
def test_sharp_edges_beyond_the_sheet_are_not(size, centre):
    assert not any("sharp edges" in warning for warning in small_run(tools=[mesh_tool(size, centre)]).warnings)


def test_a_far_fleck_is_warned_of():
    plate, fleck = trimesh.creation.box((0.1, 0.1, 0.004)), trimesh.creation.box((0.002, 0.002, 0.002))
    fleck.apply_translation((0.5, 0.5, 0.0))
    both = trimesh.util.concatenate([plate, fleck])
    tool = Tool("table", MeshShape.from_triangles(both.vertices, both.faces, origin=(0.01, 0.01, -0.0026)))
    assert any(
        "12 triangles, 3.46 mm across, lie far from the rest" in w
        for w in small_run(tools=[tool], accept_unusual=True).warnings
    )


def test_of_several_sheets_the_coarsest_is_named_once():
    sheets = tuple(
        Sheet(Blank.rectangle((0.0, 0.0), (0.06, 0.06), size, height=height), glass_polypropylene(), name)
        for name, size, height in (("fine", 0.01, 0.0), ("coarse", 0.015, 0.002), ("middle", 0.012, 0.004))
    )
    far = Tool("ball", Sphere(0.02, origin=(0.03, 0.03, 0.05)))
    solver = Solver(threads=1, lane_count=1)
    run = Simulation(Setup("three", (World(sheets, (far,)),), duration=1e-5, frame_count=1, solver=solver))
    (doubt,) = [doubt for doubt in run.doubts() if doubt.guard == "tool_radius"]
    assert doubt.sheet == "coarse" and "2.1 elements of 15 mm" in doubt.text


def test_tools_of_one_radius_are_told_once_with_what_it_did():
    blank = Blank.rectangle((0.0, 0.0), (0.06, 0.06), 0.01)
    balls = tuple(
        Tool(name, Sphere(0.02, origin=(0.035, 0.035, sign * 0.0204)))
        for name, sign in (("above", 1.0), ("below", -1.0))
    )
    world = World((Sheet(blank, glass_polypropylene()),), balls)
    run = Simulation(Setup("two", (world,), duration=1e-4, frame_count=1, solver=Solver(threads=1, lane_count=1)))
    assert not any("elements of" in text for text in (*run.info.notes, *run.warnings))
    run.run()
    (doubt,) = [doubt for doubt in run.doubts() if doubt.guard == "tool_radius"]
    assert doubt.level == Level.NOTE
    assert "above, below: 3.1 elements of 10 mm along 90 degrees of their 20 mm radius" in doubt.text
    depth = 1e3 * run.penetration.at_element_centres
    assert depth > 0.0 and f"was {depth:.2g} mm in a tool at most" in doubt.advice
