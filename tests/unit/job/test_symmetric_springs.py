"""Springs of a job whose plies are cut at planes of symmetry: those of the whole ply, each at its share."""

import numpy as np
import pytest

from tests.support.jobs import changed
from weavesim import InputError
from weavesim.job.build import setup_of
from weavesim.job.loads import corners_of
from weavesim.job.read import read_job

QUARTER = """\
[[ply]]
fabric = "glass-polypropylene"
rectangle = ["100 mm", "80 mm"]
centre = ["50 mm", "40 mm"]
mesh_size = "20 mm"
height = 0

[process]
symmetry = ["x", "y"]
duration = "1 ms"

[[spring]]
name = "s"
stiffness = "0.5 N/mm"
pretension = "2 N"
largest_force = "10 N"
"""


def grippers_of(folder, place, *changes):
    (folder / "job.toml").write_text(changed(QUARTER + place, *changes), encoding="utf-8")
    sheet = setup_of(read_job(folder / "job.toml")).sheet
    return sheet, sheet.grippers


def test_a_quarter_has_one_of_the_four_corners(tmp_path):
    sheet, (gripper,) = grippers_of(tmp_path, "corners = true\n")
    assert np.allclose(sheet.blank.node_position[gripper.nodes, :2], [[0.1, 0.08]])
    assert np.allclose(gripper.direction, np.array([0.1, 0.08, 0.0]) / np.hypot(0.1, 0.08))  # from the whole's middle
    assert (gripper.stiffness, gripper.pretension, gripper.largest_force) == (500.0, 2.0, 10.0)


@pytest.mark.parametrize(
    ("place", "planes", "share"),
    [('edge = "+x"', '"x", "y"', 0.5), ('edge = "+x"', '"y"', 0.5), ('edge = "+x"', '"x"', 1.0),
     ('edge = "+y"', '"x"', 0.5), ('points = [["100 mm", 0]]', '"x", "y"', 0.5),
     ('points = [["100 mm", "40 mm"]]', '"x", "y"', 1.0),
     ('points = [[0, 0]]\ndirection = [0, 0, 1]', '"x", "y"', 0.25),
     ('points = [["100 mm", 0]]\nradius = "25 mm"', '"x", "y"', 0.5)],
)  # fmt: skip
def test_a_plane_that_cuts_a_place_leaves_half_of_its_force(tmp_path, place, planes, share):
    _, (gripper,) = grippers_of(tmp_path, place + "\n", ('"x", "y"', planes))
    assert (gripper.stiffness, gripper.pretension, gripper.largest_force) == (500.0 * share, 2.0 * share, 10.0 * share)


def test_at_a_plane_outwards_is_within_it(tmp_path):
    _, (gripper,) = grippers_of(tmp_path, 'points = [["100 mm", 0]]\n')
    assert gripper.direction == (1.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ('edge = "-x"', "edge = '-x': there the plane of symmetry x = 0 cuts the ply, which has no edge"),
        ('edge = "+y"\ndirection = [1, 1, 0]', "the plane of symmetry x = 0 cuts this place"),
        ('points = [["10 mm", "80 mm"]]\nradius = "25 mm"', "reaches the plane of symmetry x = 0"),
        ("points = [[0, 0]]", "direction: is required at the middle of the ply"),
    ],
)
def test_places_that_are_none_of_the_whole_ply_are_refused(tmp_path, place, message):
    with pytest.raises(InputError) as error:
        grippers_of(tmp_path, place + "\n")
    assert message in str(error.value)


def test_a_corner_at_a_plane_is_one_where_the_whole_outline_turns():
    roof = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.05], [0.0, 0.1]])  # half of a house with a ridge at x = 0
    assert np.allclose(corners_of(roof, ("x",), 1e-9), roof[1:])
    diamond = np.array([[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]])
    assert np.allclose(corners_of(diamond, ("x", "y"), 1e-9), diamond[1:])
    assert len(corners_of(diamond)) == 3
