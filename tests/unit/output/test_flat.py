"""Which part of a flat blank becomes the part: exact on a developed cylinder, and formed again on a dome."""

import dataclasses
import json
import time

import numpy as np
import pytest

from tests.support.jobs import write_stl
from tests.support.stored_runs import THICKNESS, stored_run, stored_sheet
from weavesim import InputError
from weavesim.job.blanks.outlines import read_drawing
from weavesim.output.comparison.kinematic import of_flat_blank
from weavesim.output.flat import pattern as patterns
from weavesim.output.flat.first_blank import pattern_of_net, with_margin
from weavesim.output.flat.part_edge import border_loops, opening_of, plan_area, read_part_edge
from weavesim.output.flat.pattern import FlatWish, flat_patterns, write_flat
from weavesim.output.flat.trimming import flat_pattern
from weavesim.sheet.blank import Blank
from weavesim.sheet.outline import Outline
from weavesim.sheet.symmetry import Symmetry
from weavesim.tools.mesh_tool import MeshShape
from weavesim.tools.shapes import Capsule, rotation_matrix
from weavesim.tools.tool import Tool

ezdxf = pytest.importorskip("ezdxf")

RADIUS = 0.1
# an ellipse on the developed cylinder, and a hole in it
HALF = np.array([0.07, 0.03])
HOLE = 0.01


def around(flat):
    """Flat points (k, 2) laid around a cylinder along y, without strain."""
    return np.column_stack([
        RADIUS * np.sin(flat[:, 0] / RADIUS), flat[:, 1], RADIUS * np.cos(flat[:, 0] / RADIUS)
    ])  # fmt: skip


def ellipse(half, count=90):
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return np.column_stack([half[0] * np.cos(angle), half[1] * np.sin(angle)])


def cylinder_run(size=0.005, symmetry=(), lower=(-0.1, -0.05), **given):
    lower = (0.0 if "x" in symmetry else lower[0], 0.0 if "y" in symmetry else lower[1])
    blank = Blank.rectangle(lower, (0.1, 0.05), size, yarn_angle=30.0)
    return stored_run(stored_sheet(blank, around(blank.material_coordinates), symmetry=Symmetry(symmetry), **given))


def edge_table(path, points, names=("x", "y", "z"), unit="mm"):
    rows = [",".join(f"{name} [{unit}]" for name in names)]
    rows += [",".join(f"{1e3 * value:.9g}" for value in point) for point in points]
    path.write_text("\n".join(rows) + "\n")
    return path


@pytest.fixture(autouse=True)
def weights(monkeypatch):
    """Stored runs of tests have no set-up."""
    fabric = type("Fabric", (), {"areal_density": 0.3})()
    monkeypatch.setattr(patterns.StoredRun, "fabric", lambda run, sheet: fabric)


@pytest.mark.parametrize("symmetry", [(), ("x",), ("x", "y")])
def test_a_developed_curve_comes_back_flat(tmp_path, symmetry):
    path = edge_table(tmp_path / "edge.csv", around(ellipse(HALF)))
    found = flat_patterns(cylinder_run(symmetry=symmetry), FlatWish(trim=tmp_path / "t.dxf", part_edge=path))
    pattern = found.plies[0]
    # sagitta of elements of 5 mm over a radius of 100 mm
    assert pattern.largest_distance < 0.05e-3
    assert np.allclose(np.sum((pattern.trim[0] / HALF) ** 2, axis=1), 1.0, atol=0.02)
    assert pattern.part_area == pytest.approx(np.pi * HALF.prod(), rel=3e-3)
    assert pattern.blank_area == pytest.approx(0.2 * 0.1)
    entry = found.numbers()["plies"][0]
    assert entry["waste_area_mm2"] + entry["part_area_mm2"] == pytest.approx(2e4)
    assert entry["waste_share"] == pytest.approx(1.0 - np.pi * HALF.prod() / 0.02, rel=3e-3)
    assert entry["part_mass_g"] == pytest.approx(300.0 * pattern.part_area)
    assert "waste" in found.lines()[0]


