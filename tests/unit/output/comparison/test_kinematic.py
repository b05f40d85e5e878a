"""The kinematic drape beside a formed sheet: a sheet that is itself a net differs nowhere."""

import csv
import dataclasses
import json

import meshio
import numpy as np
import pytest
from PIL import Image

from tests.support.paths import ROOT
from tests.support.runs import one_sheet_setup
from tests.support.sheet import plain_fabric
from tests.support.stored_runs import THICKNESS, stored_run, stored_sheet
from tests.support.summary_keys import keys_without_unit
from weavesim.errors import InputError
from weavesim.measures.kinematic.net import CLOSED, NO_SURFACE, lay_net
from weavesim.output.comparison.kinematic import beside_run, of_flat_blank, surface_of, write_kinematic
from weavesim.output.export.nearest import nearest
from weavesim.sheet.blank import Blank
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Plane, Sphere
from weavesim.tools.tool import Tool

SIDE, RADIUS = 0.005, 0.1
BALL = Tool("ball", Sphere(origin=(0.0, 0.0, -RADIUS), radius=RADIUS))
FLOOR = Tool("floor", Plane(origin=(0.0, 0.0, -0.5)))


@pytest.fixture(scope="module")
def run():
    """A sheet of elements as large as the cells of the net that it was formed by, on a ball that moved up by 10 mm."""
    blank = Blank.rectangle((-0.06, -0.05), (0.06, 0.05), SIDE)
    net = lay_net(
        surface_of(BALL, 0.01), np.array([0.0, 0.0, 0.01]), np.array([1.0, 0.0, 0.0]), SIDE, ((-12, 12), (-10, 10)),
        height=0.5 * THICKNESS,
    )  # fmt: skip
    place = np.rint(blank.material_coordinates / SIDE).astype(int) + [12, 10]
    count = blank.element_count
    sheet = stored_sheet(
        blank, net.position[tuple(place.T)], warp_stretch=np.ones(count), weft_stretch=np.ones(count),
        warp_force=np.zeros(count), weft_force=np.zeros(count),
    )  # fmt: skip
    made = dataclasses.replace(
        stored_run(dataclasses.replace(sheet, tools=(0, 1))), tool_displacement=np.array([0.01, 0.0])
    )
    made.__dict__["setup"] = one_sheet_setup(
        name="x", blank=blank, fabric=plain_fabric(), duration=1.0, tools=(BALL, FLOOR)
    )
    return made


def test_a_net_beside_itself_differs_nowhere(run):
    drape = beside_run(run, run.sheets[0])
    assert drape.tool == "ball" and drape.seed == (0.0, 0.0)
    assert np.isfinite(drape.angle_deg).all() and drape.touching.all()
    assert np.abs(drape.difference_deg).max() < 1e-3
    assert drape.angle_deg.max() > 15.0
    numbers = drape.numbers()
    assert not keys_without_unit(numbers)
    assert numbers["covered_share"] == numbers["touching_share"] == 1.0
    assert numbers["largest_difference_deg"] < 1e-3


