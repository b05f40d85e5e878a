"""Tools of a job that are cut into segments: their surfaces, forces and gaps, in stages too; bad ones are refused."""

import numpy as np
import pytest

from tests.support.jobs import TRAY, write_tray
from weavesim import Fixed, ForceDriven, InputError
from weavesim.job.build import setup_of
from weavesim.job.read import read_job

RING = 'ring_of = "die"\nforce = "600 N"\nmass = "0.6 kg"\n'
OWN = """
[[tool.segment]]
number = 2
force = "30 N"

[[tool.segment]]
number = 3
times = ["0 ms", "20 ms"]
forces = ["0 N", "90 N"]

[[tool.segment]]
number = 5
gap = "0.2 mm"
"""


def setup_with(folder, ring=RING, more=""):
    old = 'ring_of = "die"\nforce = "600 N"\n'
    assert old in TRAY
    return setup_of(read_job(write_tray(folder, TRAY.replace(old, ring, 1) + more)))


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return setup_with(tmp_path_factory.mktemp("whole")).tools[-1]


def plan_area(tool) -> float:
    vertices, faces = tool.display_triangles()
    p, q, r = (vertices[faces[:, k]] for k in range(3))
    normal = np.cross(q - p, r - p)
    return float(-0.5 * normal[normal[:, 2] < 0.0, 2].sum())


def test_segments_are_the_ring_and_share_its_force(tmp_path, whole):
    tools = setup_with(tmp_path, RING + 'segments = 8\nsegments_from = "10 deg"\n').tools
    parts = [tool for tool in tools if tool.name.startswith("ring")]
    assert [tool.name for tool in parts] == [f"ring_{k}" for k in range(1, 9)] and len(tools) == 10
    areas = np.array([plan_area(tool) for tool in parts])
    assert areas.sum() == pytest.approx(plan_area(whole), rel=1e-6)
    forces = np.array([tool.motion.forces[-1] for tool in parts])
    assert forces == pytest.approx(whole.motion.forces[-1] * areas / areas.sum())
    assert sum(tool.motion.mass for tool in parts) == pytest.approx(whole.motion.mass)
    assert all(tool.motion.times == whole.motion.times and tool.axis == whole.axis for tool in parts)
    # the same face, wherever a node is under it
    points = np.column_stack([whole.display_triangles()[0][:, :2], np.full(len(whole.display_triangles()[0]), -1e-4)])
    points += (0.0, 0.0, whole.display_triangles()[0][:, 2].min())
    expected = whole.distance(points)[0]
    found = np.min([tool.distance(points)[0] for tool in parts], axis=0)
    np.testing.assert_allclose(found, expected, atol=2e-5)


def test_each_has_its_own_load(tmp_path):
    setup = setup_with(tmp_path, RING + 'segments = 6\nstop = "0.1 mm"\n' + OWN)
    ring = {tool.name: tool for tool in setup.tools}
    assert ring["ring_2"].motion.forces == (0.0, 30.0) and ring["ring_2"].motion.stop == 1e-4
    assert ring["ring_3"].motion == ForceDriven((0.0, 0.02), (0.0, 90.0), ring["ring_3"].motion.mass, stop=1e-4)
    assert ring["ring_5"].motion == Fixed()
    lowest = {name: tool.display_triangles()[0][:, 2].min() for name, tool in ring.items()}
    assert lowest["ring_5"] - lowest["ring_2"] == pytest.approx(2e-4)
    assert setup.leading_tool == 1


def test_a_segment_has_its_force_where_the_whole_has_none(tmp_path):
    whole = 'ring_of = "die"\nforce = "0 N"\nmass = "0.6 kg"\nsegments = 4\nramp = "5 ms"\n'
    setup = setup_with(tmp_path, whole + '\n[[tool.segment]]\nnumber = 2\nforce = "100 N"\n')
    ring = {tool.name: tool.motion for tool in setup.tools}
    assert ring["ring_2"].forces == (0.0, 100.0) and ring["ring_2"].times == (0.0, 5e-3)
    assert max(ring["ring_1"].forces) == 0.0
    alone = setup_with(tmp_path, whole.replace('force = "0 N"\n', "") + "".join(
        f'\n[[tool.segment]]\nnumber = {k}\nforce = "100 N"\n' for k in range(1, 5)
    ))  # fmt: skip
    assert alone.tools[-1].motion.times == (0.0, 5e-3)


def test_stages_keep_the_spacers_and_know_the_friction_of_the_whole(tmp_path):
    stages = """
[[stage]]
name = "close"
duration = "20 ms"

[[stage]]
name = "ease"
duration = "5 ms"
friction = { ring = 0.05 }
[[stage.move]]
name = "ring_1"
force = "5 N"
"""
    setup = setup_with(tmp_path, RING + 'segments = 4\nstop = "0.1 mm"\n', stages)
    ease = setup.stages[1]
    assert ease.moves[0].motion.stop == 1e-4
    assert [(each.name, each.friction) for each in ease.friction] == [(f"ring_{k}", 0.05) for k in range(1, 5)]


def test_a_force_may_be_a_curve(tmp_path):
    curve = 'ring_of = "die"\ntimes = [0, "10 ms", "30 ms"]\nforces = [0, "600 N", "200 N"]\nmass = "0.6 kg"\n'
    assert setup_with(tmp_path, curve).tools[-1].motion == ForceDriven((0.0, 0.01, 0.03), (0.0, 600.0, 200.0), 0.6)


