"""Fibre directions of every deck as others read them, on a sheared sheet around a cylinder, whose yarns are known.

The mesh is oblique to both yarns, and no two sides of it lie alike: an angle that was counted from another side, about
the other normal, or on another layer would be seen. What a deck means is worked out here from its text and the rules of
its code, with nothing of the writers; pyNastran and ansys-dyna-core read the two that they know, in an environment of
their own, since pyNastran wants an older NumPy (``make readers``, or the one whose Python DECK_READERS_PYTHON names).
"""

import json
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.support.paths import ROOT
from tests.support.stored_runs import stored_run, stored_sheet
from weavesim.output.export.exporting import Export, export_run
from weavesim.sheet.blank import Blank

RADIUS, SHEAR, YARN_ANGLE = 0.1, 0.35, 30.0
REFERENCE = (0.3, 1.0, -0.2)
FORMATS = ("abaqus", "calculix", "lsdyna", "nastran", "openradioss")


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> dict[str, Path]:
    """Decks of the sheet by their names."""
    corners = np.array([(-0.05, -0.03), (0.05, -0.03), (0.05, 0.03), (-0.05, 0.03)])
    blank = Blank.fitted(corners, 0.006, mesh_angle=17.0, yarn_angle=YARN_ANGLE)
    x, y = blank.material_coordinates.T
    around = (x + SHEAR * y) / RADIUS
    position = np.column_stack([RADIUS * np.sin(around), y, RADIUS * np.cos(around)])
    folder = tmp_path_factory.mktemp("decks")
    done = export_run(stored_run(stored_sheet(blank, position)), Export(FORMATS, folder, reference=REFERENCE))
    return {path.name: path for path in done.files}


def known(centre: np.ndarray) -> np.ndarray:
    """Warp and weft of a cylinder at a place (n, 3), unit vectors (n, 2, 3): simple shear in its plane, then bent."""
    place = np.arctan2(centre[:, 0], centre[:, 2])
    around = np.column_stack([np.cos(place), np.zeros_like(place), -np.sin(place)])
    found = []
    for turn in (YARN_ANGLE, YARN_ANGLE + 90.0):
        x, y = np.cos(np.radians(turn)), np.sin(np.radians(turn))
        yarn = (x + SHEAR * y) * around + y * np.array([0.0, 1.0, 0.0])
        found.append(yarn / np.hypot(x + SHEAR * y, y))
    return np.stack(found, axis=1)


def check(elements: dict[int, list[np.ndarray]], fibres: dict[int, list[np.ndarray]]) -> None:
    """The directions of both layers are those of the yarns, up to the chord of an element.

    Args:
        elements: corners by number.
        fibres: directions of the layers by the number of the element, from below to above.
    """
    assert len(elements) > 150 and set(elements) == set(fibres)
    assert {len(layers) for layers in fibres.values()} == {2}
    order = sorted(elements)
    centre = np.array([np.mean(elements[number], axis=0) for number in order])
    found = np.array([fibres[number] for number in order])
    along = np.abs(np.einsum("eli,eli->el", found, known(centre)))
    off = np.degrees(np.arccos(np.clip(along, 0.0, 1.0)))
    # elements at the border are not flat, and their centres lie off the cylinder
    assert off.max() < 0.8 and np.median(off) < 0.2 and np.linalg.norm(found, axis=2) == pytest.approx(1.0, abs=1e-5)
    # the sides of the elements lie at all angles to the yarns: the agreement is none of the mesh
    side = np.array([elements[number][1] - elements[number][0] for number in order])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    apart = np.degrees(np.arccos(np.abs(np.einsum("ei,ei->e", side, found[:, 0]))))
    assert np.ptp(apart) > 20.0 and np.median(apart) > 5.0


def turned(start: np.ndarray, corners: list[np.ndarray], angle: float) -> np.ndarray:
    """A direction laid onto an element and turned about its normal, counter-clockwise, by an angle [degrees].

    By Rodrigues' formula; the corners run counter-clockwise about the normal.
    """
    normal = np.zeros(3)
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):  # Newell
        normal += np.cross(a, b)
    normal /= np.linalg.norm(normal)
    start = start - normal * (start @ normal)
    start /= np.linalg.norm(start)
    turn = np.radians(angle)
    return start * np.cos(turn) + np.cross(normal, start) * np.sin(turn)


