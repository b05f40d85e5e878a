"""Plies on another mesh: the nearest point in space, with its distance; what does not lie on the part is refused."""

import meshio
import numpy as np
import pytest

from tests.support.stored_runs import stored_run, stored_sheet
from weavesim.errors import InputError
from weavesim.output.export.exporting import Export, export_run
from weavesim.output.export.formed import mapped_part, own_parts, part_name
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import Symmetry

RADIUS = 0.1


def cylinder(x: np.ndarray, y: np.ndarray, radius: float = RADIUS) -> np.ndarray:
    """A sheet laid around a cylinder along y without strain."""
    return np.column_stack([radius * np.sin(x / RADIUS), y, radius * np.cos(x / RADIUS)])


def cylinder_run(**given):
    """Yarns at 30 degrees to the circumference, on the whole or, with symmetry, on a quarter of it."""
    lower = (0.0, 0.0) if given else (-0.1, -0.05)
    blank = Blank.rectangle(lower, (0.1, 0.05), 0.005, yarn_angle=30.0)
    return stored_run(stored_sheet(blank, cylinder(*blank.material_coordinates.T), **given))


def structural_mesh(path, scale=1.0, lift=0.0, triangles=False):
    """Another mesh of the same cylinder, oblique to the first."""
    blank = Blank.fitted(np.array([(-0.08, -0.04), (0.08, -0.04), (0.08, 0.04), (-0.08, 0.04)]), 0.007, mesh_angle=20.0)
    points = cylinder(*blank.material_coordinates.T, radius=RADIUS + lift)
    cells = [("quad", blank.quads)]
    if triangles:
        cells = [("triangle", np.concatenate([blank.quads[:, [0, 1, 2]], blank.quads[:, [0, 2, 3]]]))]
    meshio.write(path, meshio.Mesh(np.round(scale * points, 9), cells))
    return blank


@pytest.mark.parametrize("ending", ["inp", "vtu", "bdf"])
def test_fibres_on_another_mesh_are_those_of_the_surface(tmp_path, ending):
    path = tmp_path / f"part.{ending}"
    structural_mesh(path)
    mapping = mapped_part(cylinder_run(), path)
    ply, centre = mapping.part.plies[0], mapping.part.mesh.centres
    angle = np.arctan2(centre[:, 0], centre[:, 2])
    around = np.column_stack([np.cos(angle), np.zeros_like(angle), -np.sin(angle)])
    for yarn, turn in ((ply.warp, 30.0), (ply.weft, 120.0)):
        wanted = np.cos(np.deg2rad(turn)) * around + np.sin(np.deg2rad(turn)) * np.array([0.0, 1.0, 0.0])
        turned = np.degrees(np.arccos(np.clip(np.einsum("ei,ei->e", yarn, wanted), -1.0, 1.0)))
        # half an element of the sheet around the cylinder
        assert turned.max() < 2.0
        assert np.einsum("ei,ei->e", yarn, mapping.part.mesh.frames[:, 2]) == pytest.approx(0.0, abs=1e-12)
    # sagitta of elements of 5 and up to 10 mm over a radius of 100 mm
    assert 0.0 < mapping.largest_distance < 0.13e-3


def test_the_distance_is_reported_and_limited(tmp_path):
    path = tmp_path / "part.inp"
    structural_mesh(path, lift=0.003)
    mapping = mapped_part(cylinder_run(), path)
    assert mapping.mean_distance == pytest.approx(0.003, rel=0.03)
    assert mapping.part.plies[0].values["distance"].values == pytest.approx(mapping.part.plies[0].distance)
    structural_mesh(path, lift=0.02)
    with pytest.raises(InputError, match="elements lie farther than 0.0099+ m from the formed sheet sheet.*--within"):
        mapped_part(cylinder_run(), path)
    assert mapped_part(cylinder_run(), path, within=0.03).mean_distance == pytest.approx(0.02, rel=0.05)


def test_the_unit_of_the_mesh_counts(tmp_path):
    path = tmp_path / "part.inp"
    structural_mesh(path, scale=1e3)
    assert mapped_part(cylinder_run(), path, unit=1e-3).largest_distance < 0.13e-3
    with pytest.raises(InputError, match="check its unit"):
        mapped_part(cylinder_run(), path)
    done = export_run(cylinder_run(), Export(["abaqus"], tmp_path / "out", unit="mm", map_onto=path))
    assert any("at most 0.1" in note and "mm" in note for note in done.notes)
    # the mesh keeps its coordinates
    assert np.allclose(meshio.read(done.files[0]).points, meshio.read(path).points, atol=1e-6)