def test_files_tell_the_same(run, tmp_path):
    drape = beside_run(run, run.sheets[0], side=0.01)
    files = {file.suffix: file for file in write_kinematic(tmp_path, drape, run.run_id)}
    assert json.loads(files[".json"].read_text())["largest_net_angle_deg"] == pytest.approx(drape.angle_deg.max())
    mesh = meshio.read(files[".vtu"])
    assert len(mesh.cells_dict["quad"]) == np.isfinite(drape.net.shear_angle).sum()
    assert np.linalg.norm(mesh.points - [0.0, 0.0, 0.01 - RADIUS], axis=1) == pytest.approx(RADIUS + 0.5 * THICKNESS)
    with open(files[".csv"], newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == run.sheets[0].blank.element_count
    assert float(rows[3]["formed_angle_deg"]) - float(rows[3]["net_angle_deg"]) == pytest.approx(
        float(rows[3]["difference_deg"]), abs=1e-6
    )
    assert Image.open(files[".png"]).size[0] > 1000


def test_without_a_run_the_seed_goes_down_to_the_tool(tmp_path):
    blank = Blank.rectangle((0.0, 0.0), (0.06, 0.05), SIDE, height=0.02)
    drape = of_flat_blank(blank, BALL, THICKNESS, seed=(0.0, 0.0))
    assert drape.sheet is None and drape.numbers()["covered_share"] == 1.0
    middle = drape.net.position[-drape.net.first[0], -drape.net.first[1]]
    assert middle == pytest.approx([0.0, 0.0, 0.5 * THICKNESS], abs=1e-6)
    assert {file.suffix for file in write_kinematic(tmp_path, drape)} == {".json", ".vtu", ".png"}


def test_what_cannot_be_laid_is_told(run):
    sheet = run.sheets[0]
    with pytest.raises(InputError, match="tool 'die': choose from ball, floor"):
        beside_run(run, sheet, tool="die")
    with pytest.raises(InputError, match="lies outside the blank"):
        beside_run(run, sheet, seed=(1.0, 0.0))
    with pytest.raises(InputError, match="a positive length is needed"):
        beside_run(run, sheet, side=-1.0)
    with pytest.raises(InputError, match="has no tool"):
        beside_run(run, dataclasses.replace(sheet, tools=()))
    free = dataclasses.replace(run, tool_acts=np.zeros(len(run.tools), dtype=bool))
    free.__dict__["setup"] = run.setup
    with pytest.raises(InputError, match="has released it"):
        beside_run(free, sheet)
    beside = BALL.model_copy(update={"axis": (1.0, 0.0, 0.0)})
    with pytest.raises(InputError, match="is not met along its axis"):
        of_flat_blank(Blank.rectangle((-0.02, -0.02), (0.02, 0.02), SIDE, height=0.3), beside, THICKNESS)


@pytest.fixture(scope="module")
def tray():
    """The die of the tutorial, and its triangles [m]."""
    path = ROOT / "docs" / "notebooks" / "tray.stl"
    die = MeshShape.from_file(path, unit_scale=1e-3)
    vertices, faces = die.local_triangles()
    return Tool("die", die), np.asarray(vertices)[np.asarray(faces)]


@pytest.mark.parametrize("side", [0.01, 0.005, 0.0025])
def test_the_net_covers_the_tray_of_the_tutorial(tray, side):
    """Bottom, fillets, walls, corners and rim, with triangles of 0.3 to 100 mm."""
    die, triangles = tray
    blank = Blank.rectangle((-0.115, -0.1), (0.115, 0.1), 0.005, height=0.002)
    drape = of_flat_blank(blank, die, 1.2e-3, side=side)
    assert drape.numbers()["covered_share"] == 1.0 and drape.ends == ()
    position = drape.net.position
    for axis in (0, 1):
        assert np.linalg.norm(np.diff(position, axis=axis), axis=2) == pytest.approx(side, rel=1e-6)
    nodes = position.reshape(-1, 3)
    # from the rim down to the bottom, and corners in which the yarns shear
    assert np.ptp(nodes[:, 2]) == pytest.approx(0.018, abs=1e-4)
    assert 15.0 < drape.angle_deg.max() < 20.0
    # an independent search through the triangles, in their own scale
    some = nodes[:: max(1, len(nodes) // 60)]
    foot, _ = nearest(1e3 * triangles, 1e3 * some)
    assert np.linalg.norm(1e-3 * foot - some, axis=1) == pytest.approx(0.6e-3, abs=2e-7)


def test_a_net_ends_with_the_tool_and_says_where(tray):
    die, _ = tray
    blank = Blank.rectangle((-0.15, -0.1), (0.15, 0.1), 0.005, height=0.0)
    drape = of_flat_blank(blank, die, 1.2e-3, side=0.005)
    assert 0.8 < drape.covered_share < 1.0
    (end,) = drape.ends
    assert end.reason == NO_SURFACE
    # the section along x is 10.2 mm longer than the opening of 170 mm, on a surface of 260 mm
    assert abs(end.nearest[0]) == pytest.approx(0.5 * (0.26 + 0.0102), abs=0.006)
    reason = drape.numbers()["ends"][0]
    assert reason["reason"] == "there is no more surface" and reason["nearest_mm"][0] == pytest.approx(
        1e3 * end.nearest[0]
    )
    assert "there is no more surface, first at x = " in end.text()


def test_a_net_that_closes_says_so():
    blank = Blank.rectangle((-0.15, -0.15), (0.15, 0.15), 0.01, height=0.02)
    drape = of_flat_blank(blank, BALL, THICKNESS)
    assert 0.3 < drape.covered_share < 1.0
    assert [end.reason for end in drape.ends] == [CLOSED] and "cross below 20 degrees" in drape.ends[0].text()


@pytest.mark.parametrize("side", [1e-9, 1e-320, float("inf"), float("nan")])
def test_a_side_of_no_use_is_refused_before_it_takes_memory(side):
    blank = Blank.rectangle((-0.1, -0.1), (0.1, 0.1), 0.01, height=0.02)
    with pytest.raises(InputError, match="crossings, more than 1,000,000|a positive length is needed"):
        of_flat_blank(blank, BALL, THICKNESS, side=side)
