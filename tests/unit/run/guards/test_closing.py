"""Guard of tools that close on less than the thickness of the sheet."""

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.engine.setup import Setup
from weavesim.errors import InputError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.process.interfaces import Interface
from weavesim.process.stages import Stage
from weavesim.process.strokes import Fixed, ForceDriven, Stroke
from weavesim.run.guards import Level
from weavesim.run.guards.closing import stack_thickness
from weavesim.run.simulation import Simulation
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import DomeCavity, DomeOpening, DomePunch, Plane, Shape, Sphere, rotation_matrix
from weavesim.tools.tool import Tool

THICKNESS = glass_polypropylene().thickness
HALF = 0.5 * THICKNESS
FACE_DOWN = rotation_matrix((1.0, 0.0, 0.0), np.pi)
FACE_UP = rotation_matrix((1.0, 0.0, 0.0), 0.0)
DOWN = (0.0, 0.0, -1.0)


def closed(upper: Shape, lower: Shape, travel: float, motion=None, lower_motion=None, blank=None, accepted=True):
    """A sheet between two tools, of which the upper goes down by ``travel``."""
    tools = [
        Tool("punch", upper, motion or Stroke((0.0, 1e-3), (0.0, travel)), axis=DOWN),
        Tool("die", lower, lower_motion or Fixed()),
    ]
    blank = blank or Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.005)
    return small_run(blank=blank, tools=tools, duration=1e-3, frame_count=1, accept_unusual=accepted)


def closing(run) -> list:
    return [doubt for doubt in run.doubts() if doubt.guard == "closing_gap"]


def slab(height: float) -> MeshShape:
    """A flat block of a mesh, its upper face at ``height``."""
    x = 0.04
    corners = np.array([[i * x, j * x, k * 0.01] for k in (-1, 0) for j in (-1, 1) for i in (-1, 1)])
    faces = np.array([
        [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2],
        [1, 3, 7], [1, 7, 5],
    ])  # fmt: skip
    return MeshShape.from_triangles(corners, faces, spacing=1e-3, reach=4e-3, origin=(0.0, 0.0, height))


PAIRS = {
    "two planes": (Plane(origin=(0.0, 0.0, HALF + 0.001), rotation=FACE_DOWN), Plane(origin=(0.0, 0.0, -HALF))),
    "a ball and a plane": (Sphere(0.03, origin=(0.0, 0.0, 0.03 + HALF + 0.001)), Plane(origin=(0.0, 0.0, -HALF))),
    "a plane and a block": (Plane(origin=(0.0, 0.0, HALF + 0.001), rotation=FACE_DOWN), slab(-HALF)),
}


@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("lack", [0.0, 0.0004, 0.0008])
def test_the_gap_at_the_end_of_the_stroke_is_told_before(name, lack):
    """The tools start 1 mm further apart than the thickness."""
    found = closing(closed(*PAIRS[name], 0.001 + lack))
    if lack == 0.0:
        assert found == []
    else:
        (doubt,) = found
        assert doubt.value == pytest.approx(THICKNESS - lack, abs=1e-4) and doubt.time == pytest.approx(1e-3)
        assert "punch and die leave" in doubt.text and "for a sheet of 1.2 mm" in doubt.text


@pytest.mark.parametrize("name", PAIRS)
def test_a_stroke_that_closes_too_far_is_refused_unless_it_is_accepted(name):
    with pytest.raises(
        InputError, match=r"punch and die leave 0\.[78]\d* mm .*a largest_force\. .*accept_unusual=True"
    ):
        closed(*PAIRS[name], 0.0014, accepted=False)
    # with a largest force it becomes a limit
    limited = closed(*PAIRS[name], 0.0, motion=Stroke((0.0, 1e-3), (0.0, 0.0014), 100.0), accepted=False)
    assert [doubt.level for doubt in closing(limited)] == [Level.NOTE]


