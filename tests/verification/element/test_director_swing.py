"""Directors of neighbouring nodes that swing against each other: what frees bending, and what the hourglass mode takes.

Swung by +-theta at the nodes of a checkerboard, mean directors and curvatures shrink by cos(theta), and the hourglass
vector grows to 4 sin(theta): psi = psi_b cos^2 + 8 C_d B sin^2 (docs/theory.md, section 5; docs/decisions/0081).
"""

import math

import numpy as np
import pytest

from weavesim.fabric.bending import IsotropicBending
from weavesim.fabric.fabric import Stabilisation
from weavesim.sheet.blank import Blank

SIZE, COUNT, THICKNESS = 0.002, 6, 1.0e-3
MODULUS = 1.2e7
STIFFNESS = MODULUS * THICKNESS**3 / 12.0  # D of ``fabric``'s thickness


def cylinder(blank: Blank, turn: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Positions, normals and a tangent of elements that turn by ``turn`` [rad] each; bending energy per area."""
    radius = SIZE / turn
    x, y, _ = blank.node_position.T
    angle = x / radius
    zero = np.zeros_like(x)
    position = np.column_stack([radius * np.sin(angle), y, radius * (1.0 - np.cos(angle))])
    normal = np.column_stack([-np.sin(angle), zero, np.cos(angle)])
    # the chord of an element is shorter than its arc
    area_ratio = 2.0 * math.sin(0.5 * turn) / turn
    return position, normal, np.column_stack([zero, zero + 1.0, zero]), 0.5 * area_ratio * STIFFNESS / radius**2


def helicoid(blank: Blank, turn: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """The same of a narrow strip that twists by ``turn`` [rad] over each element, with its energy on the axis."""
    x, y, _ = blank.node_position.T
    angle = turn * x / SIZE
    cosine, sine = np.cos(angle), np.sin(angle)
    position = np.column_stack([x, y * cosine, y * sine])
    along = np.column_stack([np.ones_like(x), -y * sine * turn / SIZE, y * cosine * turn / SIZE])
    across = np.column_stack([np.zeros_like(x), cosine, sine])
    normal = np.cross(along, across)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return position, normal, across, STIFFNESS * (turn / SIZE) ** 2


def swung(sheet, fabric, share: float, shape, turn: float, angle: float) -> float:
    """Energy of a patch whose directors swing by ``angle``, over that at rest, per area of one."""
    wide = COUNT if shape is cylinder else 2
    blank = Blank.rectangle((0.0, -0.5 * wide * SIZE), (COUNT * SIZE, 0.5 * wide * SIZE), SIZE)
    position, normal, tangent, _ = shape(blank, turn)
    column, row = (np.round(blank.node_position[:, k] / SIZE).astype(int) for k in range(2))
    sign = np.where((column + row) % 2, 1.0, -1.0)[:, None]
    laws = fabric(
        bending=IsotropicBending(modulus=MODULUS, poisson_ratio=0.0), thickness=THICKNESS,
        transverse_shear_modulus=1.0e6, stabilisation=Stabilisation(in_plane=0.0, warping=0.1, director=share),
    )  # fmt: skip
    energies = [
        sheet(blank, laws).energies(position, math.cos(each) * normal + math.sin(each) * sign * tangent)
        for each in (0.0, angle)
    ]
    entries = "bending", "transverse_shear", "hourglass"
    return sum(energies[1][name] - energies[0][name] for name in entries) / (COUNT * wide * SIZE**2)


@pytest.mark.parametrize("share", [0.1, 1.0])
@pytest.mark.parametrize("angle", [0.05, 0.5, 1.5])
def test_a_swing_over_a_cylinder(share, angle, sheet, fabric):
    """The closed form, whatever the angle."""
    for turn in (0.2, 0.6, 1.2):
        *_, bending = cylinder(Blank.rectangle((0.0, 0.0), (SIZE, SIZE), SIZE), turn)
        borne = share * 2.0 / 3.0 * STIFFNESS / SIZE**2
        expected = (borne - bending) * math.sin(angle) ** 2
        assert swung(sheet, fabric, share, cylinder, turn, angle) == pytest.approx(expected, rel=0.02, abs=0.02 * borne)


@pytest.mark.parametrize("share", [0.1, 1.0])
def test_turns_from_which_a_swing_frees_energy(share, sheet, fabric, manual):
    """With a tenth, 0.365 rad over an element of a cylinder, 0.258 rad of a twist; with the whole 1.15 and 0.82."""
    limits = {cylinder: math.sqrt(4.0 / 3.0 * share), helicoid: math.sqrt(2.0 / 3.0 * share)}
    rows = []
    for shape, limit in limits.items():
        below, above = (swung(sheet, fabric, share, shape, factor * limit, 0.1) for factor in (0.9, 1.15))
        assert below > 0.0 > above
        rows.append([share, shape.__name__, math.degrees(limit), f"{below:+.2e}", f"{above:+.2e}"])
    case = manual(
        "Element", f"Directors that swing against each other, share {share:g}",
        known="Directors at the nodes of a checkerboard swing by opposite angles. From a turn over each element on, "
        "the bending that this frees is more than their hourglass mode takes, and the swing grows by itself: "
        "sqrt(4 s/3) on a cylinder, sqrt(2 s/3) in a twist, with the share s of the stabilisation. Energy of a "
        "swing by 0.1 rad at 0.9 and at 1.15 of that turn.",
    )  # fmt: skip
    case.table(["share", "shape", "limit of the turn [degrees]", "at 0.9 [J/m²]", "at 1.15 [J/m²]"], rows)
