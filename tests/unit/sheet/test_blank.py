"""Sheet meshes: construction, and mistakes that are reported before a run."""

import numpy as np
import pytest

from weavesim.errors import InputError
from weavesim.fabric.presets import glass_polypropylene
from weavesim.sheet.blank import Blank
from weavesim.sheet.sheet import Sheet

SQUARES = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])
NODES = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]]) * 0.01


def test_rectangle_has_the_wished_elements():
    blank = Blank.rectangle((-0.1, 0.0), (0.1, 0.05), 0.01, height=0.002)
    assert (blank.node_count, blank.element_count) == (21 * 6, 20 * 5)
    assert np.allclose(blank.node_position.min(axis=0), [-0.1, 0.0, 0.002])
    assert np.allclose(blank.node_position.max(axis=0), [0.1, 0.05, 0.002])
    assert np.allclose(blank.material_coordinates, blank.node_position[:, :2])
    assert np.allclose(blank.initial_director, [0.0, 0.0, 1.0])


def test_sides_are_divided_evenly():
    blank = Blank.rectangle((0.0, 0.0), (0.1, 0.1), (0.03, 0.3))
    assert blank.element_count == 3
    assert np.allclose(blank.element_centres()[:, 0], [0.1 / 6, 0.05, 0.5 / 6])


@pytest.mark.parametrize("angle", [0.0, 30.0, -45.0, 90.0])
def test_yarns_follow_their_angle_whatever_the_mesh(angle):
    blank = Blank.rectangle((0.0, 0.0), (0.04, 0.03), 0.01, yarn_angle=angle, distortion=0.3)
    radians = np.deg2rad(angle)
    assert np.allclose(blank.warp_direction, [np.cos(radians), np.sin(radians), 0.0])
    assert np.allclose(blank.weft_direction, [-np.sin(radians), np.cos(radians), 0.0])


def test_distortion_moves_inner_nodes_only_and_repeats():
    plain = Blank.rectangle((0.0, 0.0), (0.04, 0.04), 0.01)
    one, two, other = (Blank.rectangle((0.0, 0.0), (0.04, 0.04), 0.01, distortion=0.3, seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(one.node_position, two.node_position)
    assert not np.array_equal(one.node_position, other.node_position)
    rim = plain.boundary_loop()
    assert np.array_equal(one.node_position[rim], plain.node_position[rim])


def test_boundary_loop_goes_around_counter_clockwise():
    blank = Blank.rectangle((0.0, 0.0), (0.05, 0.03), 0.01)
    loop = blank.boundary_loop()
    assert len(loop) == len(set(loop.tolist())) == 2 * (5 + 3)
    x, y, _ = blank.node_position[loop].T
    assert np.allclose(np.hypot(np.roll(x, -1) - x, np.roll(y, -1) - y), 0.01)
    assert 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) == pytest.approx(0.05 * 0.03)


def test_boundary_loop_of_a_sheet_with_a_hole_is_the_outline():
    whole = Blank.rectangle((0.0, 0.0), (0.05, 0.05), 0.01)
    inside = np.linalg.norm(whole.element_centres()[:, :2] - 0.025, axis=1) < 0.004
    holed = Blank.from_mesh(whole.node_position, whole.quads[~inside])
    assert holed.element_count == whole.element_count - 1
    assert set(holed.boundary_loop().tolist()) == set(whole.boundary_loop().tolist())


def test_arrays_cannot_be_changed():
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.02), 0.01)
    with pytest.raises(ValueError, match="read-only"):
        blank.node_position[0, 0] = 1.0


def test_yarns_of_a_curved_mesh_lie_in_its_elements():
    flat = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.005)
    position = flat.node_position.copy()
    position[:, 2] = 5.0 * (position[:, 0] ** 2 - position[:, 1] ** 2)
    blank = Blank.from_mesh(position, flat.quads, yarn_angle=20.0)
    corner = position[blank.quads]
    normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    for yarn in (blank.warp_direction, blank.weft_direction):
        assert np.allclose(np.linalg.norm(yarn, axis=1), 1.0)
        assert np.abs(np.einsum("ij,ij->i", yarn, normal)).max() < 1e-12
    assert np.abs(np.einsum("ij,ij->i", blank.warp_direction, blank.weft_direction)).max() < 1e-12
    assert np.allclose(np.linalg.norm(blank.initial_director, axis=1), 1.0)


