"""Outlines of plies: DXF drawings with holes and slits, meshes of triangles and quadrilaterals; broken ones refused."""

import numpy as np
import pytest

from tests.support.jobs import TRAY, write_tray
from weavesim import InputError
from weavesim.job.blanks.outlines import read_drawing
from weavesim.job.build import setup_of
from weavesim.job.read import read_job

ezdxf = pytest.importorskip("ezdxf")


def drawing(path, add, unit=4, **options):
    document = ezdxf.new(units=unit)
    add(document.modelspace(), document)
    document.saveas(path)
    return path


def plate(space, document):
    """200 x 160 mm of single lines, rounded at a corner, with a round hole and a slit."""
    space.add_line((-100, -80), (100, -80))
    space.add_line((100, 60), (100, -80))
    space.add_arc((80, 60), 20, 0, 90)
    space.add_line((80, 80), (-100, 80))
    space.add_line((-100, 80), (-100, -80))
    space.add_circle((-40, 0), 25)
    space.add_lwpolyline([(30, -30), (60, 10)])
    space.add_text("blank", dxfattribs={"insert": (0, 0)})


def area(loop):
    x, y = loop.T
    return 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def test_lines_and_arcs_are_joined_to_outline_hole_and_slit(tmp_path):
    loops = read_drawing(drawing(tmp_path / "blank.dxf", plate))
    assert np.isclose(area(loops.outline), 0.2 * 0.16 - (1 - np.pi / 4) * 0.02**2, rtol=1e-5)
    assert len(loops.holes) == 1 and np.isclose(area(loops.holes[0]), np.pi * 0.025**2, rtol=5e-3)
    assert np.allclose(loops.slits[0], [[0.03, -0.03], [0.06, 0.01]])
    assert loops.notes == ("blank.dxf: 1 TEXT left out: no lines",)


@pytest.mark.parametrize(("code", "scale"), [(1, 0.0254), (5, 0.01), (6, 1.0)])
def test_the_unit_of_a_drawing_is_taken(tmp_path, code, scale):
    def square(space, _):
        space.add_lwpolyline([(0, 0), (3, 0), (3, 2), (0, 2)], close=True)

    loops = read_drawing(drawing(tmp_path / "blank.dxf", square, unit=code))
    assert np.isclose(area(loops.outline), 6 * scale**2)


def rectangle(space, document):
    space.add_lwpolyline([(0, 0), (100, 0), (100, 50), (0, 50)], close=True)


def open_line(space, document):
    space.add_lwpolyline([(0, 0), (100, 0), (100, 50), (0, 50), (0, 3)])


def two_plates(space, document):
    rectangle(space, document)
    space.add_lwpolyline([(200, 0), (300, 0), (300, 50)], close=True)


def line_out(space, document):
    rectangle(space, document)
    space.add_line((50, 25), (150, 25))


def tilted(space, document):
    space.add_line((0, 0, 0), (100, 0, 50))


def on_layers(space, document):
    for name, shift in (("ply_1", 0), ("ply_2", 20)):
        document.layers.add(name)
        corners = [(0, 0), (100 + shift, 0), (100 + shift, 50), (0, 50)]
        space.add_lwpolyline(corners, close=True, dxfattribs={"layer": name})


@pytest.mark.parametrize(
    ("add", "options", "message"),
    [
        (open_line, {}, r"no line is closed; the nearest ends are 3 mm apart, at \(0, 3\) mm"),
        (two_plates, {}, "it has several outlines, another one about"),
        (line_out, {}, r"an open line at \(50, 25\) mm leads out of the outline"),
        (tilted, {}, r"the line from \(0, 0, 0\) mm does not lie in a plane z"),
        (lambda space, document: space.add_text("nothing"), {}, "it has no lines"),
        (rectangle, {"unit": 0}, "unit: is required, since drawing .* does not say its unit"),
        (rectangle, {"metres_per_unit": 1.0}, "says that its unit is 0.001 m, but 1 m is given"),
        (on_layers, {"layer": "ply_3"}, "has no such layer; it has ply_1, ply_2"),
    ],
)
def test_a_broken_drawing_is_refused(tmp_path, add, options, message):
    path = drawing(tmp_path / "blank.dxf", add, unit=options.pop("unit", 4))
    with pytest.raises(InputError, match=message):
        read_drawing(path, **options)


def test_what_is_off_or_frozen_is_no_outline(tmp_path):
    def hidden(space, document):
        rectangle(space, document)
        for name, hide in (("frame", "off"), ("sheet", "freeze")):
            getattr(document.layers.add(name), hide)()
            space.add_lwpolyline(
                [(-500, -500), (500, -500), (500, 500), (-500, 500)], close=True, dxfattribs={"layer": name}
            )

    path = drawing(tmp_path / "blank.dxf", hidden)
    plain = read_drawing(drawing(tmp_path / "plain.dxf", rectangle))
    loops = read_drawing(path)
    assert np.allclose(loops.outline, plain.outline) and not loops.holes
    assert "blank.dxf: 1 on layer frame left out: it is off or frozen; name it with layer to take it" in loops.notes
    assert np.isclose(area(read_drawing(path, layer="frame").outline), 1.0)


