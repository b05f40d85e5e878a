"""Steps, time, memory and disk are estimated before a run, and absurd ones are asked about."""

import numpy as np
import pytest

from tests.support.runs import one_sheet_setup, small_run
from weavesim.errors import InputError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.run import estimate as module
from weavesim.run.estimate import check_bounds, check_room, duration_text, estimate
from weavesim.sheet.blank import Blank
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Plane, Union
from weavesim.tools.tool import Tool


def setup(**given):
    settings = {
        "name": "small", "blank": Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.005), "fabric": glass_polypropylene(),
        "duration": 1.0, "frame_count": 10,
    }  # fmt: skip
    return one_sheet_setup(**(settings | given))


def test_what_is_estimated():
    found = estimate(setup(), time_step=1.0e-6)
    assert (found.element_count, found.frame_count, found.step_count) == (16, 10, pytest.approx(1.0e6))
    assert found.seconds == pytest.approx(1.0e6 * module.CORE_STEP, rel=0.1)
    assert str(found).startswith("about 1,000,000 steps of 1 us, 15 s, ") and "MB of memory" in str(found)
    assert estimate(setup()).seconds is None and "steps" not in str(estimate(setup()))


def test_meshes_cost_more_than_built_in_shapes():
    vertices = np.array([(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)])
    plate = MeshShape.from_triangles(vertices, np.array([(0, 1, 2), (0, 2, 3)]), side=(0.0, 0.0, 1.0))
    table = Tool("table", Plane())

    def seconds(*shapes):
        tools = (table, *(Tool(f"tool {k}", shape) for k, shape in enumerate(shapes)))
        return estimate(setup(tools=tools), time_step=1.0e-6).seconds

    each = 1.0e6 * 25 * module.MESH_TIME
    assert seconds(plate) - seconds() == pytest.approx(each)
    assert seconds(Union([plate, plate.placed((0.0, 0.0, -1.0)), Plane()])) - seconds() == pytest.approx(2.0 * each)


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.1, "1 s"), (90.0, "90 s"), (600.0, "10 min"), (7200.0, "2 h"), (3e5, "3 days"), (3e9, "95 years")],
)
def test_durations_in_words(seconds, text):
    assert duration_text(seconds) == text


@pytest.mark.parametrize(
    ("given", "time_step", "message"),
    [
        ({}, 1e-30, "more than 1e.08 steps"),
        ({"duration": 50.0}, 1e-7, "more than 1e.08 steps; the run lasts 50 s"),
        ({"frame_count": 10**8}, 1e-5, "more than 24 h; fewer frames than 100,000,000"),
        ({"frame_count": 10**9}, 1e-5, "of memory are free"),
        ({"frame_count": 10**9}, None, "of memory are free"),
    ],
)
def test_absurd_runs_are_asked_about(monkeypatch, given, time_step, message):
    monkeypatch.setattr(module, "available_memory", lambda: 1e12)
    asked = setup(accept_unusual=False, **given)
    with pytest.raises(InputError, match=f"this run would take about .*{message}.*--accept-unusual"):
        check_bounds(estimate(asked, time_step=time_step), asked)
    meant = setup(accept_unusual=True, **given)
    check_bounds(estimate(meant, time_step=time_step), meant)


def test_unknown_memory_is_no_obstacle(monkeypatch):
    monkeypatch.setattr(module, "available_memory", lambda: None)
    given = setup(frame_count=10**9)
    check_bounds(estimate(given), given)


def test_a_run_is_refused_before_its_memory_is_taken(monkeypatch):
    monkeypatch.setattr(module, "available_memory", lambda: 1000.0)
    monkeypatch.setattr("weavesim.run.start.Model", None)
    with pytest.raises(InputError, match="0 MB of memory are free; a coarser mesh"):
        small_run()


def test_a_run_knows_what_it_takes():
    simulation = small_run(duration=1e-3)
    expected = simulation.info.expected
    simulation.run()
    assert expected.step_count == pytest.approx(simulation.state.step_count, rel=0.2)


def test_results_without_room_are_asked_about(monkeypatch, tmp_path):
    given = setup(frame_count=1000)
    check_room(estimate(given), given, tmp_path)
    monkeypatch.setattr(module.shutil, "disk_usage", lambda folder: type("Usage", (), {"free": 1000}))
    with pytest.raises(InputError, match="0 MB are free, but this run would take about"):
        check_room(estimate(given), given, tmp_path)


def test_a_folder_that_has_gone_is_told(tmp_path):
    given = setup()
    with pytest.raises(InputError, match="it was there, and is no longer .No such file or directory.; run it again"):
        check_room(estimate(given), given, tmp_path / "gone")
