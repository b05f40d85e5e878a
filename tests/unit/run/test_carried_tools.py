"""A flap that turns, then follows a path from where it is: its pose in state, frames, files, and after a resume."""

import csv

import numpy as np
import pytest

from tests.support.frames import Frames
from weavesim import Dynamics, ResultFolder, Setup, Sheet, Simulation, Stage, Support, Tool
from weavesim.errors import InputError
from weavesim.fabric import glass_polypropylene
from weavesim.output.film.reading import StoredFilm
from weavesim.output.stored.file import read_results
from weavesim.output.stored.judged import ToolsOfRun, tool_distance
from weavesim.process.motions.paths import PathMotion, Pose, Rotation, turn_matrix
from weavesim.process.strokes import Fixed, Stroke
from weavesim.run.checkpoint import checkpoints as module
from weavesim.run.checkpoint.checkpoints import Checkpoints
from weavesim.run.frame import Outcome
from weavesim.sheet.blank import Blank
from weavesim.tools.shapes import Plane, Sphere

FABRIC = glass_polypropylene()
HALF = 0.5 * FABRIC.thickness
Y = (0.0, 1.0, 0.0)
HINGE = (0.0, 0.0, -HALF)
THERE = (0.01, 0.0, 0.0)
FIRST, SECOND = 10.0, 15.0
WAY = (1.0e-3, 0.0, 2.0e-3)


def setup(**given) -> Setup:
    """The flap closes by a stroke and turns; then it turns about another hinge, on a path; then it stays."""
    blank = Blank.rectangle((-0.02, 0.0), (0.02, 0.01), 0.005)
    clamp = Support("clamp", np.flatnonzero(blank.node_position[:, 0] < -0.01 + 1e-9))
    turn = Rotation(Y, HINGE, (0.0, 0.004), (0.0, -FIRST))
    again = PathMotion((0.0, 0.004), ((0.0, 0.0, 0.0), WAY), Rotation(Y, THERE, (0.0, 0.004), (0.0, -SECOND)), Fixed())
    stroke = Stroke((0.0, 0.004), (0.0, 5.0e-4))
    tools = (
        Tool("ball", Sphere(0.004, origin=(-0.015, 0.005, 0.01))),
        Tool("flap", Plane(origin=HINGE), PathMotion(rotation=turn, along=stroke), axis=(0.0, 0.0, 1.0)),
    )
    stages = (
        Stage("turn", 0.004, frame_count=4),
        Stage("carry", 0.004, moves={"flap": again}, frame_count=4),
        Stage("stay", 0.001, moves={"flap": Fixed()}, frame_count=1),
    )
    return Setup(
        "flap", sheets=(Sheet(blank, FABRIC, supports=(clamp,)),), tools=tools, stages=stages, leading_tool=1,
        dynamics=Dynamics(damping=50.0), **given,
    )  # fmt: skip


def expected() -> tuple[Pose, Pose]:
    """Where the flap is after the first and after the second stage."""
    first = turn_matrix(Y, -np.radians(FIRST))
    shift = np.array(HINGE) - first @ np.array(HINGE) + (0.0, 0.0, 5.0e-4)
    second = turn_matrix(Y, -np.radians(SECOND))
    return Pose.of(first, shift), Pose.of(second @ first, second @ (shift - THERE) + THERE + WAY)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder, frames, simulation = tmp_path_factory.mktemp("flap"), Frames(), Simulation(setup())
    results = ResultFolder(folder, overwrite=True)
    assert simulation.run([frames, results]) is Outcome.FINISHED
    results.write({})
    return simulation, frames.all, folder


def close(pose: Pose, wanted: Pose) -> bool:
    return bool(np.abs(np.array(pose.numbers) - wanted.numbers).max() < 1e-9)


def test_a_stage_carries_on_from_the_pose_that_it_finds(whole):
    _, frames, _ = whole
    first, second = expected()
    by_stage = {frame.stage: frame for frame in frames}
    assert close(by_stage["turn"].place(1), first)
    assert close(by_stage["carry"].place(1), second) and close(by_stage["stay"].place(1), second)
    assert close(frames[-1].place(0), Pose())
    # half way through the second stage it has turned by half: cubic curves at rest at both ends are symmetric
    middle = next(frame for frame in frames if frame.stage == "carry" and abs(frame.time - 0.006) < 2e-5)
    turned = np.degrees(np.arctan2(middle.tool_pose[1, 6], middle.tool_pose[1, 0]))
    assert turned == pytest.approx(FIRST + 0.5 * SECOND, abs=0.2)