def changed(row: int, value) -> np.ndarray:
    nodes = NODES.copy()
    nodes[row] = value
    return nodes


@pytest.mark.parametrize(
    ("nodes", "quads", "message"),
    [
        (changed(4, [np.nan, 0.0, 0.0]), SQUARES, r"node 4 is at .*nan.* must be finite"),
        (changed(2, [np.inf, 0.0, 0.0]), SQUARES, r"node 2 .* must be finite"),
        (NODES * 1e5, SQUARES, r"1000 times too big.*unit_scale=0.001"),
        (NODES, SQUARES[:, ::-1] * [[1], [0]] + SQUARES * [[0], [1]], r"element.*flipped"),
        (changed(4, [0.005, 0.0, 0.0]), SQUARES, r"degenerate or not convex, the first is element 0"),
        (changed(4, NODES[1]), SQUARES, r"degenerate or not convex"),
        (changed(4, [0.002, 0.002, 0.0]), SQUARES, r"not convex"),
        (NODES, [[0, 1, 4, 4], [1, 2, 5, 4]], r"degenerate"),
        (NODES, [[0, 1, 3, 4], [1, 2, 5, 4]], r"degenerate or not convex"),
        (NODES, [[0, 1, 4, 9]], r"use nodes 0 to 9; there are 6"),
        (NODES, [[0, 1, 4, -1]], r"use nodes -1"),
        (NODES, np.empty((0, 4), dtype=int), r"m > 0"),
        (NODES[:, :2], SQUARES, r"\(n, 3\)"),
        (NODES, [[0, 1, 4]], r"\(m, 4\)"),
        (NODES, np.vstack([SQUARES, SQUARES[:1]]), r"elements 0 and 2 have the same nodes"),
    ],
    ids=[
        "NaN", "infinite", "millimetres", "flipped", "straight corner", "doubled node", "dented", "triangle", "crossed",
        "node number", "negative node", "no elements", "two columns", "triangles", "doubled element",
    ],
)  # fmt: skip
def test_bad_meshes_are_refused(nodes, quads, message):
    with pytest.raises(InputError, match=message):
        Blank.from_mesh(nodes, np.array(quads))


def test_direct_construction_is_checked_too():
    good = Blank.from_mesh(NODES, SQUARES)
    with pytest.raises(InputError, match="must be finite"):
        Blank(changed(0, [np.nan, 0.0, 0.0]), good.material_coordinates, good.quads, good.warp_direction,
              good.weft_direction, good.initial_director)  # fmt: skip


@pytest.mark.parametrize(
    ("lower", "upper", "size"),
    [((0, 0), (0.1, 0.1), 0.0), ((0, 0), (0.1, 0.1), -0.01), ((0, 0), (-0.1, 0.1), 0.01)],
)
def test_bad_rectangles_are_refused(lower, upper, size):
    with pytest.raises(InputError, match="finite and positive"):
        Blank.rectangle(lower, upper, size)


