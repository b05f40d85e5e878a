"""Where tools stand when a stage begins, and strokes that close from there; what only the run knows is refused."""

import numpy as np
import pytest

from tests.support.jobs import TRAY, changed, write_tray
from weavesim import AtForce, AtRest, AtStroke, Fixed, ForceDriven, InputError, Stage, Stroke
from weavesim.job.build import setup_of
from weavesim.job.read import read_job
from weavesim.job.stages.places import Places
from weavesim.tools.shapes import Plane
from weavesim.tools.tool import Tool

STROKE = Stroke((0.0, 0.01), (0.0, 0.02))
ONLY = frozenset({"punch"})


def after(motion, *stages: Stage, acting=ONLY) -> float | None:
    places = Places({"punch": Tool("punch", Plane(), motion)})
    for stage in stages:
        places.go_through(stage, acting)
    return places.at("punch")


def moves(motion) -> dict:
    return {"moves": {"punch": motion}}


BACK = Stroke((0.0, 0.01), (0.0, -0.005))


@pytest.mark.parametrize(
    ("motion", "stages", "place"),
    [
        (STROKE, [], 0.0),
        (STROKE, [Stage("a", 0.005)], 0.01),
        (STROKE, [Stage("a", 0.03)], 0.02),
        (STROKE, [Stage("a", 0.004), Stage("b", 0.004)], 0.016),
        (STROKE, [Stage("a", 0.03), Stage("b", 0.02, **moves(BACK))], 0.015),
        # a stage that may end earlier leaves a stroke somewhere, unless it was over
        (STROKE, [Stage("a", 0.03, AtForce("punch", 10.0))], None),
        (STROKE, [Stage("a", 0.03, AtForce("punch", 10.0)), Stage("b", 0.02, **moves(BACK))], None),
        (STROKE, [Stage("a", 0.03), Stage("b", 0.5, AtRest(0.01, 0.01))], 0.02),
        (STROKE, [Stage("a", 0.03, AtForce("punch", 10.0)), Stage("b", 0.02)], 0.02),
        (STROKE, [Stage("a", 0.03, AtStroke("punch", 0.012))], 0.012),
        (STROKE, [Stage("a", 0.03, AtStroke("punch", 0.012)), Stage("b", 1.0, **moves(Fixed()))], 0.012),
        (STROKE, [Stage("a", 0.03, AtStroke("punch", 0.012)), Stage("b", 0.001)], None),
        # a largest force lets it wait on the way
        (Stroke((0.0, 0.01), (0.0, 0.02), 50.0), [Stage("a", 0.03)], None),
        (Stroke((0.0, 0.01), (0.0, 0.02), 50.0), [], 0.0),
        (ForceDriven((0.0,), (5.0,), 1.0), [], None),
    ],
)
def test_the_place_is_that_of_the_strokes_so_far(motion, stages, place):
    found = after(motion, *stages)
    assert found is None if place is None else found == pytest.approx(place, abs=1e-15)


def test_a_tool_that_does_not_act_stays_where_it_is():
    away = frozenset[str]()
    assert after(STROKE, Stage("a", 0.03), acting=away) == 0.0  # its stroke begins when it first acts
    places = Places({"punch": Tool("punch", Plane(), STROKE)})
    places.go_through(Stage("a", 0.005), ONLY)
    places.go_through(Stage("b", 0.5), away)
    assert places.at("punch") == pytest.approx(0.01)


STAGES = """
[[stage]]
name = "close"

[[stage]]
name = "open"
[[stage.move]]
name = "punch"
stroke = "-30 mm"
speed = "1 m/s"

[[stage]]
name = "again"
[[stage.move]]
name = "punch"
stroke = "close"
speed = "0.5 m/s"
"""


def setup_with(folder, *changes, more=""):
    text = changed(TRAY + STAGES + more, *changes, count=1)
    return setup_of(read_job(write_tray(folder, text)))


def test_a_stage_may_close_a_tool_from_where_it_stands(tmp_path):
    setup = setup_with(tmp_path)
    first, again = setup.tools[1].motion, setup.stages[2].moves[0].motion
    assert again.displacements[-1] == pytest.approx(0.03, abs=1e-12)
    assert max(np.diff(again.displacements) / np.diff(again.times)) == pytest.approx(0.5, rel=1e-6)
    # the first stroke closed it: stages close it as [[tool]] does, to the bit where it has not moved
    still = ('stroke = "close"\nspeed = "1 m/s"\n', "")
    held = setup_with(tmp_path, still, ('name = "close"\n', 'name = "close"\nduration = "5 ms"\n'),
                      ('stroke = "-30 mm"\nspeed = "1 m/s"\n', "fixed = true\n"), ("speed = \"0.5", "speed = \"1"),
                      ('name = "open"\n', 'name = "open"\nduration = "5 ms"\n'))  # fmt: skip
    assert held.stages[2].moves[0].motion == first


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "close"\n', 'name = "close"\nend = { tool = "punch", force = "1 kN" }\nduration = "30 ms"\n',
         r"\[\[stage\]\] again, \[\[stage.move\]\] punch: stroke = \"close\": where punch stands when the stage begins"
         " is decided by the run"),
        ('stroke = "-30 mm"', 'stroke = "3 mm"', "punch stands 3 mm beyond where it is drawn when the stage begins"),
        ('name = "punch"\nstroke = "close"\nspeed = "0.5', 'name = "ring"\nstroke = "close"\nspeed = "0.5',
         "where ring stands when the stage begins is decided by the run"),
        ('stroke = "close"\nspeed = "0.5 m/s"', 'stroke = "cloze"\nspeed = "0.5 m/s"', "or 'close'"),
        ('stroke = "close"\nspeed = "0.5 m/s"', 'stroke = "close"', "speed: is required with a stroke"),
    ],
)  # fmt: skip
def test_what_cannot_close_is_refused(tmp_path, old, new, message):
    with pytest.raises(InputError, match=message):
        setup_with(tmp_path, (old, new))


def test_a_tool_that_moves_by_gaps_closes_to_where_it_is_drawn(tmp_path):
    """It starts behind that by its first gap."""
    gaps = ('force = "600 N"', 'gaps = ["1.5 mm", "0.5 mm"]\ntimes = ["0 ms", "10 ms"]')
    first = ('name = "close"\n', 'name = "close"\nduration = "50 ms"\n')
    opening = ('name = "open"\n', 'name = "open"\nduration = "40 ms"\n')
    ring = ('name = "punch"\nstroke = "close"\nspeed = "0.5', 'name = "ring"\nstroke = "close"\nspeed = "0.5')
    setup = setup_with(tmp_path, gaps, first, opening, ring)
    # from a gap of 0.5 mm
    assert setup.stages[2].moves[0].motion.displacements[-1] == pytest.approx(0.5e-3, abs=1e-9)


def test_only_whole_tools_close(tmp_path):
    spring = '\n[[spring]]\nname = "corner"\ncorners = true\nstiffness = "1 N/mm"\n'
    move = ('name = "punch"\nstroke = "close"\nspeed = "0.5', 'name = "corner"\nstroke = "close"\nspeed = "0.5')
    with pytest.raises(InputError, match="corner is no whole .*tool.* that is drawn closed"):
        setup_with(tmp_path, move, more=spring)