def test_the_flap_lifts_the_sheet_and_its_work_is_booked(whole):
    simulation, frames, _ = whole
    assert frames[-1].position[:, 2].max() > 3e-3
    assert max(frame.tool_moment[1, 1] for frame in frames) > 0.0 and not frames[-1].tool_moment[0].any()
    energies = simulation.frame.energies
    assert energies["tool_work"] > 0.0
    assert abs(energies["balance_error"]) < 2e-3 * energies["tool_work"]


def test_the_gap_is_that_to_the_true_pose(whole):
    simulation, frames, folder = whole
    stored = read_results(folder)
    assert close(stored.place(1), expected()[1])
    distance = tool_distance(stored, stored.sheets[0], ToolsOfRun(stored.tools))
    found = distance(stored.sheets[0].position)
    normal = stored.place(1).turned(np.array([[0.0, 0.0, 1.0]]))[0]
    of_plane = (stored.sheets[0].position - stored.place(1).moved(np.array([HINGE]))[0]) @ normal
    tip = stored.sheets[0].position[:, 0] > 0.0
    np.testing.assert_allclose(found[tip], of_plane[tip], atol=1e-9)
    assert found[tip].min() > 0.9 * HALF


def test_files_show_the_pose(whole):
    simulation, frames, folder = whole
    drawn, _ = simulation.setup.tools[1].display_triangles()
    there = expected()[1].moved(drawn)
    (path,) = folder.glob("*.usdc")
    film = StoredFilm(path)
    flap = next(tool for tool in film.tools if tool.name == "flap")
    np.testing.assert_allclose(film.points(flap, film.frames[-1]), there, atol=1e-6 * np.abs(there).max())
    np.testing.assert_allclose(film.points(flap, film.frames[0]), drawn, atol=1e-6 * np.abs(there).max())
    with (folder / "history.csv").open() as file:
        last = list(csv.DictReader(file))[-1]
    assert float(last["flap_turn_y_deg"]) == pytest.approx(-FIRST - SECOND, abs=1e-6)
    assert float(last["flap_shift_x_m"]) == pytest.approx(expected()[1].shift[0], abs=1e-9)
    assert float(last["flap_moment_y_n_m"]) == pytest.approx(frames[-1].tool_moment[1, 1])
    import meshio

    written = sorted((folder / "paraview").glob("frame_*_tool_flap.vtu"))
    np.testing.assert_allclose(meshio.read(written[-1]).points, there, atol=1e-6 * np.abs(there).max())


def test_a_run_goes_on_with_the_same_bits(tmp_path, monkeypatch, whole):
    monkeypatch.setattr(module, "LARGEST_SHARE", 1e9)
    monkeypatch.setattr(module, "KEPT_COUNT", 10_000)
    Simulation(setup()).run(checkpoints=Checkpoints(tmp_path, 1e-9))
    wanted = {name: array.numpy().tobytes() for name, array in whole[0].state.arrays()}
    met, files = set(), sorted((tmp_path / module.FOLDER_NAME).glob("0*.bin"), reverse=True)
    for path in files[len(files) // 3 :: len(files) // 3]:
        for later in (tmp_path / module.FOLDER_NAME).glob("0*.bin"):
            if later.name > path.name:
                later.unlink()
        checkpoints, again = Checkpoints(tmp_path), Simulation(setup())
        assert checkpoints.find() is not None
        again.resume(checkpoints)
        met.add(again.stages.name)
        assert again.run() is Outcome.FINISHED
        assert {name: array.numpy().tobytes() for name, array in again.state.arrays()} == wanted
    assert len(met) >= 2


@pytest.mark.parametrize(
    ("move", "message"),
    [
        (PathMotion((0.0, 1.0), ((0.0, 0.0, 1e-3), (0.0, 0.0, 0.0))), "its path is 1 mm away"),
        (PathMotion(rotation=Rotation(Y, HINGE, (0.0,), (5.0,))), "it has turned by 5 degrees"),
        (PathMotion(placed=Pose(shift=(0.0, 0.0, 1.0)).numbers), "placed is where the stage finds it"),
        (PathMotion(along=Stroke((0.0, 1.0), (0.1, 0.2))), "must start from 0"),
    ],
)
def test_a_path_of_a_stage_starts_where_the_tool_is(move, message):
    stages = (Stage("turn", 0.004), Stage("carry", 0.004, moves={"flap": move}))
    with pytest.raises(InputError, match=message):
        Setup(**{**dict(setup()), "stages": stages, "duration": 0.008})