def test_what_is_drawn_twice_is_taken_once(tmp_path):
    corners = [(-100, -80), (100, -80), (100, 80), (-100, 80)]

    def twice(space, document):
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            space.add_line(a, b)
            space.add_line(b, a)
        space.add_circle((0, 0), 20)

    def over(space, document):
        space.add_lwpolyline(corners, close=True)
        space.add_lwpolyline(corners[2:] + corners[:2], close=True)
        space.add_hatch().paths.add_polyline_path(corners[::-1], is_closed=True)

    def slots(space, document):
        space.add_lwpolyline(corners, close=True)
        for begin in (0, 2):
            for x in (-60, -20, 20, 60):
                slot = [(x, -10), (x + 8, -10), (x + 8, 10), (x, 10)]
                space.add_lwpolyline(slot[begin:] + slot[:begin], close=True)

    for draw, holes, count in ((twice, 1, 4), (over, 0, 2), (slots, 4, 4)):
        loops = read_drawing(drawing(tmp_path / "blank.dxf", draw))
        assert np.isclose(area(loops.outline), 0.2 * 0.16) and len(loops.holes) == holes
        assert f"{count} lines that are drawn twice left out" in loops.notes[-1]


def test_what_is_no_drawing_is_refused(tmp_path):
    (tmp_path / "blank.dxf").write_bytes(b"\x00\x01nonsense" * 100)
    with pytest.raises(InputError, match="no DXF drawing that can be read"):
        read_drawing(tmp_path / "blank.dxf")


def test_plies_of_several_layers_come_from_one_drawing(tmp_path):
    path = drawing(tmp_path / "blank.dxf", on_layers)
    assert np.isclose(area(read_drawing(path, layer="ply_2").outline), 0.12 * 0.05)


def job_with(folder, outline, further=""):
    text = TRAY.replace('rectangle = ["200 mm", "160 mm"]', f'outline = "{outline}"\n{further}')
    return setup_of(read_job(write_tray(folder, text))).sheet.blank


def test_a_drawing_in_another_unit_is_asked_about_before_it_is_meshed(tmp_path):
    drawing(tmp_path / "blank.dxf", plate, unit=6)  # metres
    with pytest.raises(InputError, match=r"a ply of 200 x 160 m has about 319,.* elements of 0.01 m: check the unit"):
        job_with(tmp_path, "blank.dxf")
    with pytest.raises(InputError, match="has about 1,500,000 elements of 0.0002 m"):
        setup_of(read_job(write_tray(tmp_path), ["ply.mesh_size=0.2 mm", 'ply.rectangle=["0.3 m", "0.2 m"]']))


def elements_area(blank):
    corner = blank.node_position[blank.quads]
    return 0.5 * np.linalg.norm(np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]), axis=1).sum()


@pytest.mark.parametrize("angle", [0, 45])
def test_a_drawing_becomes_a_blank_with_hole_and_slit(tmp_path, angle):
    path = drawing(tmp_path / "blank.dxf", plate)
    loops = read_drawing(path)
    blank = job_with(tmp_path, "blank.dxf", f"angle = {angle}")
    assert np.isclose(elements_area(blank), area(loops.outline) - area(loops.holes[0]), rtol=2e-3)
    assert any("slits are cut along edges" in note for note in blank.source_notes)
    place, count = np.unique(blank.node_position.round(9), axis=0, return_counts=True)
    assert (count == 2).sum() >= 3  # both sides of the slit


def test_holes_and_slits_may_stand_in_the_job(tmp_path):
    further = """holes = [[["-20 mm", "-20 mm"], ["20 mm", "-20 mm"], ["20 mm", "20 mm"], ["-20 mm", "20 mm"]]]
slits = [[["50 mm", "0 mm"], ["80 mm", "0 mm"]]]"""
    text = TRAY.replace('rectangle = ["200 mm", "160 mm"]', f'rectangle = ["200 mm", "160 mm"]\n{further}')
    blank = setup_of(read_job(write_tray(tmp_path, text))).sheet.blank
    assert np.isclose(elements_area(blank), 0.2 * 0.16 - 0.04**2)


OBJ = "".join(f"v {x} {y} 0\n" for x in (0, 50, 100) for y in (0, 40, 80))