def block(lines: list[str], head: str, ends: str = "*") -> list[str]:
    """Lines of a deck after its first one that begins with ``head``, up to the next keyword."""
    first = next(k for k, line in enumerate(lines) if line.startswith(head)) + 1
    last = next((k for k in range(first, len(lines)) if lines[k].startswith(ends)), len(lines))
    return lines[first:last]


@pytest.mark.parametrize("code", ["abaqus", "calculix"])
def test_abaqus_and_calculix_have_the_directions_themselves(files, code):
    """*ORIENTATION, SYSTEM=RECTANGULAR: a point on axis 1 and one in the plane of 1 and 2; 3, 0. turns by nothing."""
    lines = files[f"test_{code}.inp"].read_text().splitlines()
    nodes = {int(f[0]): np.array(f[1:], dtype=float) for f in (line.split(",") for line in block(lines, "*NODE"))}
    corners = {
        int(f[0]): [nodes[int(n)] for n in f[1:5]] for f in (line.split(",") for line in block(lines, "*ELEMENT"))
    }
    axes, sections, members = {}, {}, {}
    for k, line in enumerate(lines):
        if line.startswith("*ORIENTATION"):
            name = re.search(r"NAME=(\w+)", line)[1]
            first, second = np.array(lines[k + 1].split(","), dtype=float).reshape(2, 3)
            assert lines[k + 2].replace(" ", "") == "3,0."
            # the third axis is the normal, so that axis 1 lies in the element
            axes[name] = first, np.cross(first, second)
        if line.startswith("*ELSET"):
            members[re.search(r"ELSET=(\w+)", line)[1]] = int(lines[k + 1])
        if line.startswith("*SHELL SECTION, COMPOSITE"):
            rows = block(lines[k:], "*SHELL")
            sections[re.search(r"ELSET=(\w+)", line)[1]] = [[cell.strip() for cell in row.split(",")] for row in rows]
    fibres = {members[name]: [axes[row[3]][0] for row in rows] for name, rows in sections.items()}
    for name, rows in sections.items():
        p = corners[members[name]]
        assert all(axes[row[3]][1] @ np.cross(p[2] - p[0], p[3] - p[1]) > 0.0 for row in rows)
        assert sum(float(row[0]) for row in rows) == pytest.approx(1e-3)
    check(corners, fibres)


def test_lsdyna_has_angles_from_the_first_side(files):
    """*ELEMENT_SHELL_COMPOSITE: B turns the material axes, which AOPT = 0 takes from N1 to N2, about the normal."""
    lines = files["test.k"].read_text().splitlines()
    nodes = {
        int(line[:8]): np.array([line[8 + 16 * k : 24 + 16 * k] for k in range(3)], dtype=float)
        for line in block(lines, "*NODE")
    }
    material = block(lines, "*MAT_ORTHOTROPIC_ELASTIC")
    assert float(material[1][30:40]) == 0.0  # AOPT, the fourth of the second card
    corners, fibres = {}, {}
    for line, layers in zip(*[iter(block(lines, "*ELEMENT_SHELL_COMPOSITE"))] * 2, strict=True):
        number, numbers = int(line[:8]), [int(line[k : k + 8]) for k in range(16, 48, 8)]
        corners[number] = [nodes[n] for n in dict.fromkeys(numbers)]
        angles = [float(layers[k + 20 : k + 30]) for k in (0, 40)]
        fibres[number] = [turned(corners[number][1] - corners[number][0], corners[number], a) for a in angles]
    check(corners, fibres)


def python_of_readers() -> str | None:
    own = ROOT / ".venv-readers" / "bin" / "python"
    return os.environ.get("DECK_READERS_PYTHON") or (str(own) if own.exists() else None)


