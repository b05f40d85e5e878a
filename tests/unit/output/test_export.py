"""Decks: read back by other readers, and run by CalculiX where it is installed."""

import dataclasses
import re
import shutil
import subprocess

import meshio
import numpy as np
import pytest

from tests.support.stored_runs import THICKNESS, stored_run, stored_sheet
from weavesim.errors import InputError
from weavesim.output.export.exporting import FORMATS, Export, export_run
from weavesim.output.export.lamina import ASSUMED, Lamina
from weavesim.output.stored.values import ElementValue
from weavesim.sheet.blank import Blank
from weavesim.sheet.symmetry import Symmetry

LENGTH, WIDTH, FORCE = 0.1, 0.01, 0.01
WARP_DEG, SHEAR_DEG = 20.0, 35.0


def sheared_run(warp_deg: float = WARP_DEG, shear_deg: float = SHEAR_DEG, size: float = 0.0025):
    """A flat strip whose yarns are at ``warp_deg`` to its length, and 90 degrees less ``shear_deg`` to each other."""
    blank = Blank.rectangle((0.0, 0.0), (LENGTH, WIDTH), size)
    sheet = stored_sheet(blank, blank.node_position)
    yarns = {"warp": np.deg2rad(warp_deg), "weft": np.deg2rad(warp_deg + 90.0 - shear_deg)}
    values = {
        f"{name}_direction": ElementValue("1", "x", np.tile([np.cos(a), np.sin(a), 0.0], (blank.element_count, 1)))
        for name, a in yarns.items()
    }
    return stored_run(dataclasses.replace(sheet, values=dict(sheet.values) | values))


def written(tmp_path, *formats, run=None, **wish):
    """Files by their ending."""
    done = export_run(run or sheared_run(), Export(formats, tmp_path, **wish))
    return {path.suffix: path for path in done.files}


def compliance(angles, thickness):
    """Inverse of the ABD matrix of classical lamination theory, of ``ASSUMED`` layers from the bottom up."""
    e1, e2, nu, g = ASSUMED.modulus_along, ASSUMED.modulus_across, ASSUMED.poisson_ratio, ASSUMED.shear_modulus
    share = 1.0 - nu * nu * e2 / e1
    q = np.array([[e1 / share, nu * e2 / share, 0.0], [nu * e2 / share, e2 / share, 0.0], [0.0, 0.0, g]])
    a, b, d, z = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), -0.5 * thickness * len(angles)
    for angle in np.deg2rad(angles):
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c * c, s * s, 2 * c * s], [s * s, c * c, -2 * c * s], [-c * s, c * s, c * c - s * s]])
        engineering = np.diag([1.0, 1.0, 2.0])
        bar = np.linalg.inv(turn) @ q @ engineering @ turn @ np.linalg.inv(engineering)
        top = z + thickness
        a, b, d = a + bar * thickness, b + bar * (top**2 - z**2) / 2, d + bar * (top**3 - z**3) / 3
        z = top
    return np.linalg.inv(np.block([[a, b], [b, d]]))


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
@pytest.mark.parametrize(
    ("warp_deg", "shear_deg", "layers", "tolerance"),
    [(0.0, 0.0, 2, 0.01), (0.0, 23.0, 2, 0.015), (90.0, 0.0, 1, 0.01), (30.0, 20.0, 2, 0.04), (45.0, 0.0, 2, 0.06)],
)
def test_calculix_bends_the_exported_strip_as_lamination_theory_does(tmp_path, warp_deg, shear_deg, layers, tolerance):
    """A cantilever under a force at its end: the tip goes down by F L^3 d_11 / 3 W; clamping holds the twist a bit."""
    deck = written(tmp_path, "calculix", run=sheared_run(warp_deg, shear_deg), layers_per_ply=layers, lamina=ASSUMED)[
        ".inp"
    ]
    nodes = meshio.read(deck).points
    ends = {name: np.flatnonzero(np.isclose(nodes[:, 0], x)) + 1 for name, x in (("ROOT", 0.0), ("TIP", LENGTH))}
    lines = [f"*INCLUDE, INPUT={deck.name}"]
    for name, labels in ends.items():
        lines += [f"*NSET, NSET={name}", *(f"{label}," for label in labels)]
    lines += ["*BOUNDARY", "ROOT, 1, 6", "*STEP", "*STATIC", "*CLOAD"]
    lines += [f"{label}, 3, {FORCE / len(ends['TIP'])}" for label in ends["TIP"]]
    lines += ["*NODE PRINT, NSET=TIP", "U", "*END STEP", ""]
    (tmp_path / "job.inp").write_text("\n".join(lines))
    done = subprocess.run(["ccx", "job"], cwd=tmp_path, capture_output=True, text=True, timeout=100)
    assert "Job finished" in done.stdout, done.stdout[-2000:]
    rows = [line.split() for line in (tmp_path / "job.dat").read_text().splitlines()]
    tip = np.mean([float(row[3]) for row in rows if len(row) == 4])
    angles = [warp_deg, warp_deg + 90.0 - shear_deg][:layers]
    wanted = FORCE / WIDTH * LENGTH**3 / 3.0 * compliance(angles, THICKNESS / layers)[3, 3]
    assert tip == pytest.approx(wanted, rel=tolerance)