def test_a_quarter_is_mapped_with_its_mirrored_copies(tmp_path):
    path = tmp_path / "part.vtu"
    structural_mesh(path, triangles=True)
    mapping = mapped_part(cylinder_run(symmetry=Symmetry(("x", "y"))), path)
    ply, centre = mapping.part.plies[0], mapping.part.mesh.centres
    assert mapping.largest_distance < 0.13e-3
    # the mirror image of yarns at 30 degrees runs at -30 degrees where x y < 0
    along = np.sign(ply.warp[:, 0] * ply.warp[:, 1])
    away = np.abs(centre[:, :2]).min(axis=1) > 0.006
    assert np.array_equal(along[away], np.sign(centre[away, 0] * centre[away, 1]))
    assert len(mapping.part.mesh.cells) == 1 and mapping.part.mesh.cells[0].kind == "triangle"


def test_plies_are_stacked_along_the_normals(tmp_path):
    path = tmp_path / "part.inp"
    structural_mesh(path)
    blank = Blank.rectangle((-0.1, -0.05), (0.1, 0.05), 0.005)
    outer, inner = (
        stored_sheet(blank, cylinder(*blank.material_coordinates.T, radius=RADIUS + lift), name=name)
        for name, lift in (("outer", 0.0005), ("inner", -0.0005))
    )
    part = mapped_part(stored_run(outer, inner), path).part
    # the normals of the mesh point outwards
    assert [ply.name for ply in part.plies] == ["inner", "outer"]
    assert [layer.name for layer in part.layers] == ["ply1_warp", "ply1_weft", "ply2_warp", "ply2_weft"]
    assert any("inner, outer" in note for note in part.notes)


def test_a_mesh_that_stands_across_the_sheet_is_refused(tmp_path):
    path = tmp_path / "rib.vtu"
    rib = np.array([(0.0, -0.01, 0.098), (0.0, 0.01, 0.098), (0.0, 0.01, 0.102), (0.0, -0.01, 0.102)])
    meshio.write(path, meshio.Mesh(rib, [("quad", np.array([[0, 1, 2, 3]]))]))
    with pytest.raises(InputError, match="1 elements stand across the formed sheet"):
        mapped_part(cylinder_run(), path)


def test_a_mesh_of_solids_is_refused(tmp_path):
    path = tmp_path / "solid.vtu"
    corners = np.array([(x, y, z) for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], dtype=float)
    meshio.write(path, meshio.Mesh(corners, [("hexahedron", np.arange(8)[None])]))
    with pytest.raises(InputError):
        mapped_part(cylinder_run(), path)


def test_nodes_in_the_middle_of_sides_are_kept(tmp_path):
    path = tmp_path / "part.inp"
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(-0.02, 0.02, 3), np.linspace(-0.02, 0.02, 3)))
    quad8 = np.array([[0, 2, 8, 6, 1, 5, 7, 3]])
    meshio.write(path, meshio.Mesh(cylinder(x, y), [("quad8", quad8)]))
    done = export_run(cylinder_run(), Export(["calculix", "lsdyna"], tmp_path / "out", map_onto=path))
    mesh = meshio.read(done.files[0])
    assert len(mesh.points) == 8 and list(mesh.cells_dict) == ["quad8"]
    assert any("corner nodes" in note for note in done.notes)


def test_numbers_of_several_sheets_do_not_meet():
    blank = Blank.rectangle((0.0, 0.0), (0.02, 0.01), 0.005)
    parts = own_parts(stored_run(*(stored_sheet(blank, blank.node_position, name=n) for n in ("a", "b/1"))))
    assert [part.name for part in parts] == ["a", "b_1"]
    assert not set(parts[0].mesh.labels) & set(parts[1].mesh.labels)
    assert not set(parts[0].mesh.node_labels) & set(parts[1].mesh.node_labels)


@pytest.mark.parametrize(
    ("name", "wanted"), [("sheet", "sheet"), ("0°/90°", "part_0_90"), ("Lage ü", "Lage"), ("?", "part")]
)
def test_names_that_every_format_takes(name, wanted):
    assert part_name(name) == wanted