def test_the_drawings_are_outlines_of_a_job_with_marks_of_the_yarns(tmp_path):
    document = ezdxf.new(units=4)
    space = document.modelspace()
    for half in (HALF, np.array([HOLE, HOLE])):
        points = 1e3 * around(ellipse(half))
        space.add_polyline3d(points.tolist(), close=True)
    document.saveas(tmp_path / "edge.dxf")
    wish = FlatWish(flat=tmp_path / "flat.dxf", trim=tmp_path / "trim.dxf", part_edge=tmp_path / "edge.dxf")
    files = write_flat(flat_patterns(cylinder_run(), wish), wish)
    assert [file.name for file in files] == ["flat.dxf", "trim.dxf", "flat.json"]
    trimmed, flat = read_drawing(files[1], layer="sheet"), read_drawing(files[0], layer="sheet")
    assert abs(plan_area(flat.outline)) == pytest.approx(0.02, rel=1e-6) and not flat.holes
    assert abs(plan_area(trimmed.outline)) == pytest.approx(np.pi * HALF.prod(), rel=3e-3)
    assert abs(plan_area(trimmed.holes[0])) == pytest.approx(np.pi * HOLE**2, rel=0.02)
    assert json.loads(files[2].read_text())["waste_share"] == pytest.approx(
        1.0 - np.pi * (HALF.prod() - HOLE**2) / 0.02, rel=3e-3
    )
    drawing = ezdxf.readfile(files[0])
    assert {layer.dxf.name for layer in drawing.layers} >= {"sheet", "sheet_trim", "sheet_yarns", "sheet_text"}
    arrows = drawing.modelspace().query('LINE[layer=="sheet_yarns"]')
    warp = arrows[0].dxf.end - arrows[0].dxf.start
    assert np.degrees(np.arctan2(warp.y, warp.x)) == pytest.approx(30.0, abs=1e-3)
    texts = [entity.dxf.text for entity in drawing.modelspace().query("TEXT")]
    assert texts[:2] == ["warp", "weft"] and "become the part" in texts[2]


def test_an_edge_that_is_seen_from_above(tmp_path):
    plan = around(ellipse(HALF))[:, :2]
    path = edge_table(tmp_path / "edge.csv", plan, names=("x", "y"))
    pattern = flat_pattern(cylinder_run().sheets[0], read_part_edge(path))
    assert pattern.part_area == pytest.approx(np.pi * HALF.prod(), rel=5e-3)


def test_the_border_of_a_trimmed_surface_is_an_edge(tmp_path):
    half = np.array([0.06, 0.03])
    part = Blank.fitted(ellipse(half), 0.004)
    faces = np.concatenate([part.quads[:, [0, 1, 2]], part.quads[:, [0, 2, 3]]])
    path = write_stl(tmp_path / "part.stl", 1e3 * around(part.material_coordinates), faces)
    edge = read_part_edge(path, metres_per_unit=1e-3)
    pattern = flat_pattern(cylinder_run().sheets[0], edge)
    assert pattern.part_area == pytest.approx(np.pi * half.prod(), rel=5e-3)
    with pytest.raises(InputError, match="unit: is required with part.stl"):
        read_part_edge(path)


def test_the_opening_of_a_die_is_an_edge():
    from tests.support.jobs import tray_surface

    vertices, faces = tray_surface()
    shape = MeshShape.from_triangles(1e-3 * vertices, faces, name="die", side=(0.0, 0.0, 1.0))
    edge = opening_of(Tool("die", shape), 0.01)
    # half sides of 80 and 60 mm with corners of 30 mm
    assert np.ptp(edge.outline[:, :2], axis=0) == pytest.approx([0.16, 0.12], abs=1e-4)
    assert edge.outline[:, 2] == pytest.approx(0.01, abs=1e-6)
    with pytest.raises(InputError, match="no flat rim around an opening"):
        opening_of(Tool("punch", MeshShape.from_triangles(1e-3 * vertices[:200], faces[:100], name="p")), 0.0)


