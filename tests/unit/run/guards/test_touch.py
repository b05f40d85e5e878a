"""Guards of tools that cannot meet the sheet, or did not (field case 08)."""

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.process.dynamics import Dynamics
from weavesim.process.stages import Stage
from weavesim.process.strokes import ForceDriven, Stroke
from weavesim.run.frame import Outcome
from weavesim.run.guards import Level, verdict_of
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Plane, Sphere, rotation_matrix
from weavesim.tools.tool import Tool

FACE_DOWN = rotation_matrix((1.0, 0.0, 0.0), np.pi)


def plate(x: float) -> MeshShape:
    """A flat square die, its face 0.6 mm below the sheet, its middle at ``x``."""
    corners = np.array([[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return MeshShape.from_triangles(corners, faces, spacing=1e-3, reach=4e-3, origin=(x, 0.0, -0.0006))


def spoken(run) -> dict:
    return {doubt.guard: doubt for doubt in run.doubts()}


UNREACHABLE = {
    "a die 3.5 m away": Tool("die", plate(3.5)),
    "a punch too high": Tool(
        "punch", Sphere(0.01, origin=(0.01, 0.01, 0.2)), Stroke((0.0, 1e-3), (0.0, 0.05)), axis=(0.0, 0.0, -1.0)
    ),
    "a punch that goes the wrong way": Tool(
        "punch", Sphere(0.01, origin=(0.01, 0.01, 0.02)), Stroke((0.0, 1e-3), (0.0, 0.05))
    ),
    "a table far below": Tool("table", Plane(origin=(0.0, 0.0, -0.3))),
    "a punch beside the sheet": Tool("punch", Sphere(0.01, origin=(0.2, 0.01, 0.0)), Stroke((0.0, 1.0), (0.0, 0.05))),
}


@pytest.mark.parametrize("name", UNREACHABLE)
def test_a_tool_that_cannot_meet_the_sheet_is_told_before(name):
    tool = UNREACHABLE[name]
    run = small_run(tools=[tool], duration=1e-3, frame_count=1)
    (warning,) = run.warnings
    assert warning.startswith(f"{tool.name}: it stays") and "never meet the sheet" in warning
    assert verdict_of(run.doubts()) == "doubtful"


def test_a_punch_that_never_touched_makes_a_result_useless():
    run = small_run(tools=[UNREACHABLE["a punch too high"]], duration=1e-3, frame_count=1)
    run.run()
    assert spoken(run)["never_touched"].level == Level.DO_NOT_USE and run.verdict == "do not use"
    assert not {"energy_balance", "kinetic_energy", "damping_loss"} & set(spoken(run))


def test_a_punch_that_misses_the_sheet_narrowly_is_seen_at_the_end():
    """Nothing tells it before: the sheet might have moved there."""
    tool = Tool(
        "punch", Sphere(0.01, origin=(0.01, 0.01, 0.0115)), Stroke((0.0, 1e-3), (0.0, 0.0005)), axis=(0.0, 0.0, -1.0)
    )
    run = small_run(tools=[tool], duration=1e-3, frame_count=1)
    assert "tool_reach" not in spoken(run)
    run.run()
    doubt = spoken(run)["never_touched"]
    assert doubt.level == Level.DO_NOT_USE and "punch never touched" in doubt.text


def test_a_fixed_tool_that_was_not_needed_is_a_warning():
    table, near = Tool("table", Plane(origin=(0.0, 0.0, -0.0006))), Tool("stop", Plane(origin=(0.0, 0.0, -0.0008)))
    run = small_run(tools=[table, near], duration=2e-3, frame_count=1, dynamics=Dynamics(gravity=(0.0, 0.0, -9.81)))
    run.run()
    assert [(d.guard, d.level, "stop" in d.text) for d in run.doubts()] == [("never_touched", Level.WARNING, True)]


def test_nothing_is_said_of_an_interrupted_run():
    run = small_run(tools=[Tool("near", Plane(origin=(0.0, 0.0, -0.001)))])
    run.run()
    run.outcome = Outcome.INTERRUPTED
    assert spoken(run) == {}


@pytest.mark.parametrize(
    "given",
    [
        {"dynamics": Dynamics(gravity=(0.0, 0.0, -9.81)), "duration": 0.1},
        {"initial_velocity": np.full((25, 3), -2.0), "duration": 0.01},
    ],
    ids=["falls", "is thrown"],
)
def test_a_sheet_that_moves_by_itself_may_reach_a_tool(given):
    assert "tool_reach" not in spoken(small_run(tools=[Tool("table", Plane(origin=(0.0, 0.0, -0.02)))], **given))


def test_a_sheet_that_others_move_may_reach_a_tool():
    punch = Tool(
        "punch", Sphere(0.01, origin=(0.01, 0.01, 0.0107)), Stroke((0.0, 1.0), (0.0, 0.014)), axis=(0.0, 0.0, -1.0)
    )
    weight = Tool(
        "weight", Plane(origin=(0.0, 0.0, 0.0006), rotation=FACE_DOWN), ForceDriven.constant(1.0, 0.01),
        axis=(0.0, 0.0, -1.0),
    )  # fmt: skip
    table = Tool("table", Plane(origin=(0.0, 0.0, -0.015)))
    for mover in (punch, weight):
        assert "tool_reach" not in spoken(small_run(tools=[mover, table], duration=1.0))


@pytest.mark.parametrize(("height", "told"), [(0.2, True), (0.06, True), (0.0505, False)])
def test_a_punch_above_a_held_sheet_is_told_by_its_stroke(height, told):
    """The force of a holder presses the sheet on the die; it does not carry it 50 mm up to the punch."""
    holder = Tool(
        "holder", Plane(origin=(0.0, 0.0, 0.0006), rotation=FACE_DOWN), ForceDriven.constant(1.0, 0.01),
        axis=(0.0, 0.0, -1.0),
    )  # fmt: skip
    die = Tool("die", Plane(origin=(0.0, 0.0, -0.0006)))
    ball = Sphere(0.03, origin=(0.01, 0.01, 0.0306 + height))
    punch = Tool("punch", ball, Stroke((0.0, 1.0), (0.0, 0.05)), axis=(0.0, 0.0, -1.0))
    said = spoken(small_run(tools=[punch, die, holder], duration=1.0))
    assert ("tool_reach" in said) == told


def test_a_short_touch_between_the_places_looked_at_is_not_out_of_reach():
    there_and_back = Stroke((0.0, 4.2e-4, 4.35e-4, 4.5e-4), (0.0, 0.0, 0.0205, 0.0))
    punch = Tool("punch", Sphere(0.01, origin=(0.01, 0.01, -0.0306)), there_and_back)
    assert "tool_reach" not in spoken(small_run(tools=[punch], duration=1e-3))


@pytest.mark.parametrize(
    ("height", "force", "duration", "told"),
    [
        (0.03, 1.0, 0.1, False),  # a hundred times gravity: half a metre
        (0.5, 1.0, 1.0, False),
        (0.03, 1.0, 1e-3, True),  # 0.05 mm
        (0.03, -1.0, 0.1, True),  # away from the sheet
    ],
)
def test_a_tool_by_force_reaches_as_far_as_its_force_carries_it(height, force, duration, told):
    weight = Tool(
        "weight", Sphere(0.01, origin=(0.01, 0.01, 0.0106 + height)), ForceDriven.constant(force, 0.01),
        axis=(0.0, 0.0, -1.0),
    )  # fmt: skip
    assert ("tool_reach" in spoken(small_run(tools=[weight], duration=duration))) == told


@pytest.mark.parametrize(
    ("stroke", "duration", "told"),
    [
        (0.0, 1e-3, True),  # 0.05 mm from its place at 30 mm, however long it stood there
        (0.0, 0.1, False),
        (0.0299, 2e-3, False),  # 0.2 mm from where its stroke ended
    ],
)
def test_a_force_of_a_later_stage_carries_a_tool_from_its_place_in_the_time_of_the_stage(stroke, duration, told):
    weight = Tool(
        "weight", Sphere(0.01, origin=(0.01, 0.01, 0.0406)), Stroke((0.0, 0.1), (0.0, stroke)), axis=(0.0, 0.0, -1.0)
    )
    stages = (
        Stage("wait", 0.1),
        Stage("push", duration, moves={"weight": ForceDriven.constant(1.0, 0.01)}),
    )
    assert ("tool_reach" in spoken(small_run(tools=[weight], stages=stages, duration=0.1 + duration))) == told
