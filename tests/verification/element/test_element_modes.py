"""What one element, and two, let happen without resistance."""

import numpy as np
import pytest

from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.cell.weaves import PlainWeave
from weavesim.fabric.fabric import Stabilisation
from weavesim.fabric.shear import LinearShear
from weavesim.sheet.blank import Blank

ALL_TERMS = {
    "unit_cell": PlainWeave.straight(stiffness_per_width=1.0e4),
    "shear": LinearShear(modulus=4.0e6),
    "bending": IsotropicBending(modulus=5.0e7, poisson_ratio=0.2),
    "transverse_shear_modulus": 4.0e6,
}
QUAD = np.array([[0.0, 0.0, 0.0], [0.011, 0.001, 0.0], [0.012, 0.009, 0.0], [-0.001, 0.01, 0.0]])
TWO = np.vstack([QUAD, [[0.021, -0.001, 0.0], [0.022, 0.011, 0.0]]])


def blank_of(position: np.ndarray) -> Blank:
    quads = [[0, 1, 2, 3], [1, 4, 5, 2]][: len(position) // 2 - 1]
    return Blank.from_mesh(position, quads, yarn_angle=20.0)


def modes(sheet_of, fabric, blank):
    """Eigenvalues and eigenvectors with all lengths in units of a centimetre, so that every mode counts alike."""
    sheet = sheet_of(blank, fabric)
    stiffness = sheet.stiffness(blank.node_position, blank.initial_director, 1e-7)
    assert np.abs(stiffness - stiffness.T).max() < 1e-5 * np.abs(stiffness).max()
    unit = np.tile([0.01, 0.01, 0.01, 1.0, 1.0], blank.node_count)
    return np.linalg.eigh(0.5 * (stiffness + stiffness.T) * np.outer(unit, unit))


def zero_mode_count(values: np.ndarray) -> int:
    """Number of vanishing eigenvalues; there must be a gap of three orders above them and nothing negative."""
    size = np.sort(np.abs(values)) / np.abs(values).max()
    count = int((size < 1e-8).sum())
    assert size[count] > 1e-5
    assert values.min() > -1e-8 * values.max()
    return count


def test_zero_modes_are_recorded(sheet, fabric, manual):
    case = manual(
        "Element", "Zero-energy modes",
        known="20 free components and eight strains leave twelve modes of one element without stabilisation; five "
        "hourglass strains leave seven with it, six rigid ones and the in-plane twist of the directors; two connected "
        "elements have the six rigid ones only. Eigenvalues of the tangent at rest; the gap is the smallest of the "
        "others over the largest.",
    )  # fmt: skip
    rows = []
    for name, quads, share, count in (("one, plain", QUAD, 0.0, 12), ("one, stabilised", QUAD, 0.1, 7),
                                      ("two, stabilised", TWO, 0.1, 6)):  # fmt: skip
        stabilisation = Stabilisation(in_plane=share, warping=share, director=share)
        values, _ = modes(sheet, fabric(**ALL_TERMS, stabilisation=stabilisation), blank_of(quads))
        found = zero_mode_count(values)
        size = np.sort(np.abs(values)) / np.abs(values).max()
        rows.append([name, count, found, f"{size[found - 1]:.1e}", f"{size[found]:.1e}"])
        assert found == count
    case.table(["elements", "expected", "found", "largest zero", "gap"], rows)


@pytest.mark.parametrize(("share", "count"), [(0.0, 12), (0.1, 7)], ids=["plain", "stabilised"])
def test_zero_modes_of_one_element(share, count, sheet, fabric):
    stabilisation = Stabilisation(in_plane=share, warping=share, director=share)
    values, _ = modes(sheet, fabric(**ALL_TERMS, stabilisation=stabilisation), blank_of(QUAD))
    assert len(values) == 20
    assert zero_mode_count(values) == count


def test_seventh_mode_is_the_in_plane_twist_of_the_directors(sheet, fabric):
    """No displacement but the rigid ones, and directors that turn against each other across the diagonals."""
    blank = blank_of(QUAD)
    values, vectors = modes(sheet, fabric(**ALL_TERMS, stabilisation=Stabilisation()), blank)
    null = vectors[:, :7]
    # rigid motions in the same units: displacements in centimetres, directors turn as the sheet does
    x = blank.node_position * 100.0
    rigid = []
    for axis in np.eye(3):
        rigid.append(np.column_stack([np.tile(axis, (4, 1)), np.zeros((4, 2))]))
        first = np.cross(blank.initial_director, [1.0, 0.0, 0.0])
        second = np.cross(blank.initial_director, first)
        rigid.append(np.column_stack([np.cross(axis, x), first @ axis, second @ axis]))
    rigid, _ = np.linalg.qr(np.array([mode.ravel() for mode in rigid]).T)
    assert np.abs(rigid - null @ (null.T @ rigid)).max() < 1e-5
    left = null - rigid @ (rigid.T @ null)
    seventh = np.linalg.svd(left)[0][:, 0].reshape(4, 5)
    assert np.abs(seventh[:, :3]).max() < 1e-5
    turns = seventh[:, 3:]
    assert np.abs(turns.sum(axis=0)).max() < 1e-5
    # mean curvature k_11 + k_22 and twist are absent: directors swirl about the middle, d_i along e_z x x_i
    swirl = np.cross(seventh[:, 3:4] * first + seventh[:, 4:5] * second, blank.initial_director)
    around = np.cross([0.0, 0.0, 1.0], x - x.mean(axis=0))
    cosine = np.sum(swirl * around) / np.linalg.norm(swirl) / np.linalg.norm(around)
    assert abs(cosine) > 0.98


def test_two_elements_have_only_rigid_motions(sheet, fabric):
    values, _ = modes(sheet, fabric(**ALL_TERMS, stabilisation=Stabilisation()), blank_of(TWO))
    assert zero_mode_count(values) == 6


def test_stabilisation_does_not_stiffen_shear(sheet, fabric):
    """The in-plane stabilisation scales with the shear stiffness: stiffer yarns must not change it."""
    blank = blank_of(QUAD)
    odd = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]) * 1e-4
    energies = []
    for stiffness in (1.0e4, 1.0e6):
        laws = fabric(**(ALL_TERMS | {"unit_cell": PlainWeave.straight(stiffness_per_width=stiffness)}),
                      stabilisation=Stabilisation())  # fmt: skip
        energies.append(sheet(blank, laws).energies(blank.node_position + odd, blank.initial_director)["hourglass"])
    assert energies[0] == pytest.approx(energies[1], rel=1e-12)
    assert energies[0] > 0.0
