# ruff: noqa: E501
"""Springs, grippers, pressures, lay-ups and forces of a job, where they should be; broken ones refused by name."""

import numpy as np
import pytest

from tests.support.jobs import TRAY, changed, write_tray
from weavesim import InputError
from weavesim.engine.staging.derive import acting_of, planned_begins, stage_setup
from weavesim.job.build import setup_of
from weavesim.job.read import read_job

SPRING = """
[[spring]]
name = "corner"
corners = true
stiffness = "0.5 N/mm"
pretension = "2 N"
largest_force = "10 N"
length = "80 mm"
"""


def setup_with(folder, text, *changes):
    return setup_of(read_job(write_tray(folder, changed(TRAY + text, *changes))))


def test_four_corner_springs_with_a_force_limit(tmp_path):
    sheet = setup_with(tmp_path, SPRING).sheet
    assert [gripper.name for gripper in sheet.grippers] == ["corner_1", "corner_2", "corner_3", "corner_4"]
    for gripper in sheet.grippers:
        assert (gripper.stiffness, gripper.pretension, gripper.largest_force) == (500.0, 2.0, 10.0)
        (node,) = gripper.nodes
        x, y, _ = sheet.blank.node_position[node]
        assert np.allclose([abs(x), abs(y)], [0.1, 0.08])
        assert np.allclose(gripper.direction[:2], np.array([x, y]) / np.hypot(x, y))


def test_a_gripper_at_an_edge_moves(tmp_path):
    text = '\n[[gripper]]\nname = "clamp"\nedge = "-y"\nstiffness = "20 N/mm"\nstroke = "-30 mm"\nspeed = "0.5 m/s"\n'
    sheet = setup_with(tmp_path, text).sheet
    (gripper,) = sheet.grippers
    assert np.allclose(sheet.blank.node_position[gripper.nodes, 1], -0.08) and len(gripper.nodes) == 21
    assert gripper.direction == (0.0, -1.0, 0.0)
    assert gripper.motion.displacements[-1] == pytest.approx(-0.03)


def test_a_gripper_follows_a_path_and_another_in_a_stage(tmp_path):
    text = (
        '\n[[gripper]]\nname = "clamp"\nedge = "-y"\nstiffness = "20 N/mm"\nstroke = "-30 mm"\nspeed = "0.5 m/s"\n'
        'path = [[0, 0, 0], ["5 mm", 0, "20 mm"]]\npath_times = ["0 ms", "30 ms"]\n'
        '\n[[stage]]\nname = "a"\nduration = "80 ms"\n\n[[stage]]\nname = "b"\nduration = "50 ms"\n'
        '[[stage.move]]\nname = "clamp"\npath = [[0, 0, 0], [0, 0, "-4 mm"]]\npath_times = ["0 ms", "10 ms"]\n'
    )
    setup = setup_with(tmp_path, text)
    (gripper,) = setup.sheet.grippers
    assert gripper.way_at(0.1) == pytest.approx([0.005, 0.03, 0.02])
    course = acting_of(setup)
    second = stage_setup(setup, course[1], planned_begins(setup, course))
    (gripper,) = second.sheet.grippers
    assert gripper.way_at(0.08) == pytest.approx([0.005, 0.03, 0.02])
    assert gripper.way_at(0.085) == pytest.approx([0.005, 0.03, 0.018])
    assert gripper.way_at(0.13) == pytest.approx([0.005, 0.03, 0.016])
    turned = text.replace(
        'path_times = ["0 ms", "10 ms"]',
        'path_times = ["0 ms", "10 ms"]\nrotation = {angle = 5, speed = 1, axis = [0, 0, 1]}',
    )
    with pytest.raises(
        InputError, match=r"clamp is no \[\[tool\]\]: only tools turn; give springs and grippers a stroke or a path"
    ):
        setup_with(tmp_path, turned)


def test_a_patch_around_a_point(tmp_path):
    text = '\n[[spring]]\nname = "tack"\npoints = [["0 mm", "70 mm"]]\nradius = "15 mm"\nstiffness = 100\n'
    sheet = setup_with(tmp_path, text).sheet
    place = sheet.blank.node_position[sheet.grippers[0].nodes, :2]
    assert len(place) > 4 and (np.linalg.norm(place - [0.0, 0.07], axis=1) <= 0.015).all()


def test_pressure_acts_on_a_face_after_its_delay(tmp_path):
    text = '\n[[pressure]]\nface = "top"\npressure = "0.8 bar"\ndelay = "5 ms"\nramp = "1 ms"\n'
    (pressure,) = setup_with(tmp_path, text).sheet.pressures
    assert pressure.at(np.array([0.005, 0.006, 0.1])).tolist() == [0.0, 8.0e4, 8.0e4]