@pytest.mark.parametrize(("name", "kind"), [("abaqus", "quad"), ("calculix", "quad8")])
def test_a_deck_for_abaqus_or_calculix_reads_back(tmp_path, name, kind):
    run = sheared_run()
    deck = written(tmp_path, name, run=run)[".inp"]
    mesh, sheet = meshio.read(deck), run.sheets[0]
    assert list(mesh.cells_dict) == [kind]
    assert mesh.points[: sheet.blank.node_count] == pytest.approx(sheet.position, abs=1e-9)
    assert np.array_equal(mesh.cells_dict[kind][:, :4], sheet.blank.quads)
    text = deck.read_text()
    axes = re.findall(r"\*ORIENTATION, NAME=O\d+_(\d), SYSTEM=RECTANGULAR\n(.*)\n3, 0\.\n", text)
    assert len(axes) == 2 * sheet.blank.element_count
    for number, angle in (("1", WARP_DEG), ("2", WARP_DEG + 90.0 - SHEAR_DEG)):
        first, second = np.split(np.array(next(a[1] for a in axes if a[0] == number).split(","), dtype=float), 2)
        assert first == pytest.approx([np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle)), 0.0], abs=1e-6)
        assert np.cross(first, second) == pytest.approx([0.0, 0.0, 1.0], abs=1e-6)
    layers = re.findall(r"\*SHELL SECTION, COMPOSITE, ELSET=SHEET_7\n(.*)\n(.*)\n", text)
    assert layers == [("0.0005, , YARNS, O7_1", "0.0005, , YARNS, O7_2")]


def test_millimetres_have_their_stresses_and_densities(tmp_path):
    deck = written(tmp_path, "abaqus", unit="mm")[".inp"]
    assert meshio.read(deck).points.max() == pytest.approx(1e3 * LENGTH)
    text = deck.read_text()
    assert "26500, 3500, 3500, 0.3, 0.3, 0.45, 1200, 1200,\n1200\n*DENSITY\n1.48e-09\n" in text


def test_a_deck_for_nastran_reads_back(tmp_path):
    run = sheared_run()
    deck = written(tmp_path, "nastran", run=run)[".bdf"]
    mesh, sheet = meshio.read(deck), run.sheets[0]
    assert mesh.points == pytest.approx(sheet.position, abs=1e-9)
    assert np.array_equal(mesh.cells_dict["quad"], sheet.blank.quads)
    # every element has the property of its own number, whose fields are sixteen columns wide
    assert np.array_equal(mesh.cell_data["nastran:ref"][0], np.arange(1, sheet.blank.element_count + 1))
    card = re.search(r"^PCOMP\* +5\n\* *\n(\*.*)\n(\*.*)\n", deck.read_text(), re.MULTILINE)
    values = [[float(line[k : k + 16]) for k in (8, 24, 40)] for line in card.groups()]
    wanted = [[1.0, 0.5e-3, WARP_DEG], [1.0, 0.5e-3, WARP_DEG + 90.0 - SHEAR_DEG]]
    np.testing.assert_allclose(values, wanted, rtol=1e-6)


def test_a_deck_for_lsdyna_reads_back(tmp_path):
    reader = pytest.importorskip("lsdyna_mesh_reader")
    run = sheared_run()
    path, sheet = written(tmp_path, "lsdyna", run=run)[".k"], run.sheets[0]
    deck = reader.Deck(str(path))
    assert deck.node_sections[0].coordinates == pytest.approx(sheet.position, abs=1e-8)
    lines = path.read_text().splitlines()
    first = lines.index("*ELEMENT_SHELL_COMPOSITE") + 1
    assert len(lines) == first + 2 * sheet.blank.element_count + 1
    columns = [int(lines[first][k : k + 8]) for k in range(0, 48, 8)]
    assert columns == [1, 1, *(sheet.blank.quads[0] + 1)]
    layers = [lines[first + 1][k : k + 10] for k in range(0, 70, 10)]
    assert [int(layers[0]), int(layers[4])] == [1, 1] and not layers[3].strip()
    assert [float(layers[k]) for k in (1, 2)] == pytest.approx([0.5e-3, WARP_DEG])
    assert [float(layers[k]) for k in (5, 6)] == pytest.approx([0.5e-3, WARP_DEG + 90.0 - SHEAR_DEG])


