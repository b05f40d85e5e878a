# ruff: noqa: E501
"""Stages of a job are those of a script; broken ones are refused with their place and what is allowed."""

import numpy as np
import pytest

from tests.support.jobs import TRAY, changed, write_tray
from weavesim import AtForce, AtRest, AtStroke, Fixed, ForceDriven, InputError, Pressure, Setup, Stage, Stroke
from weavesim.job.build import setup_of
from weavesim.job.read import read_job
from weavesim.job.stages.told import stage_lines
from weavesim.process.stages import SheetPressure

STAGES = """
[[spring]]
name = "corner"
corners = true
stiffness = "0.5 N/mm"

[[stage]]
name = "close"
duration = "30 ms"
end = { force = "5 kN", tool = "punch" }

[[stage]]
name = "hold"
duration = "5 ms"
frame_count = 2

[[stage.move]]
name = "punch"
fixed = true

[[stage.move]]
name = "ring"
times = ["0 ms", "2 ms"]
forces = ["600 N", "100 N"]
mass = "0.5 kg"

[[stage.pressure]]
face = "top"
pressure = "0.8 bar"
ramp = "1 ms"

[[stage]]
name = "open"
duration = "80 ms"
tools = ["die", "punch"]
grippers = []
pressure = []
gravity = "9.81 m/s^2"
damping = "200 1/s"
director_damping = 5000
target_step = "0.001 ms"

[[stage.move]]
name = "punch"
stroke = "-20 mm"
speed = "400 mm/s"
ramp = "2 ms"
delay = "1 ms"

[stage.end]
rest = 0.01
speed = "20 mm/s"
"""


def setup_with(folder, stages, *changes):
    text = changed(TRAY + stages, *changes, count=1)
    return setup_of(read_job(write_tray(folder, text)))


def test_stages_of_a_job_are_those_of_a_script_to_the_bit(tmp_path):
    job = setup_with(tmp_path, STAGES)
    stages = (
        Stage("close", 0.03, AtForce("punch", 5000.0)),
        Stage(
            "hold", 0.005,
            moves={"punch": Fixed(), "ring": ForceDriven((0.0, 0.002), (600.0, 100.0), 0.5)},
            pressures=(SheetPressure(Pressure("top", (0.0, 8.0e4), (0.0, 0.001)), "ply"),),
            frame_count=2,
        ),
        Stage(
            "open", 0.08, AtRest(0.01, 0.02),
            tools=("die", "punch"),
            grippers=(),
            moves={"punch": Stroke.smooth(-0.02, 0.4, 0.002, 0.001)},
            pressures=(),
            gravity=(0.0, 0.0, -9.81),
            damping=200.0,
            director_damping=5000.0,
            target_step=1.0e-6,
        ),
    )  # fmt: skip
    script = Setup("tray", job.worlds, frame_count=10, leading_tool=1, solver=job.solver, stages=stages)
    assert job == script
    assert job.duration == 0.03 + 0.005 + 0.08


def test_a_stage_takes_the_time_of_the_strokes_that_begin_in_it(tmp_path):
    text = '\n[[stage]]\nname = "close"\n\n[[stage]]\nname = "open"\n[[stage.move]]\nname = "punch"\nstroke = "-5 mm"\nspeed = "1 m/s"\n'
    job = setup_with(tmp_path, text)
    assert job.stages[0].duration == job.tools[1].motion.duration
    assert job.stages[1].duration == job.stages[1].moves[0].motion.duration > 0.005


def test_forces_of_a_job_are_of_the_whole_press_and_a_group_moves_as_one(tmp_path):
    text = STAGES.replace("corners = true", 'points = [["95 mm", "75 mm"], ["5 mm", "75 mm"]]').replace(
        "grippers = []", 'grippers = ["corner"]'
    )
    text = text.replace('rest = 0.01\nspeed = "20 mm/s"', 'stroke = "-10 mm"\ntool = "punch"')
    text += '\n[[stage.move]]\nname = "corner"\nstroke = "2 mm"\nspeed = "1 m/s"\n'
    halves = ("[output]", '[process]\nsymmetry = ["x", "y"]\n[output]')
    quarter = ('rectangle = ["200 mm", "160 mm"]', 'rectangle = ["100 mm", "80 mm"]\ncentre = ["50 mm", "40 mm"]')
    job = setup_with(tmp_path, text, halves, quarter)
    assert job.stages[0].end == AtForce("punch", 1250.0)
    assert job.stages[2].end == AtStroke("punch", -0.01)
    ring = job.stages[1].moves[1].motion
    assert (ring.forces, ring.mass) == ((150.0, 25.0), 0.125)
    assert [move.name for move in job.stages[2].moves] == ["punch", "corner_1", "corner_2"]
    assert job.stages[2].grippers == ("corner_1", "corner_2")


