"""Guards of tools that come through the sheet between its nodes (field case 17), before and while it runs."""

import numpy as np
import pytest

from tests.support.runs import small_run
from weavesim.errors import InputError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.process.strokes import Stroke
from weavesim.process.supports import Support
from weavesim.run.guards import Level
from weavesim.sheet.blank import Blank
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Capsule, Plane, Sphere, rotation_matrix
from weavesim.tools.tool import Tool

THICKNESS = glass_polypropylene().thickness


def box(width: float, length: float, height: float = 0.03) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of a sharp box on z = 0, seen from outside."""
    x, y = 0.5 * width, 0.5 * length
    corners = np.array([[i * x, j * y, k * height] for k in (0, 1) for j in (-1, 1) for i in (-1, 1)])
    faces = [
        [0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 4, 6], [0, 6, 2],
        [1, 3, 7], [1, 7, 5],
    ]  # fmt: skip
    return corners, np.array(faces)


def sharp_box(width: float, length: float, **placed) -> MeshShape:
    return MeshShape.from_triangles(*box(width, length), spacing=2.5e-4, reach=1.5e-3, **placed)


def poked(shape, size: float, at: tuple[float, float], travel: float = 0.004):
    """A sheet held at its edges, and a tool that goes down from its face."""
    blank = Blank.rectangle((0.0, 0.0), (0.06, 0.06), size)
    edge = Support("edge", np.unique(blank.boundary_loop()))
    placed = shape.placed((*at, 0.5 * THICKNESS))
    tool = Tool("pin", placed, Stroke((0.0, 5e-3), (0.0, travel)), axis=(0.0, 0.0, -1.0))
    return small_run(blank=blank, supports=(edge,), tools=[tool], duration=5e-3, frame_count=1, accept_unusual=True)


def spoken(run) -> dict:
    return {doubt.guard: doubt for doubt in run.doubts()}


# in the middle of an element, or of an edge, 10 or 5 mm long
PASSING = {
    "a pin of 3 mm": (sharp_box(0.003, 0.003), 0.01, (0.025, 0.035)),
    "a box of 8 mm": (sharp_box(0.008, 0.008), 0.01, (0.035, 0.025)),
    "a blade of 1 x 50 mm": (sharp_box(0.001, 0.05), 0.005, (0.0325, 0.03)),
    "a needle with a round tip": (Sphere(0.001, origin=(0.0, 0.0, 0.001)), 0.005, (0.0325, 0.0275)),
    "a thin bar": (
        Capsule(0.0008, 0.02, origin=(0.0, 0.0, 0.0008)), 0.005, (0.03, 0.0325),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PASSING)
def test_a_tool_that_passes_between_nodes_is_told_before_and_seen_after(name):
    shape, size, at = PASSING[name]
    run = poked(shape, size, at)
    before = {doubt.guard for doubt in run.doubts()}
    assert "narrow_tool" in before and any("elements are" in warning for warning in run.warnings)
    run.run()
    found = spoken(run)
    assert {"between_nodes", "never_touched"} <= set(found)
    assert found["between_nodes"].level == found["never_touched"].level == Level.DO_NOT_USE
    assert np.abs(np.array(found["between_nodes"].place) - at).max() <= max(size, 0.025)
    assert run.verdict == "do not use"


def cone(radius: float, height: float, count: int = 32) -> MeshShape:
    """A cone that stands on its tip at z = 0: wide, and without a sharp edge that faces the sheet."""
    turn = 2.0 * np.pi * np.arange(count) / count
    rim = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(count, height)])
    k, following = np.arange(count), np.roll(np.arange(count), -1)
    tip, top = np.full(count, count), np.full(count, count + 1)
    faces = np.concatenate([np.column_stack([tip, following, k]), np.column_stack([top, k, following])])
    return MeshShape.from_triangles(np.vstack([rim, [[0, 0, 0], [0, 0, height]]]), faces, spacing=2.5e-4, reach=1.5e-3)


@pytest.mark.parametrize(
    ("radius", "travel", "useless"), [(0.012, 0.008, True), (0.009, 0.006, True), (0.03, 1e-3, False)]
)
def test_a_wide_tool_with_a_tip_that_comes_through_makes_a_result_useless(radius, travel, useless):
    run = poked(cone(radius, 0.03), 0.005, (0.0325, 0.0325), travel)
    assert "narrow_tool" not in spoken(run)
    run.run()
    doubt = spoken(run)["between_nodes"]
    assert (doubt.level == Level.DO_NOT_USE) == useless and "stood out by" in doubt.text


def test_a_tool_between_nodes_is_not_out_of_reach():
    run = poked(*PASSING["a blade of 1 x 50 mm"])
    assert "tool_reach" not in spoken(run)


@pytest.mark.parametrize("frame_count", [1, 9])
def test_it_is_seen_with_any_number_of_frames(frame_count):
    shape, size, at = PASSING["a pin of 3 mm"]
    run = poked(shape, size, at)
    run.run()
    assert spoken(run)["between_nodes"].value == pytest.approx(0.0015, abs=2e-4)


def test_a_wide_round_tool_is_silent():
    run = poked(Sphere(0.03, origin=(0.0, 0.0, 0.03)), 0.005, (0.03, 0.03), 0.002)
    assert spoken(run) == {}
    run.run()
    assert not {"between_nodes", "narrow_tool", "never_touched", "start_overlap"} & set(spoken(run))


@pytest.mark.parametrize(
    "shape",
    [
        Sphere(0.001, origin=(0.0, 0.0, -0.0005)),
        sharp_box(0.003, 0.003, origin=(0.0, 0.0, -0.001)),
        Plane(rotation=rotation_matrix((1.0, 0.0, 0.0), np.pi), origin=(0.0, 0.0, -0.5 * THICKNESS)),
    ],
    ids=["ball", "pin", "plane on the mid-surface"],
)
def test_a_tool_in_the_sheet_from_the_start_is_refused_wherever_the_nodes_are(shape):
    with pytest.raises(InputError, match="pin overlaps the blank by .* mm before the run starts"):
        poked(shape, 0.01, (0.025, 0.025))