def test_stages_know_the_whole_and_each(tmp_path):
    stages = """
[[stage]]
name = "close"
duration = "20 ms"

[[stage]]
name = "ease"
duration = "5 ms"
[[stage.move]]
name = "ring_1"
force = "5 N"

[[stage]]
name = "stay"
duration = "5 ms"
[[stage.move]]
name = "ring"
fixed = true

[[stage]]
name = "open"
duration = "5 ms"
tools = ["die", "ring"]
"""
    setup = setup_with(tmp_path, RING + "segments = 4\n", stages)
    close, ease, stay, opened = setup.stages
    assert ease.moves[0].motion.forces[-1] == 5.0
    assert ease.moves[0].motion.mass == pytest.approx(setup.tools[2].motion.mass)
    assert {move.name for move in stay.moves} == {f"ring_{k}" for k in range(1, 5)}
    assert opened.tools == ("die", "ring_1", "ring_2", "ring_3", "ring_4")


def test_a_gap_may_be_a_curve_of_the_whole_and_of_each(tmp_path, whole):
    """Where it starts and how it moves add up to the gap at every time."""
    curve = 'ring_of = "die"\ntimes = [0, "10 ms", "30 ms"]\ngaps = ["0.5 mm", 0, "0.2 mm"]\n'

    def gap(tool, time):
        lowest = tool.display_triangles()[0][:, 2].min() - tool.motion.displacement_at(time)  # its axis points down
        return lowest - whole.display_triangles()[0][:, 2].min()

    alone = setup_with(tmp_path, curve).tools[-1]
    assert [gap(alone, time) for time in (0.0, 0.01, 0.02, 0.03)] == pytest.approx([5e-4, 0.0, 1e-4, 2e-4])
    own = '\n[[tool.segment]]\nnumber = 2\ntimes = ["5 ms", "10 ms"]\ngaps = ["0.1 mm", "0.3 mm"]\n'
    own += '\n[[tool.segment]]\nnumber = 3\nforce = "30 N"\n\n[[tool.segment]]\nnumber = 4\ngap = "0.4 mm"\n'
    ring = {tool.name: tool for tool in setup_with(tmp_path, curve + "segments = 4\n" + own).tools}
    assert [gap(ring["ring_1"], time) for time in (0.0, 0.01, 0.03)] == pytest.approx([5e-4, 0.0, 2e-4])
    assert [gap(ring["ring_2"], time) for time in (0.0, 0.0075, 0.03)] == pytest.approx([1e-4, 2e-4, 3e-4])
    assert ring["ring_3"].motion.forces[-1] == 30.0 and gap(ring["ring_4"], 0.0) == pytest.approx(4e-4)


@pytest.mark.parametrize(
    ("ring", "more", "message"),
    [
        (RING + "segments = 1\n", "", "segments"),
        (RING + "segments = 100\n", "", "segments"),
        (RING + 'segments_from = "5 deg"\n', "", "has no effect without segments"),
        (RING + OWN, "", "segment: has no effect without segments"),
        (RING + "segments = 4\n" + OWN, "", "number = 5: the tool has 4 segments"),
        (RING + "segments = 4\n" + "\n[[tool.segment]]\nnumber = 1\ngap = 0\n" * 2, "", "number = 1 is given twice"),
        (RING + "segments = 4\n\n[[tool.segment]]\nnumber = 1\n", "", "force, forces, gap or gaps: one of them"),
        (RING + 'times = ["0 ms"]\n', "", "has no effect without forces or gaps"),
        ('ring_of = "die"\nforces = ["5 N"]\nmass = "0.6 kg"\n', "", "times: is required with forces"),
        ('ring_of = "die"\nforces = ["-5 N"]\ntimes = [0]\nmass = "0.6 kg"\n', "", "forces of zero or more"),
        (RING + 'forces = ["5 N"]\ntimes = [0]\n', "", "a tool moves by one of them"),
        ('ring_of = "die"\nsegments = 4\n', "", "it has no load; give the tool a force"),
        ('ring_of = "die"\nstop = "1 mm"\n', "", "stop: has no effect without a force"),
        (RING + "segments = 4\n", '\n[process]\nsymmetry = ["x"]\n', "leave symmetry out"),
        (RING + "segments = 4\nrotation = { axis = [0, 0, 1], angle = 5, speed = 1 }\n", "", "move whole tools"),
        (RING + "segments = 4\n", '\n[[stage]]\nname = "a"\nduration = 1\n[[stage.move]]\nname = "ring"\nforce = 5\n',
         "cut into segments: move each by its name, as ring_1"),
        (RING + "segments = 4\n\n[[tool.segment]]\nnumber = 1\ngaps = [0.0001]\n", "", "times: is required with gaps"),
        (RING + "segments = 4\n\n[[tool.segment]]\nnumber = 1\ntimes = [0, 1]\ngaps = [0, -0.0001]\n", "",
         "gaps of zero or more are needed; they are back from where the tool starts"),
        (RING + "gaps = [0.0001]\ntimes = [0]\n", "", "stroke, force, forces and gaps: a tool moves by one of them"),
        ('ring_of = "die"\ngaps = [0.0001]\ntimes = [0]\nmass = 1\n', "", "mass: has no effect without a force"),
    ],
)  # fmt: skip
def test_bad_segments_are_refused(tmp_path, ring, more, message):
    with pytest.raises(InputError, match=message):
        setup_with(tmp_path, ring, more)
