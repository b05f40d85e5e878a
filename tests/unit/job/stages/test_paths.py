"""Paths and rotations in a job are those of a script; broken ones are refused with their place and what is allowed."""

import pytest

from weavesim import Fixed, ForceDriven, InputError, PathMotion, Rotation, Stroke
from weavesim.job.build import setup_of
from weavesim.job.read import read_job
from weavesim.job.stages.tables import MoveTable
from weavesim.job.stages.told import stage_lines

JOB = """
name = "flap"

[[ply]]
fabric = "glass-polypropylene"
rectangle = ["40 mm", "10 mm"]
mesh_size = "5 mm"

[[tool]]
name = "flap"
shape = { kind = "Plane", origin = ["0 mm", "0 mm", "-0.3 mm"] }
faces = "up"
path = [["0 mm", "0 mm", "0 mm"], ["1 mm", "0 mm", "2 mm"]]
path_times = ["0 ms", "10 ms"]
rotation = { axis = [0, 1, 0], point = [0, 0, "-0.3 mm"], times = [0, "20 ms"], angles = [0, "-0.5 rad"] }

[[tool]]
name = "drum"
shape = { kind = "Capsule", radius = "10 mm", half_length = "30 mm", origin = [0, 0, "10.6 mm"] }
faces = "down"
force = "20 N"
mass = "0.5 kg"

[tool.rotation]
axis = [1, 0, 0]
point = [0, 0, "10.6 mm"]
angle = "-90 deg"
speed = "180 deg/s"
"""

STAGES = """
[[stage]]
name = "turn"

[[stage]]
name = "back"

[[stage.move]]
name = "flap"
rotation = { axis = [0, 1, 0], angle = "20 deg", speed = "2 rad/s", ramp = "10 ms", delay = "1 ms" }

[[stage.move]]
name = "drum"
stroke = "-5 mm"
speed = "0.1 m/s"
path = [[0, 0, 0], [0, "5 mm", 0]]
path_times = [0, "5 ms"]
"""


def read(folder, text):
    path = folder / "flap.toml"
    path.write_text(text)
    return setup_of(read_job(path))


def test_paths_of_a_job_are_those_of_a_script(tmp_path):
    setup = read(tmp_path, JOB)
    flap, drum = setup.tools
    turn = Rotation((0, 1, 0), (0, 0, -3.0e-4), (0.0, 0.02), (0.0, flap.motion.rotation.angles[1]))
    assert flap.motion == PathMotion((0.0, 0.01), ((0, 0, 0), (0.001, 0, 0.002)), turn)
    assert flap.motion.rotation.angles[1] == pytest.approx(-28.64788975654116)
    spin = Rotation.smooth((1, 0, 0), (0, 0, 0.0106), -90.0, drum.motion.largest_rates(0.0, 1.0)[1], 0.025)
    assert drum.motion.along == ForceDriven.constant(20.0, 0.5, 2.0e-3)
    assert drum.motion.rotation.angles == pytest.approx(spin.angles, rel=1e-3)
    # paths and turns are over before the run is
    assert setup.duration == pytest.approx(drum.motion.travel_time + 2.0e-3, abs=1e-2)


def test_a_force_of_nothing_is_a_force(tmp_path):
    table = MoveTable(
        name="drum", path=((0, 0, 0), (0, 0, 1e-3)), path_times=(0, 1e-2), force="0 N", mass="1 kg", ramp="1 ms"
    )
    assert table.force == 0.0 and table.mass == 1.0


def test_stages_have_them_too(tmp_path):
    setup = read(tmp_path, JOB + STAGES)
    moves = {move.name: move.motion for move in setup.stages[1].moves}
    assert moves["flap"] == PathMotion(
        rotation=Rotation.smooth((0, 1, 0), (0, 0, 0), 20.0, 2.0, 0.01, start_time=0.001), along=Fixed()
    )
    assert isinstance(moves["drum"].along, Stroke) and moves["drum"].points[1] == (0.0, 0.005, 0.0)
    told = dict(stage_lines(setup))["back"]
    assert "flap turns by 20 degrees" in told and "drum moves by -5 mm and follows a path of 2 points" in told
    assert setup.stages[1].duration == pytest.approx(moves["flap"].travel_time)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('path_times = ["0 ms", "10 ms"]\n', "", r"line \d+, \[\[tool\]\] flap: path_times: is required with"),
        ('path_times = ["0 ms", "10 ms"]', 'path_times = ["0 ms"]', "1 times for 2 points of the path"),
        ('path_times = ["0 ms", "10 ms"]', 'path_times = ["5 ms", "0 ms"]', "times must increase"),
        ('path = [["0 mm", "0 mm", "0 mm"], ["1 mm", "0 mm", "2 mm"]]\n', "", "has no effect without a path"),
        ('angle = "-90 deg"\n', "", "angle or angles: one of them is needed"),
        ('speed = "180 deg/s"\n', "", "speed: is required with angle"),
        ('speed = "180 deg/s"', 'speed = "180 mm/s"', "'mm/s' is no unit of it, write '90 deg/s'"),
        ("axis = [1, 0, 0]", "axis = [0, 0, 0]", "a direction is needed"),
        ('angles = [0, "-0.5 rad"]', "angles = [0]", "2 times for 1 angles"),
        ('angle = "-90 deg"', 'angel = "-90 deg"', "did you mean 'angle'"),
        ('name = "drum"\nstroke', 'name = "drum"\nfixed = true\nstroke', "one of them is needed"),
        ('stroke = "-5 mm"\nspeed = "0.1 m/s"\n', "fixed = true\n", "fixed: has no effect with a path"),
    ],
)
def test_bad_tables_are_refused(tmp_path, old, new, message):
    text = JOB + STAGES
    assert old in text
    with pytest.raises(InputError, match=message):
        read(tmp_path, text.replace(old, new, 1))


def test_springs_do_not_turn(tmp_path):
    text = JOB + '\n[[spring]]\nname = "edge"\nedge = "+x"\nstiffness = "1 N/mm"\n' + STAGES
    text += '\n[[stage.move]]\nname = "edge"\nrotation = { axis = [0, 1, 0], angle = 5, speed = 1 }\n'
    with pytest.raises(InputError, match="only tools turn; give springs and grippers a stroke or a path"):
        read(tmp_path, text)