@pytest.mark.parametrize("name", PAIRS)
def test_tools_that_run_into_each_other_are_refused(name):
    where = r"at \(-?[\d.]+, -?[\d.]+, -?[\d.]+\) mm at 0\.001 s"
    with pytest.raises(InputError, match=rf"punch and die run into each other by 0\.[345]\d* mm {where}"):
        closed(*PAIRS[name], 0.001 + THICKNESS + 0.0004)


@pytest.mark.parametrize("start", [0.002, 0.006, 0.05])
@pytest.mark.parametrize("from_below", [False, True])
def test_a_mesh_that_starts_beyond_the_reach_of_its_samples_is_seen_too(start, from_below):
    """Its distance has no normal there, which must not hide on which side of the sheet it is."""
    sign = -1.0 if from_below else 1.0
    block = slab(0.0).placed((0.0, 0.0, sign * (HALF + start)), FACE_UP if from_below else FACE_DOWN)
    plane = Plane(origin=(0.0, 0.0, -sign * HALF), rotation=FACE_DOWN if from_below else FACE_UP)
    motion = Stroke((0.0, 1e-3), (0.0, -sign * (start + 0.0004)))
    blank = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.005)
    run = small_run(
        blank=blank, tools=[Tool("punch", block, motion), Tool("die", plane)], duration=1e-3, frame_count=1,
        accept_unusual=True,
    )  # fmt: skip
    (doubt,) = closing(run)
    assert doubt.value == pytest.approx(THICKNESS - 0.0004, abs=1e-4)


def test_a_gap_that_is_too_small_on_the_way_only_is_told_too():
    motion = Stroke((0.0, 5e-4, 1e-3), (0.0, 0.0016, 0.0))
    (doubt,) = closing(closed(*PAIRS["two planes"], 0.0, motion=motion))
    assert doubt.time == pytest.approx(5e-4) and doubt.value == pytest.approx(0.0006, abs=1e-5)


def test_a_gap_that_is_too_small_for_a_moment_is_told_too():
    motion = Stroke((0.0, 4.1e-4, 4.2e-4, 4.3e-4, 1e-3), (0.0, 0.0, 0.0016, 0.0, 0.0))
    (doubt,) = closing(closed(*PAIRS["two planes"], 0.0, motion=motion))
    assert doubt.time == pytest.approx(4.2e-4) and doubt.value == pytest.approx(0.0006, abs=1e-5)


def test_a_lower_tool_that_rises_is_seen():
    (doubt,) = closing(
        closed(*PAIRS["two planes"], 0.0, motion=Fixed(), lower_motion=Stroke((0.0, 1e-3), (0.0, 0.0015)))
    )
    assert doubt.value == pytest.approx(0.0007, abs=1e-5)


def dome(clearance: float, bottom: float):
    """A punch, and an opening over a cavity whose bottom it reaches with ``bottom`` to spare."""
    punch = DomePunch(radius=0.02, half_length=0.01).placed((0.0, 0.0, 0.02 + HALF))
    opening = DomeOpening(radius=0.02 + clearance, half_length=0.01, edge_radius=0.004).placed((0.0, 0.0, -HALF))
    return punch, opening, DomeCavity(radius=0.02 + clearance, half_length=0.01).placed((0.0, 0.0, -HALF - bottom))


WIDE = Blank.rectangle((-0.05, -0.05), (0.05, 0.05), 0.005)


@pytest.mark.parametrize(("clearance", "told"), [(0.0012, False), (0.002, False), (0.001, True), (0.0004, True)])
def test_a_punch_in_an_opening_needs_room_beside_it(clearance, told):
    punch, opening, _ = dome(clearance, 0.03)
    found = closing(closed(punch, opening, 0.025, blank=WIDE))
    assert len(found) == told
    if told:
        assert found[0].value == pytest.approx(clearance, abs=2e-5)