def test_slits_and_holes_of_the_blank_stay(tmp_path):
    from weavesim.sheet.fitted_mesh import fitted_mesh
    from weavesim.sheet.slits import cut_open

    corners = np.array([(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)])
    hole = np.array([0.05, 0.0]) + ellipse(np.array([0.015, 0.015]), 48)
    plan, quads = fitted_mesh(corners, 0.005, holes=(hole,), mesh_angle=0.0)
    plan, quads, _ = cut_open(plan, quads, [np.array([(-0.05, 0.0), (-0.02, 0.0)])], 0.005)
    blank = Blank.from_mesh(np.column_stack([plan, np.zeros(len(plan))]), quads, merge_nodes=0.0)
    sheet = stored_sheet(blank, around(blank.material_coordinates))
    whole = flat_pattern(sheet, None)
    assert len(whole.blank) == 2 and len(whole.slits) == 1
    assert np.ptp(whole.slits[0], axis=0) == pytest.approx([0.03, 0.0], abs=2e-3)
    assert whole.blank_area == pytest.approx(0.02 - np.pi * 2.25e-4, rel=2e-3)
    edge = read_part_edge(edge_table(tmp_path / "edge.csv", around(ellipse(HALF))))
    pattern = flat_pattern(sheet, edge)
    assert len(pattern.cut) == 2 and len(pattern.cut_slits) == 1
    assert pattern.part_area == pytest.approx(np.pi * (HALF.prod() - 2.25e-4), rel=5e-3)


def folded(flat):
    """A flat sheet with a fold of three layers about x = 0."""
    x = flat[:, 0]
    there = np.interp(x, [-0.1, -0.005, 0.005, 0.1], [-0.085, 0.01, 0.0, 0.095])
    return np.column_stack([there, flat[:, 1], np.interp(x, [-0.005, 0.005], [0.0, 0.004])])


@pytest.mark.parametrize(
    ("points", "names", "message"),
    [
        (around(ellipse(np.array([0.12, 0.03]))), "xyz", r"lies .* mm beyond the border of the formed sheet sheet"),
        (around(ellipse(HALF)) + [0.0, 0.0, 0.02], "xyz", r"lies .* mm away from the formed sheet sheet.*its unit"),
        (ellipse(np.array([0.2, 0.03])), "xy", "there is no formed sheet sheet under it"),
        (around(ellipse(HALF))[[0, 40, 20, 60]], "xyz", r"crosses itself|away from the formed sheet"),
        (around(ellipse(HALF))[:2], "xyz", "it has 2 points; a closed curve has three or more"),
    ],
)
def test_an_edge_that_does_not_lie_on_the_sheet_is_refused(tmp_path, points, names, message):
    path = edge_table(tmp_path / "edge.csv", points, names=tuple(names))
    with pytest.raises(InputError, match=message):
        flat_pattern(cylinder_run().sheets[0], read_part_edge(path))


def test_an_edge_over_a_fold_is_refused(tmp_path):
    blank = Blank.rectangle((-0.1, -0.05), (0.1, 0.05), 0.0025)
    sheet = stored_sheet(blank, folded(blank.material_coordinates))
    path = edge_table(tmp_path / "edge.csv", ellipse(np.array([0.06, 0.03])), names=("x", "y"))
    with pytest.raises(InputError, match=r"the sheet sheet lies over itself at .* and .* mm"):
        flat_pattern(sheet, read_part_edge(path))


def square(space):
    space.add_lwpolyline([(0, 0), (50, 0), (50, 50), (0, 50), (0, 3)])


def test_files_that_are_no_edges_are_refused(tmp_path):
    document = ezdxf.new(units=4)
    square(document.modelspace())
    document.saveas(tmp_path / "open.dxf")
    with pytest.raises(InputError, match=r"no line is closed; the nearest ends are 3 mm apart"):
        read_part_edge(tmp_path / "open.dxf")
    with pytest.raises(InputError, match="only a DXF drawing has layers"):
        read_part_edge(tmp_path / "edge.csv", layer="a")
    (tmp_path / "edge.csv").write_text("x,y\n1,2\n3,4\n5,1\n")
    with pytest.raises(InputError, match="does not say its unit"):
        read_part_edge(tmp_path / "edge.csv")
    box = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
    path = write_stl(tmp_path / "solid.stl", box, np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]))
    with pytest.raises(InputError, match="its surface is closed, so that it has no border"):
        read_part_edge(path, metres_per_unit=1e-3)
    assert border_loops(box, np.array([(0, 2, 1)]))[0].shape == (3, 3)


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        ({"trim": "t.dxf"}, "trim line: the edge of the part is needed"),
        ({"part_edge": "e.csv"}, "it has an effect only with a drawing"),
        ({"flat": "f.dxf", "part_edge": "e.csv", "opening": "die"}, "a file and a tool's opening are given"),
        ({"flat": "f.pdf"}, "a name that ends in .dxf is needed"),
        ({"flat": "out/run.dxf"}, "its numbers would be written to run.json, a file of a run"),
    ],
)
def test_what_does_not_fit_together_is_refused(wish, message):
    from pathlib import Path

    with pytest.raises(InputError, match=message):
        FlatWish(**{key: value if key == "opening" else Path(value) for key, value in wish.items()})


