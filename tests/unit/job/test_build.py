"""Jobs become the set-ups that scripts make, to the bit; tools made from others lie where they should."""

import numpy as np
import pytest

from scenes.double_dome import DoubleDomeParameters, double_dome
from tests.support.jobs import TRAY, write_stl, write_tray
from tests.support.paths import ROOT
from weavesim import InputError
from weavesim.job.build import Builder, setup_of
from weavesim.job.read import read_job


def test_the_double_dome_as_a_job_is_the_scene_to_the_bit():
    job = setup_of(read_job(ROOT / "tests" / "data" / "jobs" / "double_dome.toml"))
    assert job == double_dome(DoubleDomeParameters())


@pytest.fixture(scope="module")
def tray(tmp_path_factory):
    return Builder(read_job(write_tray(tmp_path_factory.mktemp("tray"))))


def test_a_ply_lies_on_the_die_and_the_ring_on_the_ply(tray):
    thickness = tray.fabrics[0].thickness
    assert np.isclose(tray.heights[0], 0.5 * thickness, atol=1e-9)
    assert tray.facing == ("up", "down", "down")
    vertices, _ = tray.shapes[2].display_triangles()
    assert np.allclose(vertices[:, 2], thickness, atol=1e-9)


def test_the_punch_is_closed_at_the_gap_and_starts_above_the_ply(tray):
    setup = tray.setup()
    punch = next(tool for tool in setup.tools if tool.name == "punch")
    assert np.isclose(punch.shape.display_triangles()[0][:, 2].min(), 0.0012 + 0.001, atol=1e-6)
    vertices, faces = tray.shapes[1].display_triangles()
    points = np.concatenate([vertices, vertices[faces].mean(axis=1)])
    distance, _ = setup.tools[0].distance(points)
    # between the corners of its triangles a curved surface is nearer, or further
    assert np.isclose(np.median(distance), 0.0012, rtol=0.01)
    assert distance.min() > 0.0012 * 0.95 and distance.max() < 0.0012 * 1.05
    assert setup.leading_tool == 1


def test_the_stroke_closes_the_tools(tray):
    punch = tray.setup().tools[1]
    lowest = punch.shape.display_triangles()[0][:, 2].min() - punch.motion.displacements[-1]
    assert np.isclose(lowest, -0.025 + 0.0012, atol=1e-6)


@pytest.mark.parametrize(
    ("up", "turn"),
    [("+z", (0, 1, 2)), ("+y", (0, 2, 1)), ("+x", (2, 1, 0)), ("-z", (0, 1, 2)), ("-y", (0, 2, 1)), ("-x", (2, 1, 0))],
)
def test_a_file_may_have_another_direction_up(tmp_path, up, turn):
    from tests.support.jobs import tray_surface, write_stl

    write_tray(tmp_path, TRAY.replace('faces = "up"', f'faces = "up"\nup = "{up}"'))
    vertices, faces = tray_surface()
    axis = "xyz".index(up[1])
    signed = vertices[:, turn].copy()
    if axis < 2:  # exchanging two axes mirrors: another is turned round
        signed[:, 1 - axis] *= -1.0
    if up[0] == "-":
        signed[:, axis] *= -1.0
        signed[:, (axis + 1) % 3] *= -1.0
    write_stl(tmp_path / "die.stl", signed, faces)
    setup = setup_of(read_job(tmp_path / "tray.toml"))
    low = setup.tools[0].shape.display_triangles()[0]
    assert np.allclose([low[:, 2].min(), low[:, 2].max()], [-0.025, 0.0], atol=1e-6)


def test_a_hollow_that_is_too_sharp_for_the_gap_is_refused_with_its_place(tmp_path):
    path = write_tray(tmp_path, TRAY.replace('gap = "1.2 mm"', 'gap = "12 mm"'))
    with pytest.raises(InputError, match=r"line 17, \[\[tool\]\] punch: tool die: its offset by 12 mm crosses itself"):
        setup_of(read_job(path))


def test_a_flat_die_has_no_opening_for_a_punch_beside_a_ring(tmp_path):
    path = write_tray(tmp_path)
    corners = np.array([[-130.0, -110, 0], [130, -110, 0], [130, 110, 0], [-130, 110, 0]])
    write_stl(tmp_path / "die.stl", corners, np.array([[0, 1, 2], [0, 2, 3]]))
    with pytest.raises(InputError, match="punch: tool die has no opening: all of it is the flat rim"):
        setup_of(read_job(path))


def test_settings_override_the_file(tmp_path):
    path = write_tray(tmp_path)
    setup = setup_of(read_job(path, ["tools.ring.force=0.5 kN", "process.hold=5ms", "ply.angle=45", "name=other"]))
    assert setup.tools[2].motion.forces[-1] == 500.0
    assert setup.name == "other"
    assert np.isclose(setup.duration - setup.tools[1].motion.duration, 0.005)
    assert np.allclose(setup.sheet.blank.warp_direction[0, :2], np.sqrt(0.5))


def test_an_octagon_at_45_degrees_has_elements_along_its_yarns(tmp_path):
    points = [[100 * np.cos(a), 100 * np.sin(a)] for a in np.pi / 4 * (np.arange(8) + 0.5)]
    corners = ", ".join(f'["{x:.6f} mm", "{y:.6f} mm"]' for x, y in points)
    text = TRAY.replace('rectangle = ["200 mm", "160 mm"]', f'polygon = [{corners}]\nangle = "45 deg"')
    setup = setup_of(read_job(write_tray(tmp_path, text)))
    blank = setup.sheet.blank
    middle = int(np.argmin(np.linalg.norm(blank.element_centres()[:, :2], axis=1)))
    corner = blank.node_position[blank.quads[middle]]
    edge = (corner[1] - corner[0]) / np.linalg.norm(corner[1] - corner[0])
    assert np.isclose(max(abs(edge @ blank.warp_direction[0]), abs(edge @ blank.weft_direction[0])), 1.0)
    area = 0.5 * abs(sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(points, points[1:] + points[:1], strict=True)))
    diagonals = blank.node_position[blank.quads]
    found = 0.5 * np.linalg.norm(np.cross(diagonals[:, 2] - diagonals[:, 0], diagonals[:, 3] - diagonals[:, 1]), axis=1)
    assert np.isclose(found.sum() * 1e6, area, rtol=1e-6)
