"""Every check of a run, each by a case that it refuses, and what a run does once it is allowed to start."""

import math
import re

import numpy as np
import pytest

from tests.support.frames import Frames
from tests.support.registered_cells import TautNet
from tests.support.runs import small_run
from weavesim import Setup, Sheet, Solver
from weavesim.errors import InputError, RunError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.run.diagnosis import Failure
from weavesim.run.simulation import CUT_OFF
from weavesim.run.start import prepare
from weavesim.sheet.blank import Blank
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Plane
from weavesim.tools.tool import Tool

NODE_COUNT = 25
THICKNESS = glass_polypropylene().thickness


def with_one_nan() -> np.ndarray:
    velocity = np.zeros((NODE_COUNT, 3))
    velocity[3, 1] = math.nan
    return velocity


def plane_at(height: float) -> Tool:
    """A solid half space below ``height`` [m]; the sheet's mid-surface lies at 0."""
    return Tool("table", Plane(origin=(0.0, 0.0, height)))


def mesh_table(reach: float) -> Tool:
    """A square of two triangles, 10 mm below the sheet, sampled up to ``reach`` [m]."""
    corners = np.array([[-0.03, -0.03, 0.0], [0.05, -0.03, 0.0], [0.05, 0.05, 0.0], [-0.03, 0.05, 0.0]])
    shape = MeshShape.from_triangles(
        corners, np.array([[0, 1, 2], [0, 2, 3]]), spacing=2.0e-4, reach=reach, origin=(0.0, 0.0, -0.01)
    )
    return Tool("table", shape)


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
@pytest.mark.parametrize("name", ["duration", "time_step", "target_step"])
def test_a_time_must_be_positive_and_finite(name, value):
    with pytest.raises(InputError, match=rf"{name} = .*: a (finite )?number (above 0 )?is needed"):
        small_run(**{name: value})


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"step_safety": 0.0}, r"step_safety = 0.*: must be above 0 and at most 0\.9 to be stable"),
        ({"step_safety": 0.95}, r"step_safety = 0\.95: must be above 0 and at most 0\.9 to be stable"),
        ({"frame_count": 0}, "frame_count = 0: at least one frame is needed"),
        ({"lane_count": 4}, "lane_count = 4: 1 or 16 lanes are allowed"),
        ({"threads": 0}, "threads"),
        ({"precision": "float16"}, "float16"),
        ({"device": "abacus"}, "abacus"),
        ({"symmetry": ("z",)}, "symmetry plane 'z'"),
        ({"tools": [plane_at(-0.01)], "leading_tool": 1}, "leading_tool = 1: there are 1 tools, counted from 0"),
        ({"tools": [plane_at(-0.01)], "leading_tool": -1}, "leading_tool = -1: there are 1 tools"),
        ({"initial_velocity": np.zeros((NODE_COUNT, 2))}, r"initial_velocity: .*\(25, 3\)"),
        ({"initial_velocity": np.zeros((NODE_COUNT - 1, 3))}, r"initial_velocity: .*\(25, 3\)"),
        ({"initial_velocity": with_one_nan()}, "initial_velocity: .*finite"),
        ({"free": np.ones((NODE_COUNT, 3), dtype=bool)}, r"free: .*\(25, 3\).*\(25, 6\)"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_a_value_that_would_spoil_the_run_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        small_run(**given)


@pytest.mark.parametrize("height", [1e-3, 0.0, -0.1 * THICKNESS, -0.24 * THICKNESS])
def test_a_tool_that_overlaps_the_blank_is_refused_with_its_depth(height):
    """Half the thickness of the sheet lies below its mid-surface; a plane 1 mm above that is 1.6 mm deep in it."""
    depth = re.escape(f"{1e3 * (height + 0.5 * THICKNESS):.3g}")
    with pytest.raises(
        InputError, match=rf"table overlaps the blank by {depth} mm .* 1\.2 mm thick: move the tool half"
    ):
        small_run(tools=[plane_at(height)])


@pytest.mark.parametrize(("height", "said"), [(-0.5, False), (-0.46, False), (-0.44, True), (-0.26, True)])
def test_a_tool_may_touch_the_blank_and_reach_a_little_into_it(height, said):
    simulation = small_run(tools=[plane_at(height * THICKNESS)])
    assert simulation.penetration.at_nodes == pytest.approx((height + 0.5) * THICKNESS, abs=1e-12)
    assert [doubt.guard for doubt in simulation.doubts()] == ["start_overlap"] * said


def test_a_mesh_must_be_sampled_beyond_the_thickness():
    with pytest.raises(InputError, match=r"table 0: .* distance of 0\.001 m, but the sheet is 0\.0012 m thick"):
        small_run(tools=[mesh_table(reach=1.0e-3)])
    assert small_run(tools=[mesh_table(reach=1.3e-3)]).info.notes


def test_an_unstable_time_step_is_refused_with_the_stable_one():
    stable = small_run().stepper.stable_step()
    with pytest.raises(InputError, match=rf"time_step = .* unstable .* at most {stable:.4g} s is stable"):
        small_run(time_step=1.05 * stable)
    slower = small_run(time_step=0.3 * stable)
    slower.run()
    assert slower.state.step == pytest.approx(0.3 * stable, rel=1e-12)


def test_a_cell_that_is_not_at_rest_is_refused():
    fabric = glass_polypropylene().with_linear_shear(0.0).model_copy(update={"unit_cell": TautNet()})
    with pytest.raises(InputError, match="TautNet: the undeformed sheet carries 1e[+]04 N/m"):
        small_run(fabric=fabric)


def test_a_run_happens_once():
    simulation = small_run()
    simulation.run()
    with pytest.raises(RunError, match="has been run: make a new one"):
        simulation.run()


def test_what_is_computed_for_frames_alone_is_in_the_last_one_at_least():
    """The same bits, of every frame or of the last one: also where nobody observes, and before the run."""
    frames = []
    for every_field in (True, False):
        observer = Frames()
        simulation = small_run(tools=(plane_at(-0.5 * THICKNESS),), frame_count=3)
        assert "tool_gap" in simulation.frame.sheet.fields
        simulation.run([observer], every_field=every_field)
        assert observer.all[-1] is simulation.frame
        frames.append(observer.all)
    for whole, short in zip(*frames, strict=True):
        last = whole is frames[0][-1]
        assert set(short.sheet.fields) < set(whole.sheet.fields) or last
        assert ("tool_gap" in short.sheet.fields, "wrinkle_height" in short.sheet.fields) == (last, last)
        for name, values in short.sheet.fields.items():
            assert np.array_equal(values, whole.sheet.fields[name]), name
    alone = small_run(tools=(plane_at(-0.5 * THICKNESS),), frame_count=3)
    alone.run()
    assert np.array_equal(alone.frame.sheet.fields["tool_gap"], frames[0][-1].sheet.fields["tool_gap"])


def test_a_run_that_is_cut_off_says_what_its_last_frame_lacks(monkeypatch):
    """Its last good frame is known only when it is too late to compute more of it."""

    def fails(model, state, frame):
        return Failure("it burst", state.time) if frame.index == 1 else None

    monkeypatch.setattr("weavesim.run.simulation.find_failure", fails)
    for every_field in (True, False):
        simulation = small_run(tools=(plane_at(-0.5 * THICKNESS),), frame_count=3, duration=3e-4)
        with pytest.raises(RunError, match="it burst"):
            simulation.run([Frames()], every_field=every_field)
        assert ("tool_gap" in simulation.frame.sheet.fields) is every_field
        assert (CUT_OFF in simulation.warnings) is not every_field


def test_notes_say_how_meshes_were_read(tmp_path):
    """Quadrilaterals of the tool split, a node of the blank left out: both are said where the log is written."""
    deck = "*NODE\n1,0,0\n2,20,0\n3,20,20\n4,0,20\n5,9,9,9\n*ELEMENT, TYPE=S4\n1, 1,2,3,4\n"
    (tmp_path / "sheet.inp").write_text(deck)
    (tmp_path / "table.obj").write_text("v -30 -30 -5\nv 50 -30 -5\nv 50 50 -5\nv -30 50 -5\nf 1 2 3 4\nl 1 2\n")
    table = MeshShape.from_file(tmp_path / "table.obj", unit_scale=0.001, spacing=1e-3)
    blank = Blank.from_file(tmp_path / "sheet.inp", unit_scale=0.001)
    sheet = Sheet(blank, glass_polypropylene())
    setup = Setup(name="read", sheets=(sheet,), tools=(Tool("table", table),), duration=1e-4, solver=Solver(threads=1))
    notes = "\n".join(prepare(setup).info.notes)
    assert "sheet.inp: 1 nodes left out: no element uses them" in notes
    assert "table.obj: 1 quadrilaterals split into 2 triangles" in notes
    assert "table.obj: 1 lines and 0 points left out: they bound no surface" in notes


def test_what_has_not_been_run_is_not_trusted():
    run = small_run()
    assert run.verdict == "not run" and not run.trusted
    run.run()
    assert run.verdict == "trusted" and run.trusted