def test_a_column_that_occurs_twice_is_no_missing_one(tmp_path):
    path = tmp_path / "edge.csv"
    path.write_text("x [mm],y [mm],z [mm],z [mm]\n0,0,1,1\n10,0,1,1\n10,10,1,1\n")
    with pytest.raises(InputError, match="column z occurs twice"):
        read_part_edge(path)


def test_several_plies_have_each_their_own_numbers(tmp_path):
    run = cylinder_run()
    second = dataclasses.replace(run.sheets[0], name="upper: ply")
    run = stored_run(run.sheets[0], second)
    path = edge_table(tmp_path / "edge.csv", around(ellipse(HALF)))
    wish = FlatWish(trim=tmp_path / "trim.dxf", part_edge=path)
    found = flat_patterns(run, wish)
    write_flat(found, wish)
    assert len(found.lines()) == 2
    assert read_drawing(tmp_path / "trim.dxf", layer="upper_ ply").outline is not None


@pytest.mark.parametrize(("angle", "symmetry"), [(0.0, ()), (30.0, ()), (0.0, ("x", "y"))])
def test_a_first_blank_from_a_net_on_a_cylinder(tmp_path, angle, symmetry):
    lower = (0.0, 0.0) if symmetry else (-0.1, -0.05)
    blank = Blank.rectangle(lower, (0.1, 0.05), 0.005, yarn_angle=angle, height=RADIUS + 0.02)
    turned = rotation_matrix((0.0, 0.0, 1.0), 0.5 * np.pi)
    tool = Tool("cylinder", Capsule(RADIUS - 0.5 * THICKNESS, 1.0, rotation=turned))
    drape = of_flat_blank(blank, tool, THICKNESS)
    edge = read_part_edge(edge_table(tmp_path / "edge.csv", around(ellipse(HALF))))
    pattern = pattern_of_net(drape, blank, THICKNESS, "ply", edge, Symmetry(symmetry))
    assert np.allclose(np.sum((pattern.trim[0] / HALF) ** 2, axis=1), 1.0, atol=0.03)
    assert np.degrees(np.arctan2(pattern.warp[1], pattern.warp[0])) == pytest.approx(angle)


def test_a_first_blank_needs_a_net_that_is_large_enough(tmp_path):
    blank = Blank.rectangle((-0.05, -0.05), (0.05, 0.05), 0.005, height=RADIUS + 0.02)
    turned = rotation_matrix((0.0, 0.0, 1.0), 0.5 * np.pi)
    drape = of_flat_blank(blank, Tool("cylinder", Capsule(RADIUS, 1.0, rotation=turned)), THICKNESS)
    edge = read_part_edge(edge_table(tmp_path / "edge.csv", around(ellipse(HALF))))
    with pytest.raises(
        InputError, match="mm beyond the border of the net of ply on cylinder; the part needs a larger blank"
    ):
        pattern_of_net(drape, blank, THICKNESS, "ply", edge)


def test_a_margin_is_a_line_at_its_distance():
    square = np.array([(0.0, 0.0), (0.1, 0.0), (0.1, 0.06), (0.0, 0.06)])
    line = with_margin(square, 0.02)
    distance = -Outline(square).nearest(line)[0]
    assert distance == pytest.approx(0.02, abs=2e-5)
    assert plan_area(line) == pytest.approx(0.006 + 0.32 * 0.02 + np.pi * 0.02**2, rel=2e-3)
    assert np.array_equal(with_margin(square, 0.0), square)


@pytest.mark.parametrize("margin", [1e-5, 1e-3, 0.05])
def test_a_margin_of_any_width_is_quick_and_keeps_its_distance(margin):
    turn = np.linspace(0.0, 2.0 * np.pi, 2000, endpoint=False)
    radius = 0.4 + 0.1 * np.cos(5.0 * turn)  # convex and hollow
    line = np.column_stack([radius * np.cos(turn), radius * np.sin(turn)])
    started = time.process_time()
    found = with_margin(line, margin)
    assert time.process_time() - started < 1.0
    assert plan_area(found) > plan_area(line)
    distance = -Outline(line).nearest(found)[0]
    assert distance == pytest.approx(margin, rel=2e-3, abs=2e-8)