def test_a_pressure_goes_from_another_and_settings_reach_tables_in_stages(tmp_path):
    text = STAGES.replace('pressure = "0.8 bar"', 'pressure = 0\nbefore = "1 bar"')
    path = write_tray(tmp_path, TRAY + text)
    job = setup_of(read_job(path, ["stages.open.move.punch.stroke=-10 mm", "stages.close.end.force=4 kN"]))
    pressed = job.stages[1].pressures[0].pressure
    assert np.array_equal(pressed.at(np.array([0.0, 0.0005, 0.01])), [1.0e5, 5.0e4, 0.0])
    assert job.stages[2].moves[0].motion.displacements[-1] == -0.01
    assert job.stages[0].end.force == 4000.0
    with pytest.raises(InputError, match=r"--set stages.open.move.punsh.stroke=1: there is no 'punsh'"):
        read_job(path, ["stages.open.move.punsh.stroke=1"])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('duration = "30 ms"', 'duratoin = "30 ms"', "line 39, [[stage]] close: duratoin = '30 ms': unknown name; did you mean 'duration'?"),
        ('duration = "30 ms"', 'duration = "30 mm"', "line 39, [[stage]] close: duration = '30 mm': 'mm' is no unit of it, write '2 ms' or a number in s"),
        ('duration = "5 ms"', "", "[[stage]] hold: duration: is required, since no stroke begins in the stage"),
        ('name = "hold"', 'name = "close"', "line 43, [[stage]] close: name = 'close': another [[stage]] has it"),
        ('tool = "punch" }', 'tool = "punsh" }', "line 40, [[stage]] close, end: tool = 'punsh': there is no such [[tool]]; there are die, punch, ring; did you mean 'punch'?"),
        ('force = "5 kN", tool = "punch"', 'force = "5 kN"', "line 40, [[stage]] close: tool: is required with force"),
        ('force = "5 kN", tool', 'force = "5 kN", rest = 0.1, tool', "time, stroke, force or rest: one of them is needed, force and rest are given"),
        ('force = "5 kN"', 'force = "5 m"', "line 40, [[stage]] close, end: force = '5 m': 'm' is no unit of it, write '600 N'"),
        ('force = "5 kN"', 'stroke = "90 mm"', "line 37, [[stage]] close: it can never end at a stroke of 0.09 m: punch moves by at most"),
        ('end = { force = "5 kN", tool = "punch" }', 'end = { time = "1 ms" }', "duration and end.time: one of them is needed, both are given"),
        ('end = { force = "5 kN", tool = "punch" }', 'end = "rest"', "line 40, [[stage]] close: a table is needed"),
        ("fixed = true", 'fixed = true\nforce = "1 N"', "line 47, [[stage]] hold, [[stage.move]] punch: stroke, fixed, force or forces: one of them is needed, fixed and force are given"),
        ("fixed = true", 'fixt = "1 N"', "line 49, [[stage]] hold, [[stage.move]] punch: fixt = '1 N': unknown name; did you mean 'fixed'?"),
        ('times = ["0 ms", "2 ms"]', 'times = ["0 ms"]', "[[stage]] hold, [[stage.move]] ring: "),
        ('speed = "400 mm/s"', "", "[[stage]] open, [[stage.move]] punch: speed: is required with a stroke"),
        ('stroke = "-20 mm"', 'stroke = "-20 N"', "line 75, [[stage]] open, [[stage.move]] punch: stroke = '-20 N': 'N' is no unit of it, write '5 mm'"),
        ('name = "ring"\ntimes', 'name = "rong"\ntimes', "line 52, [[stage]] hold, [[stage.move]] rong: name = 'rong': there is no such [[tool]], [[spring]] or [[gripper]]; there are die, punch, ring, corner_1, corner_2, corner_3, corner_4, corner; did you mean 'ring'?"),
        ('name = "ring"\ntimes', 'name = "punch"\ntimes', "[[stage]] hold: move: punch is moved twice"),
        ('tools = ["die", "punch"]', 'tools = ["dye", "punch"]', "line 65, [[stage]] open: tools = 'dye': there is no such [[tool]]; there are die, punch, ring; did you mean 'die'?"),
        ('tools = ["die", "punch"]', 'supports = ["die"]', "[[stage]] open: supports: a job has none; springs and grippers hold its plies"),
        ("grippers = []", 'grippers = ["corners"]', "line 66, [[stage]] open: grippers = 'corners': there is no such [[spring]] or [[gripper]]"),
        ('tools = ["die", "punch"]', 'tools = ["die"]', "line 62, [[stage]] open: tool punch is moved, but does not act; add it to tools, or leave the move out"),
        ('ramp = "1 ms"', 'ramp = "1 ms"\nply = "top"', "[[stage]] hold, [[stage.pressure]]: ply = 'top': there is none; there are ply"),
        ("[[stage.pressure]]", "[stage.pressure]", "[[stage]] hold: write [[stage.pressure]], since there may be several"),
        ("[output]", '[process]\nhold = "1 ms"\n[output]', "line 30, [process]: hold: has no effect with [[stage]], each of which has its own; leave it out"),
    ],
)  # fmt: skip
def test_a_broken_stage_is_refused_with_its_place_and_what_is_allowed(tmp_path, old, new, message):
    with pytest.raises(InputError) as error:
        setup_with(tmp_path, STAGES, (old, new))
    assert message in str(error.value)