@pytest.mark.parametrize(("depth", "gap"), [(0.02, None), (0.0212, None), (0.0217, 0.0007), (0.022, 0.0004)])
def test_a_punch_in_a_cavity_needs_room_below_it(depth, gap):
    """With 21.2 mm of travel the punch is in the middle of the cavity, the thickness from its walls."""
    punch, _, cavity = dome(THICKNESS, 0.0)
    found = closing(closed(punch, cavity, depth, blank=WIDE))
    assert [doubt.value for doubt in found] == ([] if gap is None else pytest.approx([gap], abs=3e-5))


def test_tools_on_one_side_or_moved_by_a_force_are_left_alone():
    """A punch goes through a holder, and a force stops at the sheet."""
    punch, opening, _ = dome(0.0002, 0.03)
    holder = opening.placed((0.0, 0.0, 2.0 * HALF), FACE_DOWN)
    assert closing(closed(punch, holder, 0.02, blank=WIDE)) == []
    upper, lower = PAIRS["two planes"]
    assert closing(closed(upper, lower, 0.0, motion=ForceDriven.constant(5.0, 0.1))) == []


def test_tools_that_meet_beside_the_sheet_only_are_left_alone():
    upper = Sphere(0.03, origin=(0.06, 0.0, 0.04))
    lower = Sphere(0.02, origin=(0.06, 0.0, -0.03))
    assert closing(closed(upper, lower, 0.03)) == []


def test_a_press_with_a_largest_force_stops_before_and_that_is_noted():
    upper, lower = PAIRS["two planes"]
    run = closed(upper, lower, 0.0018, Stroke((0.0, 1e-3), (0.0, 0.0018), 500.0))
    (doubt,) = closing(run)
    assert doubt.level is Level.NOTE and "punch stops before, where its largest force of 500 N is reached" in doubt.text
    assert doubt.value == pytest.approx(THICKNESS - 0.0008, abs=1e-5)


def test_a_stack_needs_room_for_all_of_its_plies():
    """1 mm of way, and room for one ply only."""
    plies = tuple(
        Sheet(Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.005, height=k * THICKNESS), glass_polypropylene(), name=n)
        for k, n in enumerate(("lower", "upper"))
    )
    upper = Plane(origin=(0.0, 0.0, HALF + THICKNESS + 1e-3), rotation=FACE_DOWN)
    tools = (
        Tool("punch", upper, Stroke((0.0, 1e-3), (0.0, 1e-3 + THICKNESS)), axis=DOWN),
        Tool("die", Plane(origin=(0.0, 0.0, -HALF))),
    )
    setup = Setup("stack", sheets=plies, tools=tools, interfaces=(Interface("lower", "upper"),), duration=1e-3,
                  accept_unusual=True)  # fmt: skip
    assert stack_thickness(setup.worlds[0]) == pytest.approx(2.0 * THICKNESS)
    (doubt,) = (d for d in Simulation(setup).prepare().guards.first if d.guard == "closing_gap")
    assert f"for a sheet of {2e3 * THICKNESS:.3g} mm" in doubt.text
    assert doubt.value == pytest.approx(THICKNESS, abs=1e-5)


def in_two_stages(first: Stroke, second: Stroke):
    """Planes 1 mm apart more than the sheet is thick; the punch moves by ``first``, and on by ``second``."""
    upper, lower = PAIRS["two planes"]
    tools = [Tool("punch", upper, first, axis=DOWN), Tool("die", lower, Fixed())]
    stages = (Stage("a", 1e-3), Stage("b", 1e-3, moves={"punch": second}))
    blank = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.005)
    return small_run(blank=blank, tools=tools, stages=stages, duration=2e-3, frame_count=2)


def test_each_stage_is_judged_by_its_own_strokes():
    """A largest force in one stage says nothing of a stroke without one in another."""
    free, far = Stroke((0.0, 1e-3), (0.0, 0.0005)), Stroke((0.0, 1e-3), (0.0, 0.003))
    stopped = Stroke((0.0, 1e-3), (0.0, 0.003), largest_force=50.0)
    (note,) = closing(in_two_stages(free, stopped))
    assert note.level == Level.NOTE and "50 N is reached" in note.text
    with pytest.raises(InputError, match="punch and die run into each other"):
        in_two_stages(stopped, far)