CORNERS = ((0.0, 0.0), (0.1, 0.1))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Blank.rectangle((0, 0), (np.nan, 1), 0.01), "upper = nan: a finite number is needed"),
        (lambda: Blank.rectangle((0, 0, 0), (1, 1, 0), 0.1), r"lower = \(0, 0, 0\): two numbers are needed"),
        (lambda: Blank.rectangle(0.0, (1, 1), 0.1), "lower = 0.0: two numbers are needed"),
        (lambda: Blank.rectangle(*CORNERS, "0.01"), "element_size = '0.01': a finite number is needed"),
        (lambda: Blank.rectangle(*CORNERS, "fine"), "element_size = 'fine': a finite number is needed"),
        (lambda: Blank.rectangle(*CORNERS, (0.1, 0.1, 0.1)), "element_size = .*: two numbers are needed"),
        (lambda: Blank.rectangle(*CORNERS, 0.01, yarn_angle=np.nan), "yarn_angle = nan: a finite number is needed"),
        (lambda: Blank.rectangle(*CORNERS, 0.01, height="low"), "height = 'low': a finite number is needed"),
        (lambda: Blank.rectangle(*CORNERS, 0.1, distortion=np.nan), "distortion = nan: a finite number is needed"),
        (lambda: Blank.disc("wide", 0.01), "radius = 'wide': a finite number above 0 is needed"),
        (lambda: Blank.disc(0.1, "fine"), "element_size = 'fine': a finite number above 0 is needed"),
        (lambda: Blank.disc(0.1, 0.01, yarn_angle="x"), "yarn_angle = 'x': a finite number is needed"),
        (lambda: Blank.fitted("round", 0.01), "the outline is no array of numbers"),
        (lambda: Blank.from_mesh(NODES, SQUARES + 0.5), "elements name node 0.5; whole numbers are needed"),
        (lambda: Blank.from_mesh(NODES, SQUARES * np.nan), "elements name node nan; whole numbers are needed"),
        (lambda: Blank.from_mesh(NODES, SQUARES + 2**32), "whole numbers are needed"),
        (lambda: Blank.from_mesh(NODES, [[0, 1, 4, 3], [1, 2]]), "elements: an array of numbers is needed"),
        (lambda: Blank.from_mesh("nodes", SQUARES), "nodes: an array of numbers is needed"),
        (lambda: Blank.from_mesh(NODES, SQUARES, warp_direction=np.full(3, np.nan)), "warp_direction: finite numbers"),
        (lambda: Blank.from_mesh(NODES, SQUARES, warp_direction=np.nan), r"warp_direction: shape \(\), but \(3,\) or"),
        (lambda: Blank.from_mesh(NODES, SQUARES, warp_direction="x"), "warp_direction: an array of numbers is needed"),
        (lambda: Blank.from_mesh(NODES, SQUARES, material_coordinates=NODES[:, :2] * np.nan), "material_coordinates"),
    ],
)
def test_what_makes_no_blank_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


UNIT = 1.0 / np.sqrt(2.0)


@pytest.mark.parametrize("name", ["warp_direction", "weft_direction", "initial_director"])
@pytest.mark.parametrize("row", [(np.nan, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.00001), (0.0, 0.0, np.inf)])
def test_a_direction_has_length_one(name, row):
    good = Blank.from_mesh(NODES, SQUARES)
    rows = getattr(good, name).copy()
    rows[1] = row
    with pytest.raises(InputError, match=rf"Blank: {name}: entry 1 is .*; a direction of length 1 is needed"):
        good.model_copy(update={name: rows})


@pytest.mark.parametrize(
    ("name", "row", "message"),
    [
        ("warp_direction", (UNIT, 0.0, UNIT), "warp_direction: entry 1 .* in the plane of the element"),
        ("weft_direction", (0.0, 0.0, 1.0), "weft_direction: entry 1 .* in the plane of the element"),
        ("weft_direction", (1.0, 0.0, 0.0), "weft_direction: entry 1 .* not parallel to the warp"),
        ("weft_direction", (-1.0, 0.0, 0.0), "weft_direction: entry 1 .* not parallel to the warp"),
    ],
)
def test_yarns_span_the_plane_of_their_element(name, row, message):
    good = Blank.from_mesh(NODES, SQUARES)
    rows = getattr(good, name).copy()
    rows[1] = row
    with pytest.raises(InputError, match=message):
        good.model_copy(update={name: rows})
    oblique = np.tile([UNIT, UNIT, 0.0], (2, 1))
    assert np.array_equal(good.model_copy(update={"weft_direction": oblique}).weft_direction, oblique)


def test_material_coordinates_are_finite():
    good = Blank.from_mesh(NODES, SQUARES)
    coordinates = good.material_coordinates.copy()
    coordinates[2, 1] = np.inf
    with pytest.raises(InputError, match=r"material_coordinates: entry 2 is \[0.02, inf\]; finite numbers are needed"):
        good.model_copy(update={"material_coordinates": coordinates})


@pytest.mark.parametrize("orientation", [-73.0, 0.0, 20.0, 180.0])
def test_good_curved_and_distorted_blanks_may_be_turned(orientation):
    flat = Blank.rectangle((-0.02, -0.02), (0.02, 0.02), 0.005, distortion=0.3, yarn_angle=31.0)
    position = flat.node_position.copy()
    position[:, 2] = 20.0 * position[:, 0] * position[:, 1]
    for blank in (flat, Blank.from_mesh(position, flat.quads.astype(float)), Blank.disc(0.03, 0.004, distortion=0.2)):
        turned = Sheet(blank, glass_polypropylene(), orientation=orientation).oriented_blank
        assert np.abs(np.einsum("ij,ij->i", turned.warp_direction, turned.weft_direction)).max() < 1e-12