@pytest.mark.skipif(python_of_readers() is None, reason="pyNastran and ansys-dyna-core are not there: make readers")
@pytest.mark.parametrize(("code", "name"), [("nastran", "test.bdf"), ("lsdyna", "test.k")])
def test_packages_of_others_find_the_directions(files, code, name):
    """pyNastran's material axes of every element, and the fields of every card as ansys-dyna-core names them."""
    script = ROOT / "tests" / "support" / "deck_readers.py"
    command = [str(python_of_readers()), str(script), code, str(files[name])]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    found = {int(number): element for number, element in json.loads(done.stdout).items()}
    assert all(element["thickness"] == pytest.approx(1e-3) for element in found.values())
    check(
        {number: [np.array(corner) for corner in element["corners"]] for number, element in found.items()},
        {number: [np.array(fibre) for fibre in element["fibres"]] for number, element in found.items()},
    )


def test_nastran_has_angles_from_the_first_side(files):
    """PCOMP: the angle of a layer turns about the normal, from G1 to G2 where THETA of the element is blank."""
    lines = files["test.bdf"].read_text().splitlines()
    nodes, corners = nastran_mesh(lines)
    fibres: dict[int, list[np.ndarray]] = {}
    for k, line in enumerate(lines):
        if line.startswith("PCOMP*"):
            number = int(line[8:24])
            layers = [row for row in lines[k + 2 : k + 4] if row.startswith("*")]
            assert sum(float(row[24:40]) for row in layers) == pytest.approx(1e-3)
            p = corners[number]
            fibres[number] = [turned(p[1] - p[0], p, float(row[40:56])) for row in layers]
    check(corners, fibres)


def nastran_mesh(lines: list[str]) -> tuple[dict[int, np.ndarray], dict[int, list[np.ndarray]]]:
    """Nodes, and corners of the quadrilaterals without THETA, of bulk data in the fields that are used here."""
    nodes: dict[int, np.ndarray] = {}
    for first, second in zip(lines, lines[1:], strict=False):
        if first.startswith("GRID*"):
            cells = [first[40:56], first[56:72], second[8:24]]
            nodes[int(first[8:24])] = np.array(cells, dtype=float)
    quads = [line for line in lines if line.startswith("CQUAD4")]
    assert quads and all(len(line) == 56 for line in quads)
    return nodes, {int(line[8:16]): [nodes[int(line[k : k + 8])] for k in range(24, 56, 8)] for line in quads}


def test_openradioss_counts_from_the_vector_of_the_property(files):
    """/DRAPE: the angle about the normal from the projection of (VX, VY, VZ) onto the element."""
    lines = [line for line in files["test_0000.rad"].read_text().splitlines() if not line.startswith("#")]
    nodes = {
        int(line[:10]): np.array([line[10 + 20 * k : 30 + 20 * k] for k in range(3)], dtype=float)
        for line in block(lines, "/NODE", "/")
    }
    corners: dict[int, list[np.ndarray]] = {}
    for kind, count in (("/SHELL/", 4), ("/SH3N/", 3)):
        if any(line.startswith(kind) for line in lines):
            for line in block(lines, kind, "/"):
                numbers = [int(line[k : k + 10]) for k in range(10, 10 + 10 * count, 10)]
                corners[int(line[:10])] = [nodes[n] for n in numbers]
    fibres: dict[int, list[np.ndarray]] = {number: [] for number in corners}
    for layer in ("/DRAPE/1", "/DRAPE/2"):
        for line in block(lines, layer, "/")[1:]:
            number, thinning, angle = int(line[10:20]), float(line[20:40]), float(line[40:60])
            assert thinning == pytest.approx(1.0)
            fibres[number].append(turned(np.array(REFERENCE), corners[number], angle))
    check(corners, fibres)


def test_optistruct_counts_from_the_first_side(files):
    """DRAPE: thinning and angle of each element, on the mesh of the same export for Nastran."""
    _, corners = nastran_mesh(files["test.bdf"].read_text().splitlines())
    fibres: dict[int, list[np.ndarray]] = {number: [] for number in corners}
    for line in files["test_drape.fem"].read_text().splitlines():
        if line[8:16].strip() == "ELEM":
            number, thinning, angle = int(line[16:24]), float(line[24:32]), float(line[32:40])
            assert thinning == pytest.approx(1.0)
            p = corners[number]
            fibres[number].append(turned(p[1] - p[0], p, angle))
    check(corners, fibres)
