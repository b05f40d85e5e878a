"""Gap to the tools and height of wrinkles in frames: known surfaces, and where nothing is known."""

import numpy as np
import pytest
import trimesh

from tests.support.runs import one_sheet_run, small_run
from weavesim.engine.sheet_model import SheetModel
from weavesim.fabric.presets import glass_polypropylene
from weavesim.measures.defects.judgement import Judgement, Limits
from weavesim.measures.findings import FormedSheet
from weavesim.sheet.blank import Blank
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Plane, Sphere
from weavesim.tools.tool import Tool

FABRIC = glass_polypropylene()
THICKNESS = FABRIC.thickness
BLANK = Blank.rectangle((-0.1, -0.1), (0.1, 0.1), 0.005)
X, Y = BLANK.material_coordinates.T
MIDDLE = np.linalg.norm(BLANK.material_coordinates[BLANK.quads].mean(axis=1), axis=1) < 0.05


def ledger_with(*shapes):
    """Ledger of a large flat sheet with tools of these shapes."""
    tools = [Tool(f"tool {k}", shape) for k, shape in enumerate(shapes)]
    simulation = one_sheet_run(name="large", blank=BLANK, fabric=FABRIC, tools=tools, duration=1.0, threads=1)
    return simulation.ledger.sheets[0]


def fields_of(ledger, z, warp=0.999, weft=1.01, thickness=THICKNESS):
    """Fields of the sheet with its nodes at the heights ``z``, and stretches of its yarns."""
    position = np.column_stack([X, Y, np.broadcast_to(z, X.shape)])
    distance = ledger._contact_gaps(position)
    of_all = {"thickness": thickness, "warp_stretch": warp, "weft_stretch": weft}
    given = {name: np.full(len(BLANK.quads), value) for name, value in of_all.items()}
    return ledger._surface_fields(position, given, distance)


@pytest.mark.parametrize("wavelength", [0.025, 0.04])
def test_a_sine_has_its_height_with_and_without_tools(wavelength):
    """Of 1 mm amplitude: 2 mm, far from a tool or over one."""
    sine = 0.001 * np.sin(2.0 * np.pi * X / wavelength)
    alone = fields_of(ledger_with(), sine)
    assert "tool_gap" not in alone and alone["wrinkle_height"][MIDDLE] == pytest.approx(2e-3, rel=0.15)
    plane = Plane(origin=(0.0, 0.0, -0.01))
    over = fields_of(ledger_with(plane), sine)
    assert over["wrinkle_height"][MIDDLE] == pytest.approx(2e-3, rel=0.15)
    # crests along the warp: yarns that are shortened along the crest do not make it a wrinkle
    assert fields_of(ledger_with(), sine, warp=1.0, weft=0.999)["wrinkle_height"][MIDDLE].max() < 2e-4
    assert over["tool_gap"].mean() == pytest.approx(0.01 - 0.5 * THICKNESS, rel=1e-3)


@pytest.mark.parametrize(("contact_thickness", "gap"), [("initial", 0.0), ("current", -0.25 * THICKNESS)])
def test_a_sheet_that_thickens_enters_a_tool_only_if_contact_follows_it(contact_thickness, gap, monkeypatch):
    """A sheet that lies on a plane at half its initial thickness, where contact puts it, and is half as thick again."""
    ledger = ledger_with(Plane(origin=(0.0, 0.0, -0.5 * THICKNESS)))
    # no kernel is asked: nothing steps
    monkeypatch.setattr(SheetModel, "follows_thickness", contact_thickness == "current")
    found = fields_of(ledger, 0.0, thickness=1.5 * THICKNESS)["tool_gap"]
    assert found == pytest.approx(np.full(len(BLANK.quads), gap), abs=1e-8)
    # the verdict says the same
    values = dict.fromkeys(("warp_stretch", "weft_stretch"), np.ones(len(BLANK.quads)))
    values |= dict.fromkeys(("shear_angle", "warp_force", "weft_force"), np.zeros(len(BLANK.quads)))
    values["thickness"] = np.full(len(BLANK.quads), 1.5 * THICKNESS)
    formed = FormedSheet(
        BLANK, BLANK.node_position, values, THICKNESS, follows_thickness=contact_thickness == "current"
    )
    judged = Judgement(formed, Limits(), lambda points: points[:, 2] + 0.5 * THICKNESS)
    assert judged.fields["gap"] == pytest.approx(found, abs=1e-8)


def test_neither_the_shape_of_a_tool_nor_a_change_of_the_nearest_one_is_a_wrinkle():
    ball = Sphere(0.2, origin=(0.0, 0.0, -0.201))
    on_it = np.sqrt(0.201**2 - X**2 - Y**2) - 0.201
    shape = fields_of(ledger_with(), on_it)["wrinkle_height"][MIDDLE]
    assert shape.max() > 2e-5
    assert fields_of(ledger_with(ball), on_it)["wrinkle_height"][MIDDLE].max() < 1e-6
    # a flat sheet midway between two balls, the distance to which has a crease at x = 0
    left, right = (Sphere(0.02, origin=(side * 0.03, 0.0, 0.03)) for side in (-1.0, 1.0))
    assert fields_of(ledger_with(left, right), 0.0)["wrinkle_height"].max() < 1e-9


def test_the_gap_of_a_frame_is_that_of_the_verdict():
    ball = Tool("ball", Sphere(0.05, origin=(0.01, 0.01, -0.055)))
    simulation = small_run(tools=[ball], precision="float64")
    frame, sheet = simulation.frame.sheet, simulation.info.sheet
    formed = FormedSheet(sheet.blank, frame.position, frame.fields, THICKNESS, sheet.symmetry)
    judged = Judgement(formed, Limits(), lambda points: ball.distance(points)[0])
    assert frame.fields["tool_gap"] == pytest.approx(judged.fields["gap"], abs=1e-12)
    assert frame.fields["tool_gap"].min() > 0.004


def test_a_gap_beyond_the_reach_of_a_sampled_mesh_is_not_a_number():
    block = trimesh.creation.box((0.06, 0.06, 0.01))
    mesh = MeshShape.from_triangles(block.vertices, block.faces, origin=(0.0, 0.0, -0.006), spacing=0.001, reach=0.004)
    ledger = ledger_with(mesh)
    near = fields_of(ledger, 0.0)["tool_gap"]
    over = np.abs(BLANK.material_coordinates[BLANK.quads].mean(axis=1)).max(axis=1) < 0.025
    assert near[over] == pytest.approx(0.001 - 0.5 * THICKNESS, abs=1e-5) and np.isnan(near[~over]).sum() > 100
    far = fields_of(ledger, 0.05 + 0.001 * np.sin(2.0 * np.pi * X / 0.03))
    assert np.isnan(far["tool_gap"]).all()
    # a wrinkle there is one all the same
    assert far["wrinkle_height"][MIDDLE] == pytest.approx(2e-3, rel=0.15)