def test_a_lay_up_becomes_plies_in_contact(tmp_path):
    text = "\n[interface]\nfriction = 0.3\n"
    setup = setup_with(tmp_path, text, ('name = "ply"\n', 'name = "ply"\nlayup = "[0/45]s"\n'))
    assert [sheet.name for sheet in setup.sheets] == ["ply_1", "ply_2", "ply_3", "ply_4"]
    height = [sheet.blank.node_position[0, 2] for sheet in setup.sheets]
    assert np.allclose(height, 0.0012 * (np.arange(4) + 0.5), atol=1e-8)
    warp = [np.degrees(np.arctan2(*s.blank.warp_direction[0, 1::-1])) for s in setup.sheets]
    assert np.allclose(warp, [0, 45, 45, 0])
    assert [interface.name for interface in setup.interfaces] == [
        "ply_1 / ply_2", "ply_2 / ply_3", "ply_3 / ply_4"
    ]  # fmt: skip
    assert all(interface.friction.coefficient == 0.3 for interface in setup.interfaces)
    ring = setup.tools[2].shape.display_triangles()[0][:, 2]
    assert np.allclose(ring, 4 * 0.0012, atol=1e-9)


def test_a_stroke_may_stop_at_a_force(tmp_path):
    setup = setup_with(tmp_path, "", ('stroke = "close"', 'stroke = "close"\nlargest_force = "3 kN"'))
    assert setup.tools[1].motion.largest_force == 3000.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (SPRING.replace("corners = true\n", ""), "edge, corners or points: one of them is needed, none is given"),
        (SPRING.replace("true", 'true\nedge = "+x"'), "one of them is needed, edge and corners are given"),
        (SPRING.replace("corners = true", 'edge = "+z"'), "edge: +x, -x, +y or -y is needed"),
        (SPRING.replace("0.5 N/mm", "0.5 N"), "stiffness = '0.5 N': 'N' is no unit of it, write '2 N/mm'"),
        (SPRING.replace("2 N", "20 N"), "a pretension of 20 N slips at a largest_force of 10 N"),
        (SPRING + 'ply = "plie"\n', "line 39, [[spring]] corner: ply = 'plie': there is none; there are ply"),
        (SPRING + 'stroke = "5 mm"\n', "stroke = '5 mm': unknown name"),
        (SPRING.replace("corners = true", 'points = [["1 m", 0]]'), "the ply has no node at (1000, 0) mm"),
        (SPRING.replace("corners = true", "points = [[0, 0]]"), "direction: is required at the middle of the ply"),
        (SPRING.replace("spring", "gripper") + 'stroke = "5 mm"\n', "speed: is required with a stroke"),
        ("\n[[pressure]]\npressure = 5\n", "line 32, [[pressure]]: face: is required"),
        ('\n[[pressure]]\nface = "up"\npressure = 5\n', "face = 'up': one of 'top' or 'bottom' is needed"),
        ('\n[[pressure]]\nface = "top"\npressure = "5 N"\n', "pressure = '5 N': 'N' is no unit of it, write '20 kPa'"),
        ("\n[interface]\nfriction = 0.2\n", "[interface]: has no effect with a single ply"),
    ],
)  # fmt: skip
def test_broken_ones_are_refused(tmp_path, text, message):
    with pytest.raises(InputError) as error:
        setup_with(tmp_path, text)
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("layup", "message"),
    [
        ('layup = "[0/90"', "layup|lay-up '[0/90'"),
        ('layup = "0/90"\nangle = 0', "angle and layup: one of them is needed, both are given"),
    ],
)
def test_broken_lay_ups_are_refused(tmp_path, layup, message):
    with pytest.raises(InputError) as error:
        setup_with(tmp_path, "", ('name = "ply"\n', f'name = "ply"\n{layup}\n'))
    assert any(part in str(error.value) for part in message.split("|"))


def test_several_plies_need_their_names(tmp_path):
    second = '\n[[ply]]\nname = "top"\nfabric = "glass-polypropylene"\ndisc = "100 mm"\nmesh_size = "10 mm"\n'
    setup = setup_with(tmp_path, second)
    assert [sheet.name for sheet in setup.sheets] == ["ply", "top"]
    with pytest.raises(InputError, match="ply: is required, one of ply, top"):
        setup_with(tmp_path, second + SPRING)


def test_pressure_on_a_patch(tmp_path):
    patch = '[["0 mm", "-80 mm"], ["100 mm", "-80 mm"], ["100 mm", "80 mm"], ["0 mm", "80 mm"]]'
    text = f'\n[[pressure]]\nface = "top"\npressure = "1 kPa"\npatch = {patch}\n'
    sheet = setup_with(tmp_path, text).sheet
    (pressure,) = sheet.pressures
    middle = sheet.blank.material_coordinates[sheet.blank.quads].mean(axis=1)
    assert np.array_equal(pressure.elements, np.flatnonzero(middle[:, 0] > 0.0))


@pytest.mark.parametrize(
    ("patch", "message"),
    [
        ('[["0 mm", "0 mm"], ["1 mm", "0 mm"], ["0 mm", "1 mm"]]', "patch: no element of the ply has its middle in it"),
        ('[["0 mm", "0 mm"], ["1 mm", "0 mm"]]', "(k, 2) finite coordinates, k > 2, are needed"),
        ("[[0, 0], [0.05, 0.05], [0.05, 0], [0, 0.05]]", "sides 0 and 2 of the outline cross"),
    ],
)
def test_a_broken_patch_is_refused(tmp_path, patch, message):
    text = f'\n[[pressure]]\nface = "top"\npressure = "1 kPa"\npatch = {patch}\n'
    with pytest.raises(InputError) as error:
        setup_with(tmp_path, text)
    assert message in str(error.value) and "[[pressure]]" in str(error.value)