def test_a_mesh_of_quadrilaterals_is_used_as_it_is(tmp_path):
    (tmp_path / "blank.obj").write_text(OBJ + "f 1 4 5 2\nf 4 7 8 5\nf 2 5 6 3\nf 5 8 9 6\n")
    blank = job_with(tmp_path, "blank.obj", 'unit = "mm"\nturn = "90 deg"\ncentre = ["80 mm", "0 mm"]\nangle = 30')
    assert blank.element_count == 4
    assert np.allclose(blank.node_position[:, :2].min(axis=0), [0.0, 0.0], atol=1e-12)
    assert np.allclose(blank.node_position[:, 2], 0.0006)
    assert np.allclose(blank.warp_direction[:, 0], np.cos(np.pi / 6))


def test_its_nodes_and_elements_may_be_put_in_order(tmp_path):
    nodes = np.random.default_rng(0).permutation(9)
    place = np.argsort(nodes)
    points = [(x, y) for x in (0, 50, 100) for y in (0, 40, 80)]
    lines = [f"{301 + k}, {points[nodes[k]][0]}., {points[nodes[k]][1]}., 0.\n" for k in range(9)]
    quads = np.array([(0, 3, 4, 1), (3, 6, 7, 4), (1, 4, 5, 2), (4, 7, 8, 5)])
    rows = [f"{77 - k}, {', '.join(str(301 + place[n]) for n in quad)}\n" for k, quad in enumerate(quads)]
    (tmp_path / "blank.inp").write_text("*NODE\n" + "".join(lines) + "*ELEMENT, TYPE=S4\n" + "".join(rows))
    for numbering in ("kept", "neighbouring"):
        blank = job_with(
            tmp_path, "blank.inp", f'unit = "mm"\nnumbering = "{numbering}"\ncentre = ["-50 mm", "-40 mm"]'
        )
        assert (np.diff(blank.node_number) > 0).all() == (numbering == "kept")
        flat = 1e-3 * np.array(points)[nodes[blank.node_number - 301]] - (0.05, 0.04)
        assert np.allclose(blank.node_position[:, :2], flat)
        assert np.array_equal(nodes[blank.node_number[blank.quads] - 301], quads[77 - blank.element_number])


@pytest.mark.parametrize("value", ['"along"', "3"])
def test_another_numbering_is_refused(tmp_path, value):
    (tmp_path / "blank.obj").write_text(OBJ + "f 1 4 5 2\n")
    with pytest.raises(InputError, match="numbering = .*'kept' or 'neighbouring'"):
        job_with(tmp_path, "blank.obj", f'unit = "mm"\nnumbering = {value}')


def test_numbering_is_of_a_mesh_of_quadrilaterals(tmp_path):
    (tmp_path / "blank.obj").write_text(OBJ + "f 1 7 9\nf 1 9 3\n")
    with pytest.raises(InputError, match="numbering: blank.obj has triangles"):
        job_with(tmp_path, "blank.obj", 'unit = "mm"\nnumbering = "neighbouring"')
    with pytest.raises(InputError, match="numbering.*a mesh as outline"):
        job_with(tmp_path, "blank.dxf", 'numbering = "kept"')
    with pytest.raises(InputError, match="numbering.*a file as outline"):
        setup_of(read_job(write_tray(tmp_path, TRAY), ["ply.numbering=neighbouring"]))


def test_a_mesh_of_triangles_gives_its_outline(tmp_path):
    (tmp_path / "blank.obj").write_text(OBJ + "f 1 7 9\nf 1 9 3\n")
    blank = job_with(tmp_path, "blank.obj", 'unit = "mm"')
    assert np.isclose(elements_area(blank), 0.1 * 0.08)
    assert "meshed anew" in blank.source_notes[0]


@pytest.mark.parametrize(
    ("content", "further", "message"),
    [
        (OBJ + "f 1 7 9\n", "", "unit: is required with blank.obj"),
        (OBJ.replace("v 0 0 0", "v 0 0 9") + "f 1 7 9\n", 'unit = "mm"', "must lie in a plane z; its heights differ"),
        (OBJ + "f 1 4 5 2\n", 'unit = "mm"\nslits = [[[0, 0], [1, 1]]]', "a mesh of quadrilaterals has its own"),
        (OBJ + "f 1 4 5 2\nf 4 7 8\n", 'unit = "mm"', "contains cells that are no elements of a blank"),
        (OBJ, 'unit = "mm"', "has no"),
        (OBJ + "f 1 4 5 2\n", 'unit = "m"', r'1000 times too big\); scale it to metres \(unit = "mm"\)'),
    ],
)
def test_a_broken_mesh_is_refused_with_its_place(tmp_path, content, further, message):
    (tmp_path / "blank.obj").write_text(content)
    with pytest.raises(InputError, match=f"(?s)line 6, .*{message}"):
        job_with(tmp_path, "blank.obj", further)