def test_the_drape_tables_have_thinning_and_angle_of_every_layer(tmp_path):
    run = sheared_run()
    sheet = run.sheets[0]
    thin = dataclasses.replace(
        sheet, values=dict(sheet.values) | {"thickness": ElementValue("m", "", np.full(160, 0.9 * THICKNESS))}
    )
    files = written(tmp_path, "openradioss", run=stored_run(thin), reference=(0.0, 1.0, 0.0))
    text = files[".rad"].read_text()
    blocks = re.findall(r"/DRAPE/(\d)\n.*\n((?:SHELL.*\n)+)", text)
    assert [number for number, _ in blocks] == ["1", "2"]
    for (_, rows), angle in zip(blocks, (WARP_DEG - 90.0, WARP_DEG - SHEAR_DEG), strict=True):
        line = rows.splitlines()[6]
        assert line[:10].strip() == "SHELL" and int(line[10:20]) == 7
        assert float(line[20:40]) == pytest.approx(0.9) and float(line[40:60]) == pytest.approx(angle)
    # OptiStruct counts from the side of the element
    card = files[".fem"].read_text().splitlines()
    assert [card[9][8:16].strip(), int(card[9][16:24])] == ["ELEM", 7]
    assert [float(card[9][24:32]), float(card[9][32:40])] == pytest.approx([0.9, WARP_DEG])
    with pytest.raises(InputError, match="within 5 degrees of the normal of 160 elements"):
        written(tmp_path, "openradioss", run=run, reference=(0.0, 0.0, 2.0))


def test_one_layer_per_ply_needs_constants_of_a_weave(tmp_path):
    with pytest.raises(InputError, match="for which no constants are assumed"):
        written(tmp_path, "abaqus", layers_per_ply=1)
    text = written(tmp_path, "abaqus", layers_per_ply=1, lamina=ASSUMED)[".inp"].read_text()
    assert text.count("*ORIENTATION") == 160 and "0.001, , YARNS, O7_1" in text


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        ({"formats": ["ansys"]}, "'ansys': choose from calculix, abaqus"),
        ({"formats": []}, "at least one is needed"),
        ({"unit": "inch"}, "choose from m, mm"),
        ({"layers_per_ply": 3}, "2 .warp and weft apart. or 1"),
        ({"within": -1.0}, "a positive length"),
        ({"within": 0.1}, "only with a mesh to map onto"),
        ({"reference": (0.0, 0.0, 0.0)}, "a direction is needed"),
    ],
)
def test_a_wish_that_cannot_be_met_is_told(tmp_path, wish, message):
    with pytest.raises(InputError, match=message):
        Export(**({"formats": ["csv"], "folder": tmp_path} | wish))


def test_every_format_writes_something_and_says_that_constants_are_assumed(tmp_path):
    done = export_run(sheared_run(size=0.005), Export(list(FORMATS), tmp_path))
    assert len({path.name for path in done.files}) == len(done.files) == len(FORMATS) + 1
    assert all(path.stat().st_size for path in done.files)
    assert any("ASSUMED" in note for note in done.notes)


def test_a_part_cut_at_symmetry_is_said_and_made_whole(tmp_path):
    blank = Blank.rectangle((0.0, 0.0), (0.03, 0.02), 0.01, yarn_angle=30.0)
    sheet = stored_sheet(blank, blank.node_position, symmetry=Symmetry(("x", "y")))
    done = export_run(stored_run(sheet), Export(["abaqus"], tmp_path))
    assert any("--whole" in note for note in done.notes)
    mesh = meshio.read(written(tmp_path, "abaqus", run=stored_run(sheet), whole=True)[".inp"])
    # the nodes on the planes are shared
    assert len(mesh.points) == 7 * 5 and len(mesh.cells_dict["quad"]) == 24
    corner = mesh.points[mesh.cells_dict["quad"]]
    assert (np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])[:, 2] > 0.0).all()


def test_constants_come_from_a_file(tmp_path):
    path = tmp_path / "lamina.toml"
    path.write_text(
        "modulus_along = 4e10\nmodulus_across = 9e9\npoisson_ratio = 0.3\nshear_modulus = 4e9\n"
        "shear_modulus_across = 3e9\ndensity = 1900\n"
    )
    assert Lamina.from_file(path).modulus_along == 4e10
    path.write_text(path.read_text().replace("0.3", "0.99").replace("9e9", "4e10"))
    with pytest.raises(InputError, match="would release energy"):
        Lamina.from_file(path)
    path.write_text(
        "modulus_along = 40\nmodulus_across = 9\npoisson_ratio = 0.3\nshear_modulus = 4\n"
        "shear_modulus_across = 3\ndensity = 1900\n"
    )
    with pytest.raises(InputError, match="modulus_along = 40 Pa: usual are .* write 4e.10 for 40 GPa") as refused:
        Lamina.from_file(path)
    assert "accept_unusual = true" in str(refused.value)
    path.write_text("accept_unusual = true\n" + path.read_text())
    assert Lamina.from_file(path).modulus_along == 40.0
    path.write_text("modulus = 1.0\n")
    with pytest.raises(InputError, match="modulus"):
        Lamina.from_file(path)