def test_warp_normal_to_the_sheet_is_refused():
    with pytest.raises(InputError, match="normal to the sheet"):
        Blank.from_mesh(NODES, SQUARES, warp_direction=np.array([0.0, 0.0, 1.0]))


def test_file_of_quadrilaterals(tmp_path):
    import meshio

    path = tmp_path / "blank.vtk"
    # one node that no element uses, and millimetres
    points = np.vstack([NODES, [[9.0, 9.0, 0.0]]]) * 1000.0
    meshio.Mesh(points, [("quad", SQUARES)]).write(path)
    blank = Blank.from_file(path, unit_scale=0.001, yarn_angle=45.0)
    assert (blank.node_count, blank.element_count) == (6, 2)
    assert np.allclose(blank.node_position, NODES)
    triangles = tmp_path / "triangles.vtk"
    meshio.Mesh(NODES, [("triangle", SQUARES[:, :3])]).write(triangles)
    with pytest.raises(InputError, match="triangle.*quadrilaterals are needed"):
        Blank.from_file(triangles)


def test_missing_and_unreadable_files_are_reported(tmp_path):
    with pytest.raises(InputError, match="cannot be read"):
        Blank.from_file(tmp_path / "nothing.vtk")
    path = tmp_path / "broken.vtk"
    path.write_text("this is no mesh")
    with pytest.raises(InputError, match="cannot be read"):
        Blank.from_file(path)


PLIES = np.vstack([NODES, NODES + [0.0, 0.0, 0.001]])


@pytest.mark.parametrize(
    ("nodes", "quads", "message"),
    [
        (PLIES, np.vstack([SQUARES, SQUARES + 6]), "2 parts that share no node, of 2, 2 elements; .*a separate sheet"),
        (np.vstack([NODES, [[9.0, 9.0, 0.0]]]), SQUARES, "node 6 belongs to no element; remove it"),
    ],
    ids=["two plies", "lonely node"],
)
def test_a_blank_is_one_sheet(nodes, quads, message):
    with pytest.raises(InputError, match=message):
        Blank.from_mesh(nodes, quads)


def test_arrays_that_do_not_fit_the_mesh_are_refused():
    good = Blank.from_mesh(NODES, SQUARES)
    with pytest.raises(InputError, match=r"warp_direction: shape \(1, 3\), but \(2, 3\) is needed"):
        good.model_copy(update={"warp_direction": good.warp_direction[:1]})


@pytest.mark.parametrize("distortion", [-0.1, 0.4, 0.9])
def test_a_distortion_out_of_range_is_refused(distortion):
    with pytest.raises(InputError, match="distortion"):
        Blank.rectangle((0.0, 0.0), (0.1, 0.1), 0.01, distortion=distortion)


@pytest.mark.parametrize(
    "make",
    [
        lambda: Blank.rectangle((0.0, 0.0), (0.3, 0.2), 1e-6),
        lambda: Blank.rectangle((0.0, 0.0), (3.0, 3.0), 2e-4),
        lambda: Blank.rectangle((0.0, 0.0), (0.3, 0.2), (1e-3, 1e-9)),
        lambda: Blank.rectangle((0.0, 0.0), (0.3, 0.2), 1e-100),
        lambda: Blank.disc(0.1, 1e-6),
        lambda: Blank.fitted(np.array([(0, 0), (1, 0), (1, 1), (0, 1.0)]), 1e-5),
    ],
)
def test_a_mesh_that_no_machine_can_hold_is_refused_at_once(make):
    with pytest.raises(InputError, match="divide the blank into about .*at most 20,000,000 are allowed"):
        make()


def test_a_rectangle_in_millimetres_is_told_so():
    with pytest.raises(InputError, match=r"300 m wide: at most 20 m is allowed: write 0.3 for 300 mm$"):
        Blank.rectangle((0.0, 0.0), (300.0, 200.0), 5.0)