def test_a_tool_that_acts_again_needs_a_motion_in_the_words_of_a_job(tmp_path):
    again = '\n[[stage]]\nname = "again"\nduration = "1 ms"\ntools = ["die", "punch", "ring"]\n'
    with pytest.raises(InputError, match=r"\[\[stage\]\] again: tool ring acts again, .* with fixed = true to stay"):
        setup_with(tmp_path, STAGES + again)


def test_a_tool_that_never_acts_is_refused(tmp_path):
    text = '\n[[stage]]\nname = "close"\ntools = ["die", "punch"]\n'
    with pytest.raises(InputError, match=r"\[\[stage\]\]: tool ring acts in none of them; add it to the tools of one"):
        setup_with(tmp_path, text)


def test_the_stages_of_the_reference_are_those_of_a_job(tmp_path):
    from scripts.doc_tables import text_of

    part = text_of("job.md").split("## Stages\n")[1].split("\n## ")[0]
    job = setup_with(tmp_path, "\n".join(line[4:] for line in part.splitlines() if line.startswith("    ")))
    assert [stage.name for stage in job.stages] == ["close", "hold", "release"]
    assert job.stages[0].end == AtForce("punch", 5000.0) and job.stages[2].end == AtRest(1.0e-3, 0.01)


def test_a_group_has_none_of_another_table(tmp_path):
    other = '\n[[spring]]\nname = "corner_5"\npoints = [["0 mm", "70 mm"]]\nstiffness = 10\n'
    job = setup_with(tmp_path, STAGES + other, ("grippers = []", 'grippers = ["corner"]'))
    assert job.stages[2].grippers == ("corner_1", "corner_2", "corner_3", "corner_4")


def test_forces_of_stages_are_told_as_those_of_the_whole_press(tmp_path):
    halves = ("[output]", '[process]\nsymmetry = ["x", "y"]\n[output]')
    quarter = ('rectangle = ["200 mm", "160 mm"]', 'rectangle = ["100 mm", "80 mm"]\ncentre = ["50 mm", "40 mm"]')
    stages = STAGES.replace("corners = true", 'points = [["95 mm", "75 mm"]]')
    told = dict(stage_lines(setup_with(tmp_path, stages, halves, quarter)))
    assert "punch is pushed with 5000 N" in told["close"]
    assert "ring pushed with 100 N" in told["hold"]
