"""What a job had to be able to say at least, in one small job that is run: every word of it is seen in the result."""

import csv
import re

import numpy as np
import pytest

from tests.support.jobs import tray_surface, write_stl
from weavesim.app.jobs.form import run_job
from weavesim.job.build import setup_of
from weavesim.job.check import check_setup
from weavesim.job.read import read_job
from weavesim.output.export.nearest import nearest
from weavesim.output.stored.file import read_results

SPRING_LIMIT, RING_FORCE, PUNCH_FORCE, GAP = 1.5, 600.0, 150.0, 1.2e-3
# An octagonal blank at 45 degrees, a punch made from the die by offset, 1.2 mm from it when closed, a holder ring in
# touch with 600 N, four corner springs with a limit, gravity first, then closing until the punch meets a force.
JOB = """\
name = "press"

[[ply]]
fabric = "glass-polypropylene"
polygon = [
    ["95 mm", "40 mm"], ["95 mm", "-40 mm"], ["40 mm", "-85 mm"], ["-40 mm", "-85 mm"],
    ["-95 mm", "-40 mm"], ["-95 mm", "40 mm"], ["-40 mm", "85 mm"], ["40 mm", "85 mm"],
]
angle = "45 deg"
mesh_size = "10 mm"

[[tool]]
name = "die"
file = "die.stl"
unit = "mm"
faces = "up"

[[tool]]
name = "punch"
offset_of = "die"
gap = "1.2 mm"
start = "touching"
clearance = "1 mm"
stroke = "close"
speed = "0.1 m/s"

[[tool]]
name = "ring"
ring_of = "die"
force = "600 N"
mass = "0.6 kg"
ramp = "1 ms"

[[spring]]
name = "corner"
points = [["67 mm", "62 mm"], ["-67 mm", "62 mm"], ["-67 mm", "-62 mm"], ["67 mm", "-62 mm"]]
radius = "12 mm"
stiffness = "0.5 N/mm"
pretension = "1 N"
largest_force = "1.5 N"

[[stage]]
name = "gravity"
duration = "15 ms"
tools = ["die", "ring"]
gravity = "9.81 m/s^2"
frame_count = 3

[[stage]]
name = "close"
tools = ["die", "punch", "ring"]
end = { tool = "punch", force = "150 N" }
frame_count = 8

[output]
write = ["summary", "tables", "results"]
"""


@pytest.fixture(scope="module")
def pressed(tmp_path_factory):
    """The run at the speed that the check proposes: (job, summary, rows of history.csv, its end)."""
    folder = tmp_path_factory.mktemp("press")
    write_stl(folder / "die.stl", *tray_surface(length=130.0, width=110.0, depth=16.0, fillet=6.0, entry=8.0))
    path = folder / "press.toml"
    path.write_text(JOB, encoding="utf-8")
    proposed = next(row for row in check_setup(setup_of(read_job(path))).rows if row.topic == "speeds")
    speed = re.search(r"suggested: ([\d.]+) m/s", proposed.advice)[1]
    job = read_job(path, [f"tools.punch.speed={speed} m/s"])
    summary = run_job(job, folder / "out")
    with open(folder / "out" / "history.csv", encoding="utf-8", newline="") as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    return setup_of(job), summary, rows, read_results(folder / "out")


@pytest.mark.slow
def test_the_blank_is_an_octagon_with_yarns_at_45_degrees(pressed):
    setup, summary, _, _ = pressed
    blank = setup.sheet.blank
    assert len(blank.boundary_loop()) > 40 and summary["outcome"] == "finished"
    assert blank.warp_direction == pytest.approx(np.tile([np.sqrt(0.5), np.sqrt(0.5), 0.0], (blank.element_count, 1)))
    corner = blank.node_position[blank.quads]
    area = 0.5 * np.linalg.norm(np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]), axis=1).sum()
    assert area == pytest.approx(0.19 * 0.17 - 4 * 0.5 * 0.055 * 0.045, rel=1e-6)


@pytest.mark.slow
def test_the_ring_holds_with_its_force_from_the_start(pressed):
    _, _, rows, _ = pressed
    # the first frame is that of time zero, when the force begins to grow
    assert [row["ring_wanted_force_n"] for row in rows[1:]] == pytest.approx([RING_FORCE] * (len(rows) - 1))
    force = np.array([row["ring_force_z_n"] for row in rows[1:]])
    assert force == pytest.approx(RING_FORCE, rel=0.25) and force[-3:].mean() == pytest.approx(RING_FORCE, rel=0.05)
    assert max(abs(row["ring_displacement_m"]) for row in rows) < 0.3e-3


@pytest.mark.slow
def test_gravity_comes_first_and_the_punch_waits(pressed):
    _, summary, rows, _ = pressed
    gravity, close = summary["stages"]
    assert (gravity["name"], close["name"]) == ("gravity", "close")
    first = [row for row in rows if row["time_s"] <= gravity["end_s"] + 1e-9]
    assert len(first) == 4 and all(row["punch_displacement_m"] == 0.0 for row in first)
    # the blank has sagged into the opening under its weight: gravity has done work on it
    assert first[-1]["gravity_work_j"] > 0.0


@pytest.mark.slow
def test_the_springs_slip_at_their_limit(pressed):
    setup, _, rows, _ = pressed
    names = [gripper.name for gripper in setup.grippers]
    assert names == ["corner_1", "corner_2", "corner_3", "corner_4"]
    forces = np.array([[row[f"{name}_gripper_force_n"] for name in names] for row in rows])
    assert forces.max() <= SPRING_LIMIT * (1.0 + 1e-6) and forces[-1] == pytest.approx(SPRING_LIMIT, rel=1e-3)
    assert all(rows[-1][f"{name}_gripper_slip_m"] > 0.1e-3 for name in names)


@pytest.mark.slow
def test_the_press_stops_at_the_force_of_the_punch(pressed):
    setup, summary, rows, _ = pressed
    close = summary["stages"][1]
    assert close["ended_by"] == "force" and close["reached"]
    assert abs(rows[-1]["punch_force_z_n"]) == pytest.approx(PUNCH_FORCE, rel=0.35)
    whole = setup.tools[1].motion.displacements[-1]
    assert 0.3 * whole < rows[-1]["punch_displacement_m"] < whole


@pytest.mark.slow
def test_the_punch_would_close_to_the_gap(pressed):
    setup, _, _, run = pressed
    die, punch = setup.tools[0], setup.tools[1]
    closed = punch.display_triangles()[0] - (0.0, 0.0, punch.motion.displacements[-1])
    vertices, faces = die.display_triangles()
    near, _ = nearest(np.asarray(vertices)[faces], closed[::5])
    assert np.median(np.linalg.norm(near - closed[::5], axis=1)) == pytest.approx(GAP, rel=0.01)
    # and what it had formed until then is a tray: in its middle the sheet hangs below its border
    height = run.sheets[0].position[:, 2]
    assert height.max() - height.min() > 3e-3
